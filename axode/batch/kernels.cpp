#include "axode/batch/kernels.hpp"

#include <algorithm>

#include "axode/batch/transpose.hpp"
#include "axode/derivatives/products/row_kernels.hpp"
#include "axode/fast/articulated_bodies.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/inverse_mass_matrix.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode::batch {
namespace {

using S = AXODE_T;
constexpr int lanes = static_cast<int>(native_lanes<S>);
using Number = Batch<S, lanes>;
using G = Plain<Number>;

using ArticulatedBodies = FastArticulatedBodies<G, Number>;
using catalog::Id, catalog::Input;

/// Solves the equations of motion of several states at once, one in each SIMD lane, by the articulated-body
/// algorithm.
struct ByBodies {
  using T = Number;
  ArticulatedBodies bodies;
  ArticulatedBodies::Motion* motion;
  ArticulatedBodies::Columns* columns;
  Number* u;

  explicit ByBodies(Arena& arena)
      : bodies(arena),
        motion(arena.per_body<ArticulatedBodies::Motion>()),
        columns(arena.per_body<ArticulatedBodies::Columns>()),
        u(arena.per_screw<Number>()) {}
  void accelerate(const Tree<S>& tree, const Number* q, const Number* v, const Number* tau, Number* a) {
    bodies.update_kinematics_and_bias(tree, q, v, motion);
    bodies.factorize(tree, tau);
    bodies.accelerate(tree, motion, a);
  }
  void solve_one(const Tree<S>& tree, Number* x) { bodies.solve_one(tree, motion, x); }
  void solve(const Tree<S>& tree, Number* matrix) { bodies.solve(tree, columns, u, matrix); }
  void inverse(const Tree<S>& tree, Number* matrix) { bodies.inverse(tree, columns, u, matrix); }
};

/// The number of entries of all results of a function for one state: nv or nv² for each result.
template <Id id> std::size_t results(const Topology& topology) {
  constexpr std::size_t several = id.words().symbols.size(), axes = id.words().shape.size();
  std::size_t n = several;
  for (std::size_t k = 0; k < axes; ++k) n *= topology.nv;
  return n;
}

/// Memory for the arguments and results of one function, with a state in each SIMD lane, and its kernel.
template <Id id> struct RowBuffers {
  catalog::Read<Number> given;
  Number* x[catalog::inputs_of_numbers.size()] = {};
  Number* out;
  catalog::RowKernel<id, ByBodies> kernel;

  explicit RowBuffers(Arena& arena) : out(arena.array<Number>(results<id>(arena.topology()))), kernel(arena) {
    each_input([&]<Input input>() {
      const Topology& topology = arena.topology();
      const int n = input == Input::q ? topology.nq : topology.nv;
      given[input] = x[static_cast<std::size_t>(input)] = arena.array<Number>(n);
    });
  }
  /// Calls f<input>() for each input of the function that consists of numbers.
  template <class F> static void each_input(const F& f) {
    [&]<std::size_t... k>(std::index_sequence<k...>) {
      const auto one = [&]<std::size_t i>() {
        if constexpr (id.words().takes_input(static_cast<Input>(i)))
          f.template operator()<static_cast<Input>(i)>();
      };
      (one.template operator()<k>(), ...);
    }
    (std::make_index_sequence<catalog::inputs_of_numbers.size()>());
  }
};

/// Memory for the coordinates and a matrix, a state in each SIMD lane, and the algorithm for the matrix.
template <class Algorithm> struct MatrixBuffers {
  Number *q, *out;
  Algorithm by;
  explicit MatrixBuffers(Arena& arena)
      : q(arena.array<Number>(arena.topology().nq)),
        out(arena.array<Number>(results<"mass_matrix">(arena.topology()))),
        by(arena) {}
};
using MassMatrix = MatrixBuffers<FastCompositeBodies<Number>>;
using InverseByBodies = MatrixBuffers<ByBodies>;
struct InverseByFactors : MassMatrix {
  FastInverseMassMatrix<Number> inverse;
  explicit InverseByFactors(Arena& arena) : MassMatrix(arena), inverse(arena) {}
};
struct PoseBuffers {
  Number* q;
  SE3<Number>* body;
  FastPoses<Number> poses;
  explicit PoseBuffers(Arena& arena)
      : q(arena.array<Number>(arena.topology().nq)), body(arena.per_body<SE3<Number>>()), poses(arena) {}
};

/// The size of the memory of a kernel in bytes.
template <class Buffers> std::size_t bytes(const Tree<S>& tree) {
  return footprint<Buffers>(*tree.topology());
}
std::size_t bytes_of_inverse(const Tree<S>& tree) {
  return FastInverseMassMatrix<Number>::suits(tree) ? bytes<InverseByFactors>(tree)
                                                    : bytes<InverseByBodies>(tree);
}

std::size_t n_entries(const Tree<S>& tree) { return static_cast<std::size_t>(tree->nv) * tree->nv; }

/// The mask of lanes as bits, bit l for lane l.
unsigned bits(const Number::Mask& mask) {
  unsigned all = 0;
  for (unsigned l = 0; l < lanes; ++l) all |= static_cast<unsigned>(mask[l]) << l;
  return all;
}

template <Id id>
unsigned call(const Tree<S>& tree, Arena arena, const catalog::Read<S>& given, S* out) noexcept {
  using At = RowBuffers<id>;
  At at(arena);
  At::each_input([&]<Input input>() {
    gather(given[input], input == Input::q ? tree->nq : tree->nv, at.x[static_cast<std::size_t>(input)]);
  });
  at.kernel.run(tree, at.given, at.out);
  scatter(at.out, static_cast<std::ptrdiff_t>(results<id>(*tree.topology())), out);
  if constexpr (id.words().may_fail)
    return bits(at.kernel.by.bodies.maybe_singular);
  else
    return 0;
}

unsigned mass_matrix(const Tree<S>& tree, Arena arena, const catalog::Read<S>& given, S* M) noexcept {
  MassMatrix at(arena);
  gather(given[Input::q], tree->nq, at.q);
  at.by.run(tree, at.q);
  at.by.write(tree, at.out);
  scatter(at.out, n_entries(tree), M);
  return 0;
}

unsigned inverse_mass_matrix(const Tree<S>& tree, Arena arena, const catalog::Read<S>& given,
                             S* M_inverse) noexcept {
  if (FastInverseMassMatrix<Number>::suits(tree)) {
    InverseByFactors at(arena);
    gather(given[Input::q], tree->nq, at.q);
    at.by.run(tree, at.q);
    at.by.write_paths(tree, at.out);
    at.inverse.run(tree, at.out);
    scatter(at.out, n_entries(tree), M_inverse);
    return bits(at.inverse.maybe_singular);
  }
  InverseByBodies at(arena);
  gather(given[Input::q], tree->nq, at.q);
  at.by.bodies.update_kinematics(tree, at.q);
  at.by.bodies.factorize(tree);
  at.by.inverse(tree, at.out);
  scatter(at.out, n_entries(tree), M_inverse);
  return bits(at.by.bodies.maybe_singular);
}

void store(const Vec3<Number>& a, int lane, Vec3<S>& out) { out = {a.x[lane], a.y[lane], a.z[lane]}; }

unsigned poses(const Tree<S>& tree, Arena arena, const catalog::Read<S>& given, S* out) noexcept {
  PoseBuffers at(arena);
  gather(given[Input::q], tree->nq, at.q);
  SE3<S>* const C = reinterpret_cast<SE3<S>*>(out);
  at.body[0] = {};
  at.poses.run(tree, at.q, [&](int i, const auto& placed) { at.body[i] = pose<Number>(placed); });
  const int n = tree->n_frames();
  for (int f = 0; f < n; ++f) {
    const SE3<Number> C_f = at.body[tree->frame_body[f]] * cast<Number>(tree.frame_offset[f]);
    for (int l = 0; l < lanes; ++l) {
      SE3<S>& to = C[l * n + f];
      store(C_f.R.x, l, to.R.x);
      store(C_f.R.y, l, to.R.y);
      store(C_f.R.z, l, to.R.z);
      store(C_f.r, l, to.r);
    }
  }
  return 0;
}

unsigned joint_screws(const Tree<S>& tree, Arena arena, const catalog::Read<S>& given, S* out) noexcept {
  PoseBuffers at(arena);
  gather(given[Input::q], tree->nq, at.q);
  Twist<Spatial, S>* const J = reinterpret_cast<Twist<Spatial, S>*>(out);
  const int n = tree->n_screws;
  at.poses.run(tree, at.q, [&](int i, const auto& placed) {
    const SE3<Number> C = pose<Number>(placed);
    with_subgroup(tree->kind[i], Number(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<Number> X = joint.column(C, k);
        for (int l = 0; l < lanes; ++l) {
          Twist<Spatial, S>& to = J[l * n + tree->first_screw[i] + k];
          store(X.w, l, to.w);
          store(X.v, l, to.v);
        }
      }
    });
  });
  return 0;
}

