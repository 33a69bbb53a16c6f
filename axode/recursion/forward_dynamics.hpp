#pragma once
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// Forward dynamics in one representation: a = M⁻¹ (τ - h), where h is inverse dynamics at a = 0.
template <class Rep, class T> struct ForwardDynamicsRecursion {
  InverseDynamicsRecursion<Rep, T> recursion;
  ArticulatedBodies<Rep, T> bodies;
  T *zero, *x;

  explicit ForwardDynamicsRecursion(Arena& arena)
      : recursion(arena), bodies(arena), zero(arena.per_velocity<T>()), x(arena.per_velocity<T>()) {}

  /// Writes the accelerations to `a`, which may share the memory of an argument. If M is not positive
  /// definite or a number is not finite, the result says so; if M is singular, all of `a` is NaN. O(n).
  template <TreeOf<T> AnyTree>
  Solvability run(const AnyTree& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads,
                  T* a) noexcept {
    for (int c = 0; c < tree->nv; ++c) zero[c] = T(0);
    recursion.run(tree, q, v, zero, loads);
    recursion.project(tree, v, zero, loads.joint_losses, x);
    for (int c = 0; c < tree->nv; ++c) x[c] = tau[c] - x[c];
    bodies.links.link = recursion.motion.bodies.link;
    const Solvability verdict = bodies.factorize(tree, tree.armature.data());
    if (verdict.ok()) bodies.solve(tree, x);
    for (int c = 0; c < tree->nv; ++c) a[c] = x[c];
    return solved(verdict, tree->nv, a);
  }
};

}  // namespace axode
