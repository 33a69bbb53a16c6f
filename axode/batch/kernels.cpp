// Compiled for one instruction set. Nothing here may be a function that code for another processor has as
// well: every template is one of Batch<AXODE_T, AXODE_LANES>, which no other instruction set uses.
#include "axode/batch/kernels.hpp"

#include "axode/batch/transpose.hpp"
#include "axode/derivatives/first_order.hpp"
#include "axode/derivatives/inverse_dynamics_products.hpp"
#include "axode/fast/articulated_bodies.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/fast/inverse_mass_matrix.hpp"
#include "axode/integration/munthe_kaas.hpp"
#include "axode/model/workspace.hpp"

#ifndef AXODE_ISA  // as an editor sees it
#define AXODE_ISA sse2
#define AXODE_T double
#define AXODE_LANES 2
#endif

namespace axode::batch {
namespace {

using S = AXODE_T;
constexpr int lanes = AXODE_LANES;
using Number = Batch<S, lanes>;
using G = Plain<Number>;

/// Numbers of the states of a call: what it is given, and what it makes.
struct Room {
  Number *q, *v, *a, *out;
  Room(Arena& arena, std::size_t results)
      : q(arena.array<Number>(static_cast<std::size_t>(arena.topology().nq))),
        v(arena.per_velocity<Number>()),
        a(arena.per_velocity<Number>()),
        out(arena.array<Number>(results)) {}
};
std::size_t n_velocities(Arena& arena) { return static_cast<std::size_t>(arena.topology().nv); }
/// With a number, or with a matrix, for each velocity.
struct VectorRoom : Room {
  explicit VectorRoom(Arena& arena) : Room(arena, n_velocities(arena)) {}
};
struct MatrixRoom : Room {
  explicit MatrixRoom(Arena& arena) : Room(arena, n_velocities(arena) * n_velocities(arena)) {}
};

struct InverseDynamics : VectorRoom {
  FastInverseDynamics<G, Number> recursion;
  explicit InverseDynamics(Arena& arena) : VectorRoom(arena), recursion(arena) {}
};
using ArticulatedBodies = FastArticulatedBodies<G, Number>;
struct ForwardDynamics : VectorRoom {
  ArticulatedBodies bodies;
  ArticulatedBodies::Motion* motion;
  explicit ForwardDynamics(Arena& arena)
      : VectorRoom(arena), bodies(arena), motion(arena.per_body<ArticulatedBodies::Motion>()) {}
};
struct MassMatrix : MatrixRoom {
  FastCompositeBodies<Number> bodies;
  explicit MassMatrix(Arena& arena) : MatrixRoom(arena), bodies(arena) {}
};
struct InverseByFactors : MassMatrix {
  FastInverseMassMatrix<Number> inverse;
  explicit InverseByFactors(Arena& arena) : MassMatrix(arena), inverse(arena) {}
};
struct InverseByBodies : MatrixRoom {
  ArticulatedBodies bodies;
  ArticulatedBodies::Columns* columns;
  Number* u;
  explicit InverseByBodies(Arena& arena)
      : MatrixRoom(arena),
        bodies(arena),
        columns(arena.per_body<ArticulatedBodies::Columns>()),
        u(arena.per_screw<Number>()) {}
};
struct Poses : VectorRoom {
  SE3<Number>* body;
  FastPoses<Number> poses;
  explicit Poses(Arena& arena) : VectorRoom(arena), body(arena.per_body<SE3<Number>>()), poses(arena) {}
};
/// A direction, and results of derivatives: matrices, or vectors, for each of three directions.
struct Directions {
  Number *dq, *dv, *da;
  explicit Directions(Arena& arena)
      : dq(arena.per_velocity<Number>()),
        dv(arena.per_velocity<Number>()),
        da(arena.per_velocity<Number>()) {}
};
struct InverseDerivatives : Room {
  FirstOrder<Number> first_order;
  explicit InverseDerivatives(Arena& arena)
      : Room(arena, 3 * n_velocities(arena) * n_velocities(arena)), first_order(arena) {}
};
struct InverseJvp : VectorRoom, Directions {
  InverseDynamicsJvp<Number> jvp;
  explicit InverseJvp(Arena& arena) : VectorRoom(arena), Directions(arena), jvp(arena) {}
};
struct InverseVjp : VectorRoom, Directions {
  InverseDynamicsVjp<Number> vjp;
  explicit InverseVjp(Arena& arena) : VectorRoom(arena), Directions(arena), vjp(arena) {}
};
/// The same at the accelerations that forces make, and M⁻¹ after it.
template <class Inverse> struct Forward : Inverse {
  ArticulatedBodies bodies;
  ArticulatedBodies::Motion* motion;
  ArticulatedBodies::Columns* columns;
  Number *u, *acceleration, *zero;

  explicit Forward(Arena& arena)
      : Inverse(arena),
        bodies(arena),
        motion(arena.per_body<ArticulatedBodies::Motion>()),
        columns(arena.per_body<ArticulatedBodies::Columns>()),
        u(arena.per_screw<Number>()),
        acceleration(arena.per_velocity<Number>()),
        zero(arena.per_velocity<Number>()) {}
  void accelerate(const Tree<S>& tree) noexcept {
    bodies.place_and_move(tree, this->q, this->v, motion);
    bodies.factorize(tree, this->a);
    bodies.accelerate(tree, motion, acceleration);
  }
};

/// Memory that a kernel needs.
template <class Room> std::size_t bytes(const Tree<S>& tree) { return footprint<Room>(*tree.topology()); }
std::size_t bytes_of_inverse(const Tree<S>& tree) {
  return FastInverseMassMatrix<Number>::suits(tree) ? bytes<InverseByFactors>(tree)
                                                    : bytes<InverseByBodies>(tree);
}

std::size_t n_entries(const Tree<S>& tree) {
  return static_cast<std::size_t>(tree->nv) * static_cast<std::size_t>(tree->nv);
}

/// Bit l for lane l.
unsigned bits(const Number::Mask& mask) {
  unsigned all = 0;
  for (unsigned l = 0; l < lanes; ++l) all |= static_cast<unsigned>(mask[l]) << l;
  return all;
}

void inverse_dynamics(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* a, S* tau) noexcept {
  InverseDynamics at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(a, tree->nv, at.a);
  for (int c = 0; c < tree->nv; ++c) at.out[c] = Number(tree.armature[c]) * at.a[c];
  at.recursion.forward(tree, at.q, at.v, at.a, cast<Number>(tree.g));
  at.recursion.backward(tree, at.out);
  scatter(at.out, tree->nv, tau);
}

unsigned forward_dynamics(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* tau,
                          S* a) noexcept {
  ForwardDynamics at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(tau, tree->nv, at.a);
  at.bodies.place_and_move(tree, at.q, at.v, at.motion);
  at.bodies.factorize(tree, at.a);
  at.bodies.accelerate(tree, at.motion, at.out);
  scatter(at.out, tree->nv, a);
  return bits(at.bodies.doubtful);
}

void mass_matrix(const Tree<S>& tree, Arena arena, const S* q, S* M) noexcept {
  MassMatrix at(arena);
  gather(q, tree->nq, at.q);
  at.bodies.run(tree, at.q);
  at.bodies.write(tree, at.out);
  scatter(at.out, n_entries(tree), M);
}

unsigned inverse_mass_matrix(const Tree<S>& tree, Arena arena, const S* q, S* M_inverse) noexcept {
  if (FastInverseMassMatrix<Number>::suits(tree)) {
    InverseByFactors at(arena);
    gather(q, tree->nq, at.q);
    at.bodies.run(tree, at.q);
    at.bodies.write_paths(tree, at.out);
    at.inverse.run(tree, at.out);
    scatter(at.out, n_entries(tree), M_inverse);
    return bits(at.inverse.doubtful);
  }
  InverseByBodies at(arena);
  gather(q, tree->nq, at.q);
  at.bodies.place(tree, at.q);
  at.bodies.factorize(tree);
  at.bodies.inverse(tree, at.columns, at.u, at.out);
  scatter(at.out, n_entries(tree), M_inverse);
  return bits(at.bodies.doubtful);
}

/// Three matrices, one behind the other, from FirstOrder.
void write(const Tree<S>& tree, FirstOrder<Number>& first_order, Number* out) noexcept {
  const std::size_t n = n_entries(tree);
  first_order.write(tree, {}, out, out + n, out + 2 * n);
}
void inverse_dynamics_derivatives(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* a,
                                  S* dtau) noexcept {
  InverseDerivatives at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(a, tree->nv, at.a);
  at.first_order.run(tree, at.q, at.v, at.a, {});
  write(tree, at.first_order, at.out);
  scatter(at.out, 3 * n_entries(tree), dtau);
}
unsigned forward_dynamics_derivatives(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* tau,
                                      S* da) noexcept {
  Forward<InverseDerivatives> at(arena);
  const std::size_t n = n_entries(tree);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(tau, tree->nv, at.a);
  at.accelerate(tree);
  at.first_order.run(tree, at.q, at.v, at.acceleration, {});
  write(tree, at.first_order, at.out);
  for (std::size_t k = 0; k < 2 * n; ++k) at.out[k] = -at.out[k];
  at.bodies.solve(tree, at.columns, at.u, at.out);
  at.bodies.solve(tree, at.columns, at.u, at.out + n);
  at.bodies.inverse(tree, at.columns, at.u, at.out + 2 * n);
  scatter(at.out, 3 * n, da);
  return bits(at.bodies.doubtful);
}

void inverse_dynamics_jvp(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* a, const S* dq,
                          const S* dv, const S* da, S* dtau) noexcept {
  InverseJvp at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(a, tree->nv, at.a);
  gather(dq, tree->nv, at.dq), gather(dv, tree->nv, at.dv), gather(da, tree->nv, at.da);
  at.jvp.run(tree, at.q, at.v, at.a, at.dq, at.dv, at.da, {}, at.out);
  scatter(at.out, tree->nv, dtau);
}
unsigned forward_dynamics_jvp(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* tau,
                              const S* dq, const S* dv, const S* dtau, S* da) noexcept {
  Forward<InverseJvp> at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(tau, tree->nv, at.a);
  gather(dq, tree->nv, at.dq), gather(dv, tree->nv, at.dv), gather(dtau, tree->nv, at.da);
  at.accelerate(tree);
  for (int c = 0; c < tree->nv; ++c) at.zero[c] = Number(0);
  at.jvp.run(tree, at.q, at.v, at.acceleration, at.dq, at.dv, at.zero, {}, at.out);
  for (int c = 0; c < tree->nv; ++c) at.out[c] = at.da[c] - at.out[c];
  at.bodies.solve_one(tree, at.motion, at.out);
  scatter(at.out, tree->nv, da);
  return bits(at.bodies.doubtful);
}

/// The gradients by q, v and a or τ of one state behind each other.
void scatter_three(const Tree<S>& tree, const Number* by_q, const Number* by_v, const Number* by_a,
                   S* gradient) noexcept {
  for (const Number* part : {by_q, by_v, by_a}) {
    for (int c = 0; c < tree->nv; ++c)
      for (int l = 0; l < lanes; ++l) gradient[l * 3 * tree->nv + c] = part[c][l];
    gradient += tree->nv;
  }
}
void inverse_dynamics_vjp(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* a, const S* w,
                          S* gradient) noexcept {
  InverseVjp at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(a, tree->nv, at.a);
  gather(w, tree->nv, at.da);
  at.vjp.run(tree, at.q, at.v, at.a, at.da, {});
  scatter_three(tree, at.vjp.by_q, at.vjp.by_v, at.vjp.by_a, gradient);
}
unsigned forward_dynamics_vjp(const Tree<S>& tree, Arena arena, const S* q, const S* v, const S* tau,
                              const S* w, S* gradient) noexcept {
  Forward<InverseVjp> at(arena);
  gather(q, tree->nq, at.q), gather(v, tree->nv, at.v), gather(tau, tree->nv, at.a);
  gather(w, tree->nv, at.da);
  at.accelerate(tree);
  at.bodies.solve_one(tree, at.motion, at.da);
  at.vjp.run(tree, at.q, at.v, at.acceleration, at.da, {});
  for (int c = 0; c < tree->nv; ++c) at.dq[c] = -at.vjp.by_q[c], at.dv[c] = -at.vjp.by_v[c];
  scatter_three(tree, at.dq, at.dv, at.da, gradient);
  return bits(at.bodies.doubtful);
}

void store(const Vec3<Number>& a, int lane, Vec3<S>& out) { out = {a.x[lane], a.y[lane], a.z[lane]}; }

void poses(const Tree<S>& tree, Arena arena, const S* q, SE3<S>* C) noexcept {
  Poses at(arena);
  gather(q, tree->nq, at.q);
  at.body[0] = {};
  at.poses.run(tree, at.q, [&](int i, const auto& placed) { at.body[i] = pose<Number>(placed); });
  const int n = tree->n_frames();
  for (int f = 0; f < n; ++f) {
    const SE3<Number> C_f = at.body[tree->frame_body[f]] * cast<Number>(tree.frame_offset[f]);
    for (int l = 0; l < lanes; ++l) {
      SE3<S>& out = C[l * n + f];
      store(C_f.R.x, l, out.R.x), store(C_f.R.y, l, out.R.y), store(C_f.R.z, l, out.R.z),
          store(C_f.r, l, out.r);
    }
  }
}

void joint_screws(const Tree<S>& tree, Arena arena, const S* q, Twist<Spatial, S>* J) noexcept {
  Poses at(arena);
  gather(q, tree->nq, at.q);
  const int n = tree->n_screws;
  at.poses.run(tree, at.q, [&](int i, const auto& placed) {
    const SE3<Number> C = pose<Number>(placed);
    with_subgroup(tree->kind[i], Number(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<Number> X = joint.column(C, k);
        for (int l = 0; l < lanes; ++l) {
          Twist<Spatial, S>& out = J[l * n + tree->first_screw[i] + k];
          store(X.w, l, out.w), store(X.v, l, out.v);
        }
      }
    });
  });
}

/// A motion in each lane.
class Rollout {
 public:
  Rollout(const Tree<S>& tree, const Tableau& method)
      : tree_(tree), scheme_(tree, method), group_(tree), dynamics_(*tree.topology()) {}