/// Integrates several motions at once, one in each SIMD lane.
class Rollout {
 public:
  Rollout(const Tree<S>& tree, const Tableau& method)
      : tree_(tree), scheme_(tree, method), group_(tree), dynamics_(*tree.topology()) {}

  unsigned run(const Motions<S>& of, std::ptrdiff_t k, std::ptrdiff_t end) noexcept {
    Dynamics& at = *dynamics_;
    at.bodies.maybe_singular = Number::Mask{};
    singular_lanes_ = 0;
    const std::ptrdiff_t nq = tree_->nq, nv = tree_->nv;
    const S* row = of.law ? of.law->rows : nullptr;
    const auto accelerate = [&](double, std::span<const Number> q, std::span<const Number> v,
                                std::span<Number> a) {
      if (of.law) {
        drive(*of.law, row, q.data(), v.data());
        row += nq + 2 * nv;
      }
      const Number* const tau = of.damped ? with_damping(v.data()) : at.tau;
      if (of.compiled) {
        call(*of.compiled, q.data(), v.data(), tau, a.data());
        return true;
      }
      at.bodies.update_kinematics_and_bias(tree_, q.data(), v.data(), at.motion);
      at.bodies.factorize(tree_, tau);
      at.bodies.accelerate(tree_, at.motion, a.data());
      return true;
    };
    each(of, of.q + k * nq, (of.K + 1) * nq, at.q, nq);
    each(of, of.v + k * nv, (of.K + 1) * nv, at.v, nv);
    for (; k < end; ++k) {
      if (!of.law) each(of, of.tau + k * nv, of.K * nv, at.tau, nv);
      accelerate(0, {at.q, static_cast<std::size_t>(nq)}, {at.v, static_cast<std::size_t>(nv)},
                 {at.a, static_cast<std::size_t>(nv)});
      static_cast<void>(scheme_.run(0, at.q, at.v, at.a, of.step, accelerate));
      group_.move(at.q, scheme_.theta.data(), at.q);
      for (std::ptrdiff_t c = 0; c < nv; ++c) at.v[c] = scheme_.y[c];
      for (std::ptrdiff_t l = 0; l < of.count; ++l) {
        S *const q = of.q + (l * (of.K + 1) + k + 1) * nq, *const v = of.v + (l * (of.K + 1) + k + 1) * nv;
        for (std::ptrdiff_t c = 0; c < nq; ++c) q[c] = at.q[c][l];
        for (std::ptrdiff_t c = 0; c < nv; ++c) v[c] = at.v[c][l];
      }
    }
    return bits(at.bodies.maybe_singular) | singular_lanes_;
  }

