#pragma once
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// Forward dynamics in one representation of twists, by the articulated-body algorithm in three passes
/// ((D4.14) of docs/derivations). The first computes the motion that the bodies have if all joint
/// accelerations are 0, and the wrenches that they need for it. The second eliminates the joints from the
/// leaves to the roots. The third computes the accelerations from the roots to the leaves.
template <class Rep, class T> struct ForwardDynamicsRecursion {
  ArticulatedBodies<Rep, T> bodies;
  Twist<Rep, T>* V;
  TwistRate<Rep, T>* bias;  ///< V'_i - down(V'_p) at a = 0; entry 0 is that of the ground, (0, -g)
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T* x;

  explicit ForwardDynamicsRecursion(Arena& arena)
      : bodies(arena),
        V(arena.per_body<Twist<Rep, T>>()),
        bias(arena.per_body<TwistRate<Rep, T>>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        x(arena.per_velocity<T>()) {}

  /// Writes the accelerations to `a`, which may share the memory of an argument. Returns whether the mass
  /// matrix is positive definite and all numbers are finite; if it is singular, `a` is NaN. O(n).
  template <TreeOf<T> AnyTree>
  Solvability run(const AnyTree& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads,
                  T* a) noexcept {
    joint_poses(tree, q, bodies.links.C_pi);
    if (!loads.wrenches.empty()) {
      C.run(tree, bodies.links.C_pi);
      sum_applied(tree, loads.wrenches, C.C, W_app);
    }
    bodies.links.run(tree);
    bodies.put_screws_and_inertias(tree);
    put_motion(tree, v);
    if (!loads.wrenches.empty())
      for (int i = 1; i <= tree->n; ++i) bodies.W[i] -= push(bodies.links.link[i], W_app[i]);
    for (int c = 0; c < tree->nv; ++c)
      x[c] = loads.joint_losses ? tau[c] - joint_loss(tree, c, v[c]) : tau[c];
    const Solvability verdict = bodies.eliminate_joints(tree, tree.armature.data());
    if (verdict.ok()) bodies.accelerate(tree, bias, x);
    for (int c = 0; c < tree->nv; ++c) a[c] = x[c];
    return solved(verdict, tree->nv, a);
  }

 private:
  /// Computes V, `bias` and, in bodies.W, the wrench that each body needs to keep its twist.
  template <class AnyTree> void put_motion(const AnyTree& tree, const T* v) noexcept {
    V[0] = {};
    bias[0] = {{}, -tree.g};
    for (int i = 1; i <= tree->n; ++i) {
      const Link<Rep, T>& link = bodies.links.link[i];
      const T* const v_i = v + tree->iv[i];
      const int first = tree->first_screw[i];
      Twist<Rep, T> Sv{};
      for (int s = first; s < tree->first_screw[i + 1]; ++s)
        Sv = s == first ? v_i[0] * bodies.S[s] : Sv + v_i[s - first] * bodies.S[s];
      const Twist<Rep, T> V_p = V[tree->parent[i]];
      V[i] = link.down(V_p) + Sv;
      bias[i] = link.bias(V_p, V[i], Sv);
      bodies.W[i] = velocity_wrench(link, bodies.M_body[i], V[i]);
    }
  }
};

}  // namespace axode