  unsigned run(const Motions<S>& of, std::ptrdiff_t k, std::ptrdiff_t end) noexcept {
    Dynamics& at = *dynamics_;
    at.bodies.doubtful = Number::Mask{}, doubts_ = 0;
    const std::ptrdiff_t nq = tree_->nq, nv = tree_->nv;
    const S* row = of.law ? of.law->rows : nullptr;
    const auto accelerate = [&](double, std::span<const Number> q, std::span<const Number> v,
                                std::span<Number> a) {
      if (of.law) drive(*of.law, row, q.data(), v.data()), row += nq + 2 * nv;
      const Number* const tau = of.damped ? with_damping(v.data()) : at.tau;
      if (of.compiled) {
        call(*of.compiled, q.data(), v.data(), tau, a.data());
        return true;
      }
      at.bodies.place_and_move(tree_, q.data(), v.data(), at.motion);
      at.bodies.factorize(tree_, tau);
      at.bodies.accelerate(tree_, at.motion, a.data());
      return true;
    };
    each(of, of.q + k * nq, (of.K + 1) * nq, at.q, nq), each(of, of.v + k * nv, (of.K + 1) * nv, at.v, nv);
    for (; k < end; ++k) {
      if (!of.law) each(of, of.tau + k * nv, of.K * nv, at.tau, nv);
      accelerate(0, {at.q, static_cast<std::size_t>(nq)}, {at.v, static_cast<std::size_t>(nv)},
                 {at.a, static_cast<std::size_t>(nv)});
      static_cast<void>(scheme_.run(0, at.q, at.v, at.a, of.step, accelerate));
      group_.move(at.q, scheme_.theta.data(), at.q);
      for (std::ptrdiff_t c = 0; c < nv; ++c) at.v[c] = scheme_.y[static_cast<std::size_t>(c)];
      for (std::ptrdiff_t l = 0; l < of.count; ++l) {
        S *const q = of.q + (l * (of.K + 1) + k + 1) * nq, *const v = of.v + (l * (of.K + 1) + k + 1) * nv;
        for (std::ptrdiff_t c = 0; c < nq; ++c) q[c] = at.q[c][l];
        for (std::ptrdiff_t c = 0; c < nv; ++c) v[c] = at.v[c][l];
      }
    }
    return bits(at.bodies.doubtful) | doubts_;
  }

