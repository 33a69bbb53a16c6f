#pragma once
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"
#include "axode/recursion/spatial_tree.hpp"

namespace axode {

/// Lets articulated bodies use the links, the screws and the inertias of a spatial tree.
template <class T> void use(const SpatialTree<T>& spatial, ArticulatedBodies<Spatial, T>& bodies) noexcept {
  bodies.links.link = spatial.link;
  bodies.S = spatial.J;
  bodies.M_body = spatial.M_body;
}

/// The rates of the state (q, p): v = M⁻¹ p, and p' = τ + Jᵀ W^A + (ad_V J)ᵀ Π^A, where W^A and Π^A are the
/// wrench on and the momentum of the subtree of each joint. See momentum_form().
/// See (D5.1) of docs/derivations.
template <class T> struct MomentumForm {
  SpatialTree<T> spatial;
  SubtreeMomenta<T> momenta;
  ArticulatedBodies<Spatial, T> bodies;
  Wrench<Spatial, T>* W;
  Wrench<BodyFixed, T>* W_app;
  T *velocity, *force;

  explicit MomentumForm(Arena& arena)
      : spatial(arena),
        momenta(arena),
        bodies(arena),
        W(arena.per_body<Wrench<Spatial, T>>()),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        velocity(arena.per_velocity<T>()),
        force(arena.per_velocity<T>()) {}

  /// Writes v and p' (nv numbers each), which may share the memory of arguments. If M is singular, both are
  /// NaN.
  template <TreeOf<T> AnyTree>
  Solvability run(const AnyTree& tree, const T* q, const T* p, const T* tau, const Loads<T>& loads, T* v,
                  T* dp) noexcept {
    spatial.run(tree, q);
    use(spatial, bodies);
    Solvability verdict = bodies.eliminate_joints(tree, tree.armature.data());
    for (int c = 0; c < tree->nv; ++c) velocity[c] = p[c];
    if (verdict.ok()) bodies.solve(tree, velocity);
    verdict = solved(verdict, tree->nv, velocity);

    momenta.run(spatial, velocity);
    for (int i = 0; i <= tree->n; ++i) W[i] = spatial.M_body[i] * TwistRate<Spatial, T>{{}, tree.g};
    if (!loads.wrenches.empty()) {
      SE3<T>* const C = spatial.links.C_pi;
      for (int i = 0; i <= tree->n; ++i) C[i] = spatial.pose(i);
      sum_applied(tree, loads.wrenches, C, W_app);
      for (int i = 0; i <= tree->n; ++i) W[i] += push(spatial.link[i], W_app[i]);
    }
    sum_subtrees(*spatial.topology, W);
    for (int c = 0; c < tree->nv; ++c)
      force[c] = loads.joint_losses ? tau[c] - joint_loss(tree, c, velocity[c]) : tau[c];
    for (int i = 1; i <= tree->n; ++i)
      spatial.each_screw(i, [&](int c, const Twist<Spatial, T>& J) {
        force[c] += (W[i] | J) + (momenta.Pi[i] | ad(momenta.V[i], J));
      });
    for (int c = 0; c < tree->nv; ++c) {
      v[c] = velocity[c];
      dp[c] = force[c];
    }
    return solved(verdict, tree->nv, dp);
  }
};

}  // namespace axode
