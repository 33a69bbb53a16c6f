#pragma once
#include "axode/fast/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// Forward dynamics for trees without coupled joints whose mass matrix is far from singular.
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

  /// Writes the accelerations a, which may share the memory of an argument. Returns false and writes nothing
  /// if joints are coupled or the mass matrix may be singular.
  bool run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads, T* a) noexcept {
    if (!prepare(tree, q, v, tau, loads, [](int, const auto&, const auto&, const auto&) {})) return false;
    bodies.accelerate(tree, motion, a);
    return true;
  }
  /// The forward sweep for zero joint accelerations and the backward sweep that eliminates the joints; the
  /// third sweep, accelerate(), then computes the joint accelerations. Calls put(i, R, motion, u) for every
  /// body i with its rotation R; its angular velocity, its angular acceleration and the acceleration of its
  /// origin (`motion`), for zero joint accelerations and the acceleration -g of the ground; and the velocity
  /// u of its origin minus that of the origin of its predecessor. All are in inertial axes. Returns false if
  /// joints are coupled or the mass matrix may be singular.
  template <class Put>
  [[gnu::always_inline]] bool prepare(const Tree<T>& tree, const T* q, const T* v, const T* tau,
                                      const Loads<T>& loads, Put&& put) noexcept {
    if (!tree->coupled_bodies.empty()) return false;
    bodies.update_kinematics_and_bias(tree, q, v, motion, put);
    if (!loads.wrenches.empty()) apply(tree, q, loads.wrenches);
    const T* force = tau;
    if (loads.joint_losses) {
      for (int c = 0; c < tree->nv; ++c) drive[c] = tau[c] - joint_loss(tree, c, v[c]);
      force = drive;
    }
    bodies.maybe_singular = false;
    bodies.factorize(tree, force);
    return !bodies.maybe_singular;
  }

 private:
  /// Subtracts the applied wrenches from the bias wrenches of the bodies.
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
      bodies.body[i].m -= R * W_app[i].m;
      bodies.body[i].f -= R * W_app[i].f;
    }
  }
};

/// The inverse mass matrix for trees without coupled joints whose mass matrix is far from singular.
template <class T> struct FastInverse {
  using Bodies = FastArticulatedBodies<typename FastGeometry<T>::type, T>;
  Bodies bodies;
  typename Bodies::Columns* columns;
  typename Bodies::Several* u;

  explicit FastInverse(Arena& arena)
      : bodies(arena),
        columns(arena.per_body<typename Bodies::Columns>()),
        u(arena.per_screw<typename Bodies::Several>()) {}

  /// Writes the inverse of the mass matrix at q (nv × nv). Returns false and writes nothing if joints are
  /// coupled or the mass matrix may be singular.
  bool run(const Tree<T>& tree, const T* q, T* M_inverse) noexcept {
    if (!tree->coupled_bodies.empty()) return false;
    bodies.update_kinematics(tree, q);
    bodies.factorize(tree);
    if (bodies.maybe_singular) return false;
    bodies.inverse(tree, columns, u, M_inverse);
    return true;
  }
};

}  // namespace axode
