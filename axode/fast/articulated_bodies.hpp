#pragma once
#include <array>
#include <tuple>

#include "axode/fast/lanes.hpp"
#include "axode/fast/packed_articulated_inertia.hpp"
#include "axode/fast/poses.hpp"
#include "axode/recursion/inverse_dynamics.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The articulated-body algorithm in inertial axes about the bodies' origins, where the screw of a hinge is
/// (n; 0), for trees without coupled joints. Bias forces come from the classical accelerations that the
/// velocities alone make.
///
/// A hinge hands over M' = Ad_rᵀ M Ad_r - Û Ûᵀ / D with Û = Ad_rᵀ U, U = M S, D = Sᵀ U + armature, so that
/// the division and the congruence wait for nothing but M. A joint with several degrees of freedom gives way
/// in one after the other.
template <class G, class T> struct FastArticulatedBodies {
  using Number = typename G::Number;
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  using Tensor = typename G::Tensor;
  using Articulated =
      decltype(articulated(std::declval<Tensor>(), std::declval<Vector>(), std::declval<T>()));
  struct Body {
    Vector n;  ///< the third axis
    Vector r;  ///< from the predecessor's origin to the body's
    Vector h, m, f;
    Tensor Theta;
  };
  /// What the bodies that hang on a body besides the next one hand over.
  struct Handed {
    Articulated M;
    Vector m, f;
  };
  struct Motion {
    Vector w, dw, a;
    Factor w_, dw_;
  };
  /// What is left of a joint screw (w; v) that has given way. U is Û for a hinge, which needs no (w; v).
  struct Pivot {
    Vector U_m, U_f, w, v;
    Number D_inv, u;
  };
  JointAngles<T> angles;
  Body* body;
  Matrix* R;       ///< of the bodies on which others hang, and of those whose joint is no hinge
  Handed* handed;  ///< to bodies on which others hang
  Pivot* pivot;
  decltype(T() < T()) doubtful{};  ///< whether a pivot D is so small that M may be singular

  explicit FastArticulatedBodies(Arena& arena)
      : angles(arena),
        body(arena.per_body<Body>()),
        R(arena.per_body<Matrix>()),
        handed(arena.per_body<Handed>()),
        pivot(arena.per_screw<Pivot>()) {}

  /// Places and inertias of all bodies.
  template <class S> void place(const Tree<S>& tree, const T* q) noexcept {
    angles.run(tree, q);
    Matrix last_R = R[0] = Matrix(SO3<T>{});
    for (int i = 1; i <= tree->n; ++i) place(tree, i, q, last_R);
  }

  /// And the wrenches that keep the accelerations of all joints at 0.
  template <class S>
  void place_and_move(const Tree<S>& tree, const T* q, const T* v, Motion* motion) noexcept {
    place_and_move(tree, q, v, motion, [](int, const Matrix&, const Motion&, const Vector&) {});
  }
  /// The same, with put(i, R, motion, u) for every body, where its origin moves by u faster than that of its predecessor.
  template <class S, class Put>
  [[gnu::always_inline]] void place_and_move(const Tree<S>& tree, const T* q, const T* v, Motion* motion,
                                             Put&& put) noexcept {
    angles.run(tree, q);
    Matrix last_R = R[0] = Matrix(SO3<T>{});
    Motion last{{}, {}, Vector(-cast<T>(tree.g)), {}, {}};
    motion[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = motion[p];
      place(tree, i, q, last_R);
      Body& b = body[i];
      const Factor r(b.r);
      Vector u = cross(last.w_, r);
      last.a += cross(last.dw_, r) + cross(last.w_, Factor(u));
      if (is_hinge(tree, i)) [[likely]] {
        const Vector w_J = Number(v[tree->iv[i]]) * b.n;
        last.dw += cross(last.w_, Factor(w_J)), last.w += w_J;
      } else {
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v);
        const Vector w_J = last_R * Spread(Vector(V.w)), v_J = last_R * Spread(Vector(V.v)), w = last.w + w_J;
        last.dw += cross(last.w_, Factor(w_J));
        last.a += cross(Factor(last.w + w), Factor(v_J));
        last.w = w, u += v_J;
      }
      last.w_ = Factor(last.w), last.dw_ = Factor(last.dw);
      const Factor h_(b.h);
      b.f = Number(constants<G, T>(tree, i).m) * last.a +
            (cross(last.dw_, h_) + cross(last.w_, Factor(cross(last.w_, h_))));
      b.m = b.Theta * Spread(last.dw) +
            (cross(last.w_, Factor(b.Theta * Spread(last.w))) + cross(h_, Factor(last.a)));
      if (tree->branches[i]) motion[i] = last;
      put(i, last_R, last, u);
    }
  }

  /// All joints of the placed bodies give way, from the leaves to the roots.
  template <class S> void factorize(const Tree<S>& tree) noexcept { sweep<false>(tree, nullptr); }
  /// And the forces τ less what keeps the accelerations at 0; the placed bodies may carry other wrenches as well.
  template <class S> void factorize(const Tree<S>& tree, const T* tau) noexcept { sweep<true>(tree, tau); }

  /// The accelerations, from the roots to the leaves, after factorize(tree, tau).
  template <class S> void accelerate(const Tree<S>& tree, Motion* motion, T* a) const noexcept {
    Vector w{}, dv{};  // what the joints add to the acceleration of the body
    motion[0].w = w, motion[0].a = dv;
    for (int i = 1; i <= tree->n; ++i) {
      const Body& b = body[i];
      const int p = tree->parent[i];
      if (p != i - 1) w = motion[p].w, dv = motion[p].a;
      if (is_hinge(tree, i)) [[likely]] {
        const Pivot& c = pivot[tree->first_screw[i]];
        const Number a_i = c.u - c.D_inv * dot(c.U_m, w, c.U_f, dv);
        dv += cross(Factor(w), Factor(b.r)), w += a_i * b.n;
        a[tree->iv[i]] = value(a_i);
      } else {
        dv += cross(Factor(w), Factor(b.r));
        for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
          const Pivot& c = pivot[s];
          const Number a_i = c.u - c.D_inv * dot(c.U_m, w, c.U_f, dv);
          w += a_i * c.w, dv += a_i * c.v;
          a[tree->iv[i] + s - tree->first_screw[i]] = value(a_i);
        }
      }
      if (tree->branches[i]) motion[i].w = w, motion[i].a = dv;
    }
  }

  /// x := M⁻¹ x after factorize.
  template <class S> void solve_one(const Tree<S>& tree, Motion* motion, T* x) noexcept {
    Vector m{}, f{};
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      if (tree->branches[i]) m += handed[i].m, f += handed[i].f, handed[i].m = handed[i].f = Vector{};
      if (is_hinge(tree, i)) [[likely]] {
        Pivot& c = pivot[tree->first_screw[i]];
        c.u = c.D_inv * (Number(x[tree->iv[i]]) - dot(b.n, m));
        m += cross(Factor(b.r), Factor(f)) + c.u * c.U_m, f += c.u * c.U_f;
      } else {
        for (int s = tree->first_screw[i + 1]; s-- > tree->first_screw[i];) {
          Pivot& c = pivot[s];
          c.u = c.D_inv * (Number(x[tree->iv[i] + s - tree->first_screw[i]]) - dot(c.w, m, c.v, f));
          m += c.u * c.U_m, f += c.u * c.U_f;
        }
        m += cross(Factor(b.r), Factor(f));
      }
      const int p = tree->parent[i];
      if (p > 0 && p != i - 1) handed[p].m += m, handed[p].f += f;
      if (p != i - 1 || p == 0) m = f = Vector{};
    }
    accelerate(tree, motion, x);
  }

  /// After factorize, several columns at once: M⁻¹,
  using L = Lanes<T>;
  using Several = typename L::Number;
  struct Columns {
    Vec3<Several> m, f;
  };
  template <class S> void inverse(const Tree<S>& tree, Columns* W, Several* u, T* out) noexcept {
    for (int first = 0; first < tree->nv; first += L::width) {
      const auto reaches = [&](int i) {
        return tree->iv[i] < first + L::width && tree->velocity_end[tree->iv[i]] > first;
      };
      solve(
          tree, first, reaches, [&](int c) { return unit(c - first); }, W, u, out);
    }
  }
  /// and x := M⁻¹ x for a matrix of nv columns.
  template <class S> void solve(const Tree<S>& tree, Columns* W, Several* u, T* x) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    for (int first = 0; first < tree->nv; first += L::width)
      solve(
          tree, first, [](int) { return true; },
          [&](int c) { return L::load(x + c * nv + first, tree->nv - first); }, W, u, x);
  }

 private:
  template <bool forces, class S> void sweep(const Tree<S>& tree, const T* tau) noexcept {
    Articulated M{};
    Vector m{}, f{};
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      M += inertia(tree, i);
      if (tree->branches[i]) M += handed[i].M;
      if constexpr (forces) {
        m += b.m, f += b.f;
        if (tree->branches[i]) m += handed[i].m, f += handed[i].f, handed[i].m = handed[i].f = Vector{};
      }
      if (is_hinge(tree, i)) [[likely]] {
        [[maybe_unused]] Pivot& c = give_way_about_hinge(tree, i, tree.armature.data(), M);
        if constexpr (forces) {
          c.u = c.D_inv * (Number(tau[tree->iv[i]]) - dot(b.n, m));
          m += cross(Factor(b.r), Factor(f)) + c.u * c.U_m, f += c.u * c.U_f;
        }
      } else {
        give_way_along(tree, i, tree.armature.data(), M);
        if constexpr (forces) {
          for (int s = tree->first_screw[i + 1]; s-- > tree->first_screw[i];) {
            Pivot& c = pivot[s];
            c.u = c.D_inv * (Number(tau[tree->iv[i] + s - tree->first_screw[i]]) - dot(c.w, m, c.v, f));
            m += c.u * c.U_m, f += c.u * c.U_f;
          }
          m += cross(Factor(b.r), Factor(f));
        }
      }
      const int p = tree->parent[i];
      if (p > 0 && p != i - 1) {
        handed[p].M += M;
        if constexpr (forces) handed[p].m += m, handed[p].f += f;
      }
      if (p != i - 1 || p == 0) M = {}, m = f = Vector{};
    }
  }

  /// Columns first, ... of the solution for right sides that are 0 but at joints of which one reaches.
  template <class S, class Reaches, class RightSide>
  [[gnu::always_inline]] void solve(const Tree<S>& tree, int first, const Reaches& reaches,
                                    const RightSide& right_side, Columns* const W, Several* const u,
                                    T* const out) noexcept {
    const Body* const bodies = body;  // local copies, which no result can overwrite
    const Pivot* const pivots = pivot;
    const int nv = tree->nv, room = nv - first;
    for (int i = 0; i <= tree->n; ++i)
      if (i == 0 || reaches(i)) W[i] = {};
    for (int i = tree->n; i > 0; --i) {
      if (!reaches(i)) continue;
      Columns F = W[i];
      const Vec3<Several> r = vector(bodies[i].r);
      const int first_screw = tree->first_screw[i], c = tree->iv[i];
      if (is_hinge(tree, i)) [[likely]] {
        const Pivot& p = pivots[first_screw];
        const Several x = value(p.D_inv) * (right_side(c) - dot(vector(bodies[i].n), F.m));
        u[first_screw] = x;
        F.m += cross(r, F.f) + x * vector(p.U_m), F.f += x * vector(p.U_f);
      } else {
        for (int s = tree->first_screw[i + 1]; s-- > first_screw;) {
          const Pivot& p = pivots[s];
          const Several x =
              value(p.D_inv) * (right_side(c + s - first_screw) - dot(vector(p.w), F.m, vector(p.v), F.f));
          u[s] = x;
          F.m += x * vector(p.U_m), F.f += x * vector(p.U_f);
        }
        F.m += cross(r, F.f);
      }
      Columns& to = W[tree->parent[i]];
      to.m += F.m, to.f += F.f;
    }
    Columns X{};
    W[0] = X;
    for (int i = 1; i <= tree->n; ++i) {
      if (tree->parent[i] != i - 1) X = W[tree->parent[i]];
      const Vec3<Several> moved = X.f + cross(X.m, vector(bodies[i].r));
      const bool hinge = is_hinge(tree, i), reached = reaches(i);
      if (!hinge) X.f = moved;
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
        const Pivot& p = pivots[s];
        const Several a =
            (reached ? u[s] : Several(T(0))) - value(p.D_inv) * dot(vector(p.U_m), X.m, vector(p.U_f), X.f);
        L::store(a, out + static_cast<std::ptrdiff_t>(tree->iv[i] + s - tree->first_screw[i]) * nv + first,
                 room);
        if (hinge)
          X.m += a * vector(bodies[i].n), X.f = moved;
        else
          X.m += a * vector(p.w), X.f += a * vector(p.v);
      }
      if (tree->branches[i]) W[i] = X;
    }
  }
  static Vec3<Several> vector(const Vector& a) { return spread<Several, T>(a); }
  /// 1 in lane k, if there is one.
  static Several unit(int k) noexcept {
    if constexpr (L::width == 1) {
      return Several(T(k == 0));
    } else {
      alignas(64) static constexpr auto shifted = [] {
        std::array<T, 3 * L::width> one{};
        one[L::width] = T(1);
        return one;
      }();
      return k >= 0 && k < L::width ? L::load(shifted.data() + L::width - k) : Several(T(0));
    }
  }
  /// Body i; last_R is that of body i - 1, then that of body i.
  template <class S>
  [[gnu::always_inline]] void place(const Tree<S>& tree, int i, const T* q, Matrix& last_R) noexcept {
    const int p = tree->parent[i];
    if (p != i - 1) last_R = R[p];
    const auto& body_i = constants<G, T>(tree, i);
    const auto at = axode::place<G>(tree, i, q, angles, last_R);
    Body& b = body[i];
    last_R = at.R;
    b.n = at.R.z, b.r = at.r, b.h = at.R * Spread(body_i.h), b.Theta = rotate(at.R, body_i.Theta);
    if (tree->branches[i]) R[i] = at.R, handed[i] = {};
    if (!is_hinge(tree, i)) R[i] = at.R;
  }
  template <class S> Articulated inertia(const Tree<S>& tree, int i) const noexcept {
    return articulated(body[i].Theta, body[i].h, constants<G, T>(tree, i).m);
  }

  /// The pivot of joint screw s below which M may be singular and is looked at more closely.
  template <class S> static T floor_of(const Tree<S>& tree, int s) noexcept {
    return T(doubtful_part<S> * tree.fed[s]);
  }
  /// The hinge of body i gives way: M becomes what the predecessor feels.
  template <class S>
  [[gnu::always_inline]] Pivot& give_way_about_hinge(const Tree<S>& tree, int i, const S* armature,
                                                     Articulated& M) noexcept {
    const Body& b = body[i];
    const auto [U_m, U_f] = about_axis(M, b.n);
    const Number D = dot(b.n, U_m) + Number(T(armature[tree->iv[i]])), D_inv = Number(T(1)) / D;
    doubtful = doubtful || !(value(D) > floor_of(tree, tree->first_screw[i]));
    const Vector moved = U_m + cross(Factor(b.r), Factor(U_f));
    M = shifted(M, b.r);
    give_way(M, moved, U_f, D_inv);
    Pivot& c = pivot[tree->first_screw[i]];
    c.U_m = moved, c.U_f = U_f, c.D_inv = D_inv;
    return c;
  }
  /// The same for a joint of any kind.
  template <class S>
  [[gnu::noinline]] void give_way_along(const Tree<S>& tree, int i, const S* armature,
                                        Articulated& M) noexcept {
    const Body& b = body[i];
    Pivot* c = pivot + tree->first_screw[i];
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      for (int k = joint.nv; k-- > 0;) {
        const Screw<T> X = joint.column(k);
        c[k].w = R[i] * Spread(Vector(X.w)), c[k].v = R[i] * Spread(Vector(X.v));
        std::tie(c[k].U_m, c[k].U_f) = along_twist(M, c[k].w, c[k].v);
        const Number D = dot(c[k].w, c[k].U_m, c[k].v, c[k].U_f) + Number(T(armature[tree->iv[i] + k]));
        c[k].D_inv = Number(T(1)) / D;
        doubtful = doubtful || !(value(D) > floor_of(tree, tree->first_screw[i] + k));
        give_way(M, c[k].U_m, c[k].U_f, c[k].D_inv);
      }
    });
    M = shifted(M, b.r);
  }
};