 private:
  struct Dynamics {
    Number *q, *v, *tau, *a, *q_d, *x, *total;
    ArticulatedBodies bodies;
    ArticulatedBodies::Motion* motion;
    FastInverseDynamics<G, Number> inverse;
    explicit Dynamics(Arena& arena)
        : q(arena.array<Number>(arena.topology().nq)),
          v(arena.per_velocity<Number>()),
          tau(arena.per_velocity<Number>()),
          a(arena.per_velocity<Number>()),
          q_d(arena.array<Number>(arena.topology().nq)),
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
  /// Computes the accelerations of all lanes by the compiled function, which takes contiguous states.
  void call(const CompiledCall<S>& of, const Number* q, const Number* v, const Number* tau,
            Number* a) noexcept {
    scatter(q, tree_->nq, of.q);
    scatter(v, tree_->nv, of.v);
    scatter(tau, tree_->nv, of.tau);
    const S* const arguments[]{of.q, of.v, of.tau};
    of.dynamics->call(lanes, arguments, of.a, of.scratch, of.maybe_singular);
    gather(of.a, tree_->nv, a);
    for (unsigned l = 0; l < lanes; ++l)
      singular_lanes_ |= static_cast<unsigned>(of.maybe_singular[l] != 0) << l;
  }
  /// Computes the drive forces τ by a control law; `row` is its reference and feedforward at this stage.
  void drive(const ControlLaw<S>& law, const S* row, const Number* q, const Number* v) noexcept {
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
      for (int c = 0; c < nv; ++c) {
        at.x[c] = at.tau[c];
        at.tau[c] = Number(tree_.armature[c]) * at.x[c];
      }
      at.inverse.forward(tree_, q, v, at.x, cast<Number>(tree_.g));
      at.inverse.backward(tree_, at.tau);
    } else if (law.limit) {
      for (int c = 0; c < nv; ++c) {
        const Number most(law.limit[c]);
        at.tau[c] = select(at.tau[c] > most, most, select(at.tau[c] < -most, -most, at.tau[c]));
      }
    }
  }
  /// Copies n numbers of every motion to the SIMD lane of the motion. The numbers of motion l are in[l
  /// stride] to in[l stride + n - 1]. Lanes without a motion get the numbers of the last one.
  static void each(const Motions<S>& of, const S* in, std::ptrdiff_t stride, Number* out, std::ptrdiff_t n) {
    for (std::ptrdiff_t l = 0; l < lanes; ++l)
      for (std::ptrdiff_t c = 0; c < n; ++c) out[c].x[l] = in[std::min(l, of.count - 1) * stride + c];
  }

