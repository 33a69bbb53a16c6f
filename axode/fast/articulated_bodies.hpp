#pragma once
#include <array>

#include "axode/fast/lanes.hpp"
#include "axode/fast/packed_articulated_inertia.hpp"
#include "axode/fast/poses.hpp"
#include "axode/fast/symmetric_blocks.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The articulated-body algorithm for trees without coupled joints, in inertial axes about the origins of the
/// bodies. Bias wrenches are those for zero joint accelerations.
///
/// A hinge of body i has the screw S = (n; 0) with its unit axis n. With the articulated inertia M of the
/// body, U = M S, and the pivot D = Sᵀ U + armature, the elimination of the hinge adds Ad_rᵀ M Ad_r - K Ûᵀ to
/// the inertia of the predecessor. Here r is the vector from the origin of body i to that of the predecessor,
/// Û = Ad_rᵀ U, and K = Û / D. Velocities of one joint are eliminated one after the other.
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
    Vector n;     ///< third axis of the body frame, which is the axis of a hinge
    Vector r;     ///< vector from the origin of the predecessor to that of the body
    Vector h;     ///< first moment
    Vector m, f;  ///< bias wrench
    Tensor Theta;
  };
  /// The sum of the inertias and wrenches that the children of a body i, except body i + 1, pass to it.
  struct ChildSum {
    Articulated M;
    Vector m, f;
  };
  /// The motion of a body for zero joint accelerations and the acceleration -g of the ground: its angular
  /// velocity ω, its angular acceleration ω', and the acceleration r'' of its origin. The last sweep,
  /// accelerate(), overwrites the members w and a of some bodies by the parts of ω' and r'' that are due to
  /// joint accelerations.
  struct Motion {
    Vector w, dw, a;
    Factor w_, dw_;
  };
  /// An eliminated joint screw S = (w; v), in inertial axes about the origin of the body that the joint
  /// moves. With the articulated inertia M of this body, U = M S, and the pivot D, K = U/D is the wrench on
  /// the predecessor for a unit joint force, about the origin of the body. For a hinge, K is about the origin
  /// of the predecessor instead, and (w; v) is not stored. u = (τ - Sᵀ W)/D with the joint force τ and the
  /// bias wrench W ((D4.12) and (D4.13) of docs/derivations).
  struct Pivot {
    Vector K_m, K_f, w, v;
    Number D_inv, u;
  };
  JointAngles<T> angles;
  Body* body;
  Matrix* R;              ///< rotations of bodies with `branches`, and of those whose joint is not a hinge
  ChildSum* child_sum;    ///< contributions of children, for bodies with `branches`
  Pivot* pivot;           ///< one for each joint screw
  std::array<T, 6>* S_K;  ///< S_k | K_l of each joint screw k with later screws l of its joint
  /// Whether the mass matrix may be singular. factorize() sets it and does not reset it.
  decltype(T() < T()) maybe_singular{};

  explicit FastArticulatedBodies(Arena& arena)
      : angles(arena),
        body(arena.per_body<Body>()),
        R(arena.per_body<Matrix>()),
        child_sum(arena.per_body<ChildSum>()),
        pivot(arena.per_screw<Pivot>()),
        S_K(arena.per_screw<std::array<T, 6>>()) {}

  /// Computes, in inertial axes, the rotations of all bodies at q, the vectors to their origins from the
  /// origins of their predecessors, and their inertias about their origins.
  template <class S> void update_kinematics(const Tree<S>& tree, const T* q) noexcept {
    angles.run(tree, q);
    Matrix last_R = R[0] = Matrix(SO3<T>{});
    for (int i = 1; i <= tree->n; ++i) update_kinematics(tree, i, q, last_R);
  }

  /// Computes poses and inertias of all bodies at q like update_kinematics(), and the bias wrenches: the
  /// wrenches on the bodies for zero joint accelerations, gravity included, in inertial axes about the
  /// origins of the bodies.
  template <class S>
  void update_kinematics_and_bias(const Tree<S>& tree, const T* q, const T* v, Motion* motion) noexcept {
    update_kinematics_and_bias(tree, q, v, motion, [](int, const Matrix&, const Motion&, const Vector&) {});
  }
  /// Computes poses, inertias and bias wrenches of all bodies, for zero joint accelerations and the
  /// acceleration -g of the ground. Calls put(i, R, motion, u) for every body i with its rotation R; its
  /// angular velocity, its angular acceleration and the acceleration of its origin (`motion`); and the
  /// velocity u of its origin minus that of the origin of its predecessor. All are in inertial axes.
  template <class S, class Put>
  [[gnu::always_inline]] void update_kinematics_and_bias(const Tree<S>& tree, const T* q, const T* v,
                                                         Motion* motion, Put&& put) noexcept {
    angles.run(tree, q);
    Matrix last_R = R[0] = Matrix(SO3<T>{});
    Motion last{{}, {}, Vector(-cast<T>(tree.g)), {}, {}};
    motion[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = motion[p];
      update_kinematics(tree, i, q, last_R);
      Body& b = body[i];
      const Factor r(b.r);
      Vector u = cross(last.w_, r);
      last.a += cross(last.dw_, r) + cross(last.w_, Factor(u));
      if (is_hinge(tree, i)) [[likely]] {
        const Vector w_J = Number(v[tree->iv[i]]) * b.n;
        last.dw += cross(last.w_, Factor(w_J));
        last.w += w_J;
      } else {
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v);
        const Vector w_J = last_R * Spread(Vector(V.w)), v_J = last_R * Spread(Vector(V.v)), w = last.w + w_J;
        last.dw += cross(last.w_, Factor(w_J));
        last.a += cross(Factor(last.w + w), Factor(v_J));
        last.w = w;
        u += v_J;
      }
      last.w_ = Factor(last.w);
      last.dw_ = Factor(last.dw);
      const Factor h_(b.h);
      b.f = Number(constants<G, T>(tree, i).m) * last.a +
            (cross(last.dw_, h_) + cross(last.w_, Factor(cross(last.w_, h_))));
      b.m = b.Theta * Spread(last.dw) +
            (cross(last.w_, Factor(b.Theta * Spread(last.w))) + cross(h_, Factor(last.a)));
      if (tree->branches[i]) motion[i] = last;
      put(i, last_R, last, u);
    }
  }

  /// Eliminates all joints, from the leaves to the roots, after one of the update_kinematics functions.
  template <class S> void factorize(const Tree<S>& tree) noexcept { sweep<false>(tree, nullptr); }
  /// Eliminates all joints, from the leaves to the roots, with the drive forces `tau`, so that the
  /// accelerations can be computed. Kinematics, inertias and bias wrenches must have been computed; applied
  /// wrenches may have been subtracted from the bias wrenches.
  template <class S> void factorize(const Tree<S>& tree, const T* tau) noexcept { sweep<true>(tree, tau); }

  /// The forward sweep after factorize(tree, tau), from the roots on: the accelerations a of all joints.
  template <class S> void accelerate(const Tree<S>& tree, Motion* motion, T* a) const noexcept {
    Vector w{}, dv{};  // part of the acceleration of the body that is due to joint accelerations
    motion[0].w = w;
    motion[0].a = dv;
    for (int i = 1; i <= tree->n; ++i) {
      const Body& b = body[i];
      const int p = tree->parent[i];
      if (p != i - 1) {
        w = motion[p].w;
        dv = motion[p].a;
      }
      if (is_hinge(tree, i)) [[likely]] {
        const Pivot& c = pivot[tree->first_screw[i]];
        const Number a_i = c.u - dot(c.K_m, w, c.K_f, dv);
        dv += cross(Factor(w), Factor(b.r));
        w += a_i * b.n;
        a[tree->iv[i]] = value(a_i);
      } else {
        dv += cross(Factor(w), Factor(b.r));
        for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
          const Pivot& c = pivot[s];
          const Number a_i = c.u - dot(c.K_m, w, c.K_f, dv);
          w += a_i * c.w;
          dv += a_i * c.v;
          a[tree->iv[i] + s - tree->first_screw[i]] = value(a_i);
        }
      }
      if (tree->branches[i]) {
        motion[i].w = w;
        motion[i].a = dv;
      }
    }
  }

  /// Replaces x by M⁻¹ x for one column of nv numbers, after factorize().
  template <class S> void solve_one(const Tree<S>& tree, Motion* motion, T* x) noexcept {
    Vector m{}, f{};
    for (int i = tree->n; i > 0; --i) {
      if (tree->branches[i]) {
        m += child_sum[i].m;
        f += child_sum[i].f;
        child_sum[i].m = child_sum[i].f = Vector{};
      }
      pass_wrench(tree, i, x, m, f);
      const int p = tree->parent[i];
      if (p > 0 && p != i - 1) {
        child_sum[p].m += m;
        child_sum[p].f += f;
      }
      if (p != i - 1 || p == 0) m = f = Vector{};
    }
    accelerate(tree, motion, x);
  }

  using L = Lanes<T>;
  using Several = typename L::Number;
  /// Wrenches or motions of one body for several columns of a matrix at once.
  struct Columns {
    Vec3<Several> m, f;
  };
  /// Computes the inverse M⁻¹ (nv × nv) of the factorised mass matrix, several columns at once. W (one entry
  /// for each body) and u (one for each joint screw) are scratch memory.
  template <class S> void inverse(const Tree<S>& tree, Columns* W, Several* u, T* out) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    couple(tree);
    int last = tree->n;
    for (int first = last_block<T>(tree->nv); first >= 0; first -= L::width) {
      while (tree->iv[last] >= first + L::width) --last;
      solve(
          tree, last, [&](int i) { return tree->velocity_end[tree->iv[i]] > first; },
          [&](int c) { return unit(c - first); },
          [&](int c, const Several& a) { store_row(a, c, first, tree->nv, out + c * nv + first); }, W, u);
    }
    mirror(tree->nv, out);
  }
  /// Replaces x (nv × nv, row by row) by M⁻¹ x after factorize(), several columns at once. See inverse().
  template <class S> void solve(const Tree<S>& tree, Columns* W, Several* u, T* x) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    couple(tree);
    for (int first = 0; first < tree->nv; first += L::width) {
      const int room = tree->nv - first;
      solve(
          tree, tree->n, [](int) { return true; }, [&](int c) { return L::load(x + c * nv + first, room); },
          [&](int c, const Several& a) { L::store(a, x + c * nv + first, room); }, W, u);
    }
  }

 private:
  /// The step at joint i of the backward sweep (from the leaves to the root) that solves equations with the
  /// mass matrix, after the joint has been eliminated. x (nv numbers) are the right sides, such as drive
  /// forces. On entry, (m, f) is the wrench W on body i about its origin: its own bias wrench plus what its
  /// children pass to it. For each screw S of the joint, from the last to the first, the remaining joint
  /// force is g = x_k - Sᵀ W with the entry x_k of x. The step stores u = g/D and adds the wrench g K to W,
  /// with the pivot D and K = M S/D, where M is the articulated inertia of the body before S is eliminated.
  /// On return, (m, f) is the wrench on the predecessor about the origin of the predecessor.
  template <class S>
  [[gnu::always_inline]] void pass_wrench(const Tree<S>& tree, int i, const T* x, Vector& m,
                                          Vector& f) noexcept {
    const Body& b = body[i];
    if (is_hinge(tree, i)) [[likely]] {
      Pivot& c = pivot[tree->first_screw[i]];
      const Number g = Number(x[tree->iv[i]]) - dot(b.n, m);
      c.u = c.D_inv * g;
      m += cross(Factor(b.r), Factor(f)) + g * c.K_m;
      f += g * c.K_f;
      return;
    }
    for (int s = tree->first_screw[i + 1]; s-- > tree->first_screw[i];) {
      Pivot& c = pivot[s];
      const Number g = Number(x[tree->iv[i] + s - tree->first_screw[i]]) - dot(c.w, m, c.v, f);
      c.u = c.D_inv * g;
      m += g * c.K_m;
      f += g * c.K_f;
    }
    m += cross(Factor(b.r), Factor(f));
  }

  /// Runs the backward sweep, from the leaves to the root: eliminates the joints and, if `forces` is set,
  /// computes u = (τ - Sᵀ W)/D for every joint screw S. τ is the joint force of S, an entry of `tau`, W the
  /// bias wrench on the body that the joint moves, and D the pivot.
  template <bool forces, class S> void sweep(const Tree<S>& tree, const T* tau) noexcept {
    Articulated M{};
    Vector m{}, f{};
    for (int i = tree->n; i > 0; --i) {
      M += inertia(tree, i);
      if (tree->branches[i]) M += child_sum[i].M;
      if constexpr (forces) {
        m += body[i].m;
        f += body[i].f;
        if (tree->branches[i]) {
          m += child_sum[i].m;
          f += child_sum[i].f;
          child_sum[i].m = child_sum[i].f = Vector{};
        }
      }
      if (is_hinge(tree, i)) [[likely]]
        eliminate_hinge(tree, i, tree.armature.data(), M);
      else
        eliminate_screws(tree, i, tree.armature.data(), M);
      if constexpr (forces) pass_wrench(tree, i, tau, m, f);
      const int p = tree->parent[i];
      if (p > 0 && p != i - 1) {
        child_sum[p].M += M;
        if constexpr (forces) {
          child_sum[p].m += m;
          child_sum[p].f += f;
        }
      }
      if (p != i - 1 || p == 0) {
        M = {};
        m = f = Vector{};
      }
    }
  }

  /// Solves M X = B with the factorised mass matrix M, for as many columns of X and B as fill a register.
  /// reaches(i) says whether B is non-zero at a joint in the subtree of body i; this must be false for all
  /// bodies after `last`. right_side(c) is row c of B. put(c, x) receives row c of X for the velocities of
  /// bodies 1 to `last`.
  template <class S, class Reaches, class RightSide, class Put>
  [[gnu::always_inline]] void solve(const Tree<S>& tree, int last, const Reaches& reaches,
                                    const RightSide& right_side, const Put& put, Columns* const W,
                                    Several* const u) noexcept {
    const Body* const bodies = body;  // local copies of the pointers, which no stored result can change
    const Pivot* const pivots = pivot;
    for (int i = 0; i <= last; ++i)
      if (tree->branches[i]) W[i] = {};
    Columns F{};
    for (int i = last; i > 0; --i) {
      if (!reaches(i)) continue;
      const int p = tree->parent[i], first_screw = tree->first_screw[i], c = tree->iv[i];
      const Vec3<Several> r = vector(bodies[i].r);
      if (tree->branches[i]) {
        F.m += W[i].m;
        F.f += W[i].f;
      }
      if (is_hinge(tree, i)) [[likely]] {
        const Pivot& s = pivots[first_screw];
        const Several g = less(right_side(c), vector(bodies[i].n), F.m);
        u[first_screw] = value(s.D_inv) * g;
        F.m = F.m + cross(r, F.f) + g * vector(s.K_m);
        F.f += g * vector(s.K_f);
      } else {
        with_count(
            tree->first_screw[i + 1] - first_screw, [&](auto n) __attribute__((always_inline)) {
              pass_to_parent(
                  n, first_screw, [&](int k) { return right_side(c + k); }, u + first_screw, p > 0, F);
            });
        F.m += cross(r, F.f);
      }
      if (p == i - 1) continue;
      W[p].m += F.m;
      W[p].f += F.f;
      F = {};
    }
    Columns X{};
    W[0] = X;
    for (int i = 1; i <= last; ++i) {
      if (tree->parent[i] != i - 1) X = W[tree->parent[i]];
      const int first_screw = tree->first_screw[i], c = tree->iv[i];
      const bool reached = reaches(i);
      const auto free = [&](int k) { return reached ? u[first_screw + k] : Several(T(0)); };
      const Vec3<Several> moved = X.f + cross(X.m, vector(bodies[i].r));
      if (is_hinge(tree, i)) [[likely]] {
        const Pivot& s = pivots[first_screw];
        const Several a = less(free(0), vector(s.K_m), X.m) - dot(vector(s.K_f), X.f);
        put(c, a);
        X.m += a * vector(bodies[i].n);
        X.f = moved;
      } else {
        X.f = moved;
        with_count(
            tree->first_screw[i + 1] - first_screw, [&](auto n) __attribute__((always_inline)) {
              set_in_motion(
                  n, first_screw, free, [&](int k, const Several& a) { put(c + k, a); }, tree->parent[i] > 0,
                  X);
            });
      }
      if (tree->branches[i]) W[i] = X;
    }
  }
  /// The step at one joint of the backward sweep (from the leaves to the root) that solves M X = B with the
  /// mass matrix M for several columns at once. The joint has the screws s to s + n - 1, and right_side(k) is
  /// the row of B for screw s + k. On entry, F is the sum of the wrenches that the joints of the children
  /// transmit, about the origin of the body. u[k] receives the joint acceleration along screw s + k if the
  /// predecessor and the earlier screws of the joint have no acceleration. Unless the joint is on the ground,
  /// F becomes the wrench that the joint transmits if the predecessor has no acceleration, about the origin
  /// of the body.
  template <int n, class RightSide>
  [[gnu::always_inline]] void pass_to_parent(std::integral_constant<int, n>, int s,
                                             const RightSide& right_side, Several* u, bool on_a_body,
                                             Columns& F) const noexcept {
    const Pivot* const c = pivot + s;
    Several g[n];
    unrolled<n>([&](auto k) { g[k] = less(right_side(k), vector(c[k].w), F.m) - dot(vector(c[k].v), F.f); });
    unrolled<n>([&](auto m) {
      constexpr int l = n - 1 - m;
      unrolled<l>([&](auto k) { g[k] = g[k] - S_K[s + k][l] * g[l]; });
    });
    unrolled<n>([&](auto k) { u[k] = value(c[k].D_inv) * g[k]; });
    if (on_a_body)
      unrolled<n>([&](auto k) { F.m += g[k] * vector(c[k].K_m), F.f += g[k] * vector(c[k].K_f); });
  }
  /// The step at one joint of the forward sweep (from the root to the leaves) that solves equations with the
  /// mass matrix for several right sides at once. The joint has the screws s to s + n - 1. free(k) is the
  /// joint acceleration along screw s + k if the predecessor and the earlier screws of the joint have no
  /// acceleration, and put(k, x) is called with the acceleration x that the solution has. On entry, X is the
  /// acceleration of the predecessor (0 for the ground), on return that of the body, both at the origin of
  /// the body.
  template <int n, class Free, class Put>
  [[gnu::always_inline]] void set_in_motion(std::integral_constant<int, n>, int s, const Free& free,
                                            const Put& put, bool on_a_body, Columns& X) const noexcept {
    const Pivot* const c = pivot + s;
    Several a[n];
    unrolled<n>([&](auto k) { a[k] = free(k); });
    if (on_a_body)
      unrolled<n>([&](auto k) { a[k] = less(a[k], vector(c[k].K_m), X.m) - dot(vector(c[k].K_f), X.f); });
    unrolled<n>([&](auto l) { unrolled<l>([&](auto k) { a[l] = a[l] - S_K[s + k][l] * a[k]; }); });
    unrolled<n>([&](auto k) {
      put(k, a[k]);
      X.m += a[k] * vector(c[k].w);
      X.f += a[k] * vector(c[k].v);
    });
  }
  /// Calls f(n) with n, the number of screws of a joint (1, 3 or 6), as a compile-time constant.
  template <class F> [[gnu::always_inline]] static void with_count(int n, const F& f) {
    if (n == 1)
      f(std::integral_constant<int, 1>{});
    else if (n == 3)
      f(std::integral_constant<int, 3>{});
    else
      f(std::integral_constant<int, 6>{});
  }
  /// Computes S_K, the coupling S_k | K_l between the screws k < l of each joint that is not a hinge.
  template <class S> void couple(const Tree<S>& tree) noexcept {
    for (int i = 1; i <= tree->n; ++i)
      if (!is_hinge(tree, i))
        for (int k = tree->first_screw[i]; k < tree->first_screw[i + 1]; ++k)
          for (int l = k + 1; l < tree->first_screw[i + 1]; ++l)
            S_K[k][l - tree->first_screw[i]] = value(dot(pivot[k].w, pivot[l].K_m, pivot[k].v, pivot[l].K_f));
  }
  /// The difference x - a · b.
  static Several less(const Several& x, const Vec3<Several>& a, const Vec3<Several>& b) noexcept {
    return ((x - a.x * b.x) - a.y * b.y) - a.z * b.z;
  }
  static Vec3<Several> vector(const Vector& a) { return spread<Several, T>(a); }
  /// 1 in lane k and 0 in all others; if there is no lane k, all lanes are 0.
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
  /// Computes, in inertial axes, the rotation of the joint frame of body i, the vector to the origin of this
  /// frame from the origin of the joint frame of the predecessor, and the inertia of body i about the origin
  /// of its joint frame. Before the call last_R must be the rotation of the joint frame of body i - 1; after
  /// the call it is that of body i.
  template <class S>
  [[gnu::always_inline]] void update_kinematics(const Tree<S>& tree, int i, const T* q,
                                                Matrix& last_R) noexcept {
    const int p = tree->parent[i];
    if (p != i - 1) last_R = R[p];
    const auto& body_i = constants<G, T>(tree, i);
    const auto at = axode::place<G>(tree, i, q, angles, last_R);
    Body& b = body[i];
    last_R = at.R;
    b.n = at.R.z;
    b.r = at.r;
    b.h = at.R * Spread(body_i.h);
    b.Theta = rotate(at.R, body_i.Theta);
    if (tree->branches[i]) {
      R[i] = at.R;
      child_sum[i] = {};
    }
    if (!is_hinge(tree, i)) R[i] = at.R;
  }
  /// The inertia of body i alone, before any elimination.
  template <class S> Articulated inertia(const Tree<S>& tree, int i) const noexcept {
    return articulated(body[i].Theta, body[i].h, constants<G, T>(tree, i).m);
  }

  /// The pivot of joint screw s at or below which the mass matrix may be singular.
  template <class S> static T floor_of(const Tree<S>& tree, int s) noexcept {
    return T(pivot_threshold<S> * tree.inertia_scale[s]);
  }
  /// Eliminates the hinge of body i. M, the articulated inertia of body i, becomes the contribution to the
  /// inertia of the predecessor, about the origin of the predecessor.
  template <class S>
  [[gnu::always_inline]] void eliminate_hinge(const Tree<S>& tree, int i, const S* armature,
                                              Articulated& M) noexcept {
    const Body& b = body[i];
    const auto [U_m, U_f] = about_axis(M, b.n);
    const Number D = dot(b.n, U_m) + Number(T(armature[tree->iv[i]])), D_inv = Number(T(1)) / D;
    maybe_singular = maybe_singular || !(value(D) > floor_of(tree, tree->first_screw[i]));
    const Vector moved = U_m + cross(Factor(b.r), Factor(U_f));
    shift(M, b.r);
    const Vector K_m = D_inv * moved, K_f = D_inv * U_f;
    eliminate(M, moved, U_f, K_m, K_f);
    Pivot& c = pivot[tree->first_screw[i]];
    c.K_m = K_m;
    c.K_f = K_f;
    c.D_inv = D_inv;
  }
  /// Eliminates the screws of joint i, of any kind. M becomes its contribution to the predecessor's inertia.
  template <class S>
  [[gnu::noinline]] void eliminate_screws(const Tree<S>& tree, int i, const S* armature,
                                          Articulated& M) noexcept {
    const Body& b = body[i];
    Pivot* c = pivot + tree->first_screw[i];
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      constexpr int n = std::decay_t<decltype(joint)>::nv;
      static_assert(n == 1 || n == 3 || n == 6, "with_count knows no other");
      for (int k = n; k-- > 0;) {
        const Screw<T> X = joint.column(k);
        c[k].w = R[i] * Spread(Vector(X.w));
        c[k].v = R[i] * Spread(Vector(X.v));
        const auto [U_m, U_f] = along_twist(M, c[k].w, c[k].v);
        const Number D = dot(c[k].w, U_m, c[k].v, U_f) + Number(T(armature[tree->iv[i] + k]));
        c[k].D_inv = Number(T(1)) / D;
        c[k].K_m = c[k].D_inv * U_m;
        c[k].K_f = c[k].D_inv * U_f;
        maybe_singular = maybe_singular || !(value(D) > floor_of(tree, tree->first_screw[i] + k));
        eliminate(M, U_m, U_f, c[k].K_m, c[k].K_f);
      }
    });
    shift(M, b.r);
  }
};

}  // namespace axode