 private:
  struct Dynamics {
    Number *q, *v, *tau, *a, *q_d, *x, *total;
    ArticulatedBodies bodies;
    ArticulatedBodies::Motion* motion;
    FastInverseDynamics<G, Number> inverse;
    explicit Dynamics(Arena& arena)
        : q(arena.array<Number>(static_cast<std::size_t>(arena.topology().nq))),
          v(arena.per_velocity<Number>()),
          tau(arena.per_velocity<Number>()),
          a(arena.per_velocity<Number>()),
          q_d(arena.array<Number>(static_cast<std::size_t>(arena.topology().nq))),
          x(arena.per_velocity<Number>()),
          total(arena.per_velocity<Number>()),
          bodies(arena),
          motion(arena.per_body<ArticulatedBodies::Motion>()),
          inverse(arena) {}
  };
  const Number* with_damping(const Number* v) noexcept {
    Dynamics& at = *dynamics_;
    for (int c = 0; c < tree_->nv; ++c) at.total[c] = at.tau[c] - Number(tree_.damping[c]) * v[c];
    return at.total;
  }
  /// Accelerations by a function that takes states one behind the other.
  void call(const CompiledCall<S>& of, const Number* q, const Number* v, const Number* tau,
            Number* a) noexcept {
    scatter(q, tree_->nq, of.q), scatter(v, tree_->nv, of.v), scatter(tau, tree_->nv, of.tau);
    const S* const arguments[]{of.q, of.v, of.tau};
    of.dynamics->call(lanes, arguments, of.a, of.scratch, of.doubts);
    gather(of.a, tree_->nv, a);
    for (unsigned l = 0; l < lanes; ++l) doubts_ |= static_cast<unsigned>(of.doubts[l] != 0) << l;
  }
  /// τ of a drive that is at a row.
  void drive(const Law<S>& law, const S* row, const Number* q, const Number* v) noexcept {
    Dynamics& at = *dynamics_;
    const int nq = tree_->nq, nv = tree_->nv;
    const S *const v_d = row + nq, *const w = v_d + nv;
    for (int c = 0; c < nv; ++c) at.tau[c] = Number(w[c]);
    if (law.tracks) {
      for (int c = 0; c < nq; ++c) at.q_d[c] = Number(row[c]);
      group_.difference(q, at.q_d, at.x);
      for (int c = 0; c < nv; ++c)
        at.tau[c] += Number(law.kp[c]) * at.x[c] + Number(law.kd[c]) * (Number(v_d[c]) - v[c]);
    }
    if (law.computes) {
      for (int c = 0; c < nv; ++c) at.x[c] = at.tau[c], at.tau[c] = Number(tree_.armature[c]) * at.x[c];
      at.inverse.forward(tree_, q, v, at.x, cast<Number>(tree_.g));
      at.inverse.backward(tree_, at.tau);
    } else if (law.limit) {
      for (int c = 0; c < nv; ++c) {
        const Number most(law.limit[c]);
        at.tau[c] = select(at.tau[c] > most, most, select(at.tau[c] < -most, -most, at.tau[c]));
      }
    }
  }
  /// n numbers of every motion, the last one repeated in lanes that are left.
  static void each(const Motions<S>& of, const S* in, std::ptrdiff_t stride, Number* out, std::ptrdiff_t n) {
    for (std::ptrdiff_t l = 0; l < lanes; ++l)
      for (std::ptrdiff_t c = 0; c < n; ++c) out[c].x[l] = in[std::min(l, of.count - 1) * stride + c];
  }