/// Forward dynamics where it is plain sailing.
template <class T> struct FastForwardDynamics {
  using Bodies = FastArticulatedBodies<typename FastGeometry<T>::type, T>;
  Bodies bodies;
  typename Bodies::Motion* motion;
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T* drive;

  explicit FastForwardDynamics(Arena& arena)
      : bodies(arena),
        motion(arena.per_body<typename Bodies::Motion>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        drive(arena.per_velocity<T>()) {}

  /// False, and nothing written, where joints are coupled or the mass matrix may be singular. The accelerations may
  /// take the place of an argument.
  bool run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a) noexcept {
    if (!prepare(tree, q, v, tau, loads, [](int, const auto&, const auto&, const auto&) {})) return false;
    bodies.accelerate(tree, motion, a);
    return true;
  }
  /// All but the way down, with put() of place_and_move(); false likewise.
  template <class Put>
  [[gnu::always_inline]] bool prepare(const Tree<T>& tree, const T* q, const T* v, const T* tau,
                                      const Loads<T>& loads, Put&& put) noexcept {
    if (!tree->coupled_bodies.empty()) return false;
    bodies.place_and_move(tree, q, v, motion, put);
    if (!loads.wrenches.empty()) apply(tree, q, loads.wrenches);
    const T* force = tau;
    if (loads.joint_losses) {
      for (int c = 0; c < tree->nv; ++c) drive[c] = tau[c] - joint_loss(tree, c, v[c]);
      force = drive;
    }
    bodies.doubtful = false;
    bodies.factorize(tree, force);
    return !bodies.doubtful;
  }

 private:
  void apply(const Tree<T>& tree, const T* q, std::span<const AppliedWrench<T>> wrenches) noexcept {
    C[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const SE3<T>& C_p = C[tree->parent[i]];
      const Placed<Plain<T>> at = place<Plain<T>>(tree, i, q, bodies.angles, C_p.R);
      C[i] = {at.R, C_p.r + at.r};
    }
    sum_applied(tree, wrenches, C.C, W_app);
    for (int i = 1; i <= tree->n; ++i) {
      const SO3<T>& R = C[i].R;
      bodies.body[i].m -= R * W_app[i].m, bodies.body[i].f -= R * W_app[i].f;
    }
  }
};

/// The inverse mass matrix, on the same terms.
template <class T> struct FastInverse {
  using Bodies = FastArticulatedBodies<typename FastGeometry<T>::type, T>;
  Bodies bodies;
  typename Bodies::Columns* columns;
  typename Bodies::Several* u;

  explicit FastInverse(Arena& arena)
      : bodies(arena),
        columns(arena.per_body<typename Bodies::Columns>()),
        u(arena.per_screw<typename Bodies::Several>()) {}

  bool run(const Tree<T>& tree, const T* q, T* M_inverse) noexcept {
    if (!tree->coupled_bodies.empty()) return false;
    bodies.place(tree, q);
    bodies.factorize(tree);
    if (bodies.doubtful) return false;
    bodies.inverse(tree, columns, u, M_inverse);
    return true;
  }
};

}  // namespace axode