  const Tree<S>& tree_;
  MuntheKaas<Number, S> scheme_;
  ConfigurationGroup<Number, S> group_;
  WithScratch<Number, Dynamics> dynamics_;
  unsigned singular_lanes_ = 0;  ///< lanes for which the compiled function reported that the mass matrix may
                                 ///< be singular
};
void* make_rollout(const Tree<S>& tree, const Tableau& method) { return new Rollout(tree, method); }
unsigned run_rollout(void* rollout, const Motions<S>& of, std::ptrdiff_t k, std::ptrdiff_t end) noexcept {
  return static_cast<Rollout*>(rollout)->run(of, k, end);
}
void remove_rollout(void* rollout) noexcept { delete static_cast<Rollout*>(rollout); }

}  // namespace

template <> AXODE_ENTRY const Kernels<S>& kernels<S>() {
  static constexpr Kernels<S> all = [] {
    Kernels<S> made{.lanes = lanes, .rows = {}, .rollout = {make_rollout, run_rollout, remove_rollout}};
    const auto set = [&](Id id, LaneKernel<S> kernel) { made.rows[id.index] = kernel; };
    catalog::each_row([&]<Id id> {
      if constexpr (id.words().lanes && catalog::HasRowKernel<id, ByBodies>)
        set(id, {bytes<RowBuffers<id>>, call<id>, !id.words().may_fail});
    });
    set("mass_matrix", {bytes<MassMatrix>, mass_matrix});
    set("inverse_mass_matrix", {bytes_of_inverse, inverse_mass_matrix});
    set("poses", {bytes<PoseBuffers>, poses, true});
    set("joint_screws", {bytes<PoseBuffers>, joint_screws, true});
    return made;
  }();
  static_assert(std::ranges::equal(
                    all.rows, catalog::functions_of_state, {},
                    [](const LaneKernel<S>& kernel) { return kernel.call != nullptr; },
                    [](const catalog::Words& row) -> bool { return row.lanes; }),
                "the rows with lanes have a kernel, and no others");
  return all;
}

}  // namespace axode::batch