  const Tree<S>& tree_;
  MuntheKaas<Number, S> scheme_;
  ConfigurationGroup<Number, S> group_;
  WithScratch<Number, Dynamics> dynamics_;
  unsigned doubts_ = 0;  ///< of the compiled function
};
void* make_rollout(const Tree<S>& tree, const Tableau& method) { return new Rollout(tree, method); }
unsigned run_rollout(void* rollout, const Motions<S>& of, std::ptrdiff_t k, std::ptrdiff_t end) noexcept {
  return static_cast<Rollout*>(rollout)->run(of, k, end);
}
void remove_rollout(void* rollout) noexcept { delete static_cast<Rollout*>(rollout); }

}  // namespace

template <> const Kernels<S>& kernels<AXODE_ISA, S>() {
  static constexpr Kernels<S> all{
      .lanes = lanes,
      .inverse_dynamics = {bytes<InverseDynamics>, inverse_dynamics},
      .forward_dynamics = {bytes<ForwardDynamics>, forward_dynamics},
      .mass_matrix = {bytes<MassMatrix>, mass_matrix},
      .inverse_mass_matrix = {bytes_of_inverse, inverse_mass_matrix},
      .poses = {bytes<Poses>, poses},
      .joint_screws = {bytes<Poses>, joint_screws},
      .inverse_dynamics_derivatives = {bytes<InverseDerivatives>, inverse_dynamics_derivatives},
      .forward_dynamics_derivatives = {bytes<Forward<InverseDerivatives>>, forward_dynamics_derivatives},
      .inverse_dynamics_jvp = {bytes<InverseJvp>, inverse_dynamics_jvp},
      .forward_dynamics_jvp = {bytes<Forward<InverseJvp>>, forward_dynamics_jvp},
      .inverse_dynamics_vjp = {bytes<InverseVjp>, inverse_dynamics_vjp},
      .forward_dynamics_vjp = {bytes<Forward<InverseVjp>>, forward_dynamics_vjp},
      .rollout = {make_rollout, run_rollout, remove_rollout}};
  return all;
}

}  // namespace axode::batch
