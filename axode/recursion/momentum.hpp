#pragma once
#include <algorithm>
#include <limits>

#include "axode/recursion/articulated_bodies.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// Computes -ad_Vᵀ Π in representation Rep: the rate of a momentum Π that is carried along by a body with the
/// twist V. In hybrid representation Π and V are about the origin of the body in inertial axes; in mixed
/// representation the angular parts are in the axes of the body and the linear parts in inertial axes.
template <class Rep, class T>
constexpr Wrench<Rep, T> convected(const Link<Rep, T>& link, const Twist<Rep, T>& V,
                                   const Wrench<Rep, T>& Pi) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  if constexpr (std::same_as<Rep, Mixed>)
    return {cross(V.w, Pi.m) + transpose(link.R) * cross(V.v, Pi.f), cross(link.R * V.w, Pi.f)};
  else
    return {cross(V.w, Pi.m) + cross(V.v, Pi.f), cross(V.w, Pi.f)};
}

/// The wrench of gravity g on a body, in Rep. g is in body axes for body-fixed twists, and in inertial axes
/// for all others. M is the inertia of the body in the representation Rep.
template <class Rep, class T>
constexpr Wrench<Rep, T> gravity_wrench(const Link<Rep, T>& link, const Inertia<T>& M, const Vec3<T>& g) {
  if constexpr (std::same_as<Rep, Mixed>)
    return {cross(M.h, transpose(link.R) * g), M.m * g};
  else
    return {cross(M.h, g), M.m * g};
}

/// Computes the rates v and p' of the state (q, p) with the momenta p = M v, in one representation of twists.
/// v = M⁻¹ p follows by the articulated-body algorithm, and p' from wrenches and momenta that are summed over
/// subtrees, from the leaves to the roots ((D5.1) and (D5.9) of docs/derivations).
template <class Rep, class T> struct MomentumForm {
  ArticulatedBodies<Rep, T> bodies;
  Wrench<Rep, T>* Pi;  ///< momentum of each subtree, l and p
  Wrench<Rep, T>* W;   ///< gravity and loads on each subtree
  Vec3<T>* g;          ///< gravity in body axes; used by body-fixed twists
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T *velocity, *force;

  explicit MomentumForm(Arena& arena)
      : bodies(arena),
        Pi(arena.per_body<Wrench<Rep, T>>()),
        W(arena.per_body<Wrench<Rep, T>>()),
        g(arena.per_body<Vec3<T>>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        velocity(arena.per_velocity<T>()),
        force(arena.per_velocity<T>()) {}

  /// Computes the velocities v = M⁻¹ p and the rates p' of the momenta from the coordinates q, the momenta p,
  /// the drive forces tau and the loads. v, p, p' and tau have nv numbers; v and dp, which receives p', may
  /// share the memory of the arguments. If the mass matrix is singular, v and p' are NaN. O(n).
  template <TreeOf<T> AnyTree>
  Solvability run(const AnyTree& tree, const T* q, const T* p, const T* tau, const Loads<T>& loads, T* v,
                  T* dp) noexcept {
    joint_poses(tree, q, bodies.links.C_pi);
    if (!loads.wrenches.empty()) {
      C.run(tree, bodies.links.C_pi);
      sum_applied(tree, loads.wrenches, C.C, W_app);
    }
    bodies.links.run(tree);
    Solvability verdict = bodies.factorize(tree, tree.armature.data());
    for (int c = 0; c < tree->nv; ++c) velocity[c] = p[c];
    if (verdict.ok()) bodies.solve(tree, velocity);
    verdict = solved(verdict, tree->nv, velocity);

    for (int c = 0; c < tree->nv; ++c)
      force[c] = loads.joint_losses ? tau[c] - joint_loss(tree, c, velocity[c]) : tau[c];
    if (verdict.ok()) add_body_forces(tree, !loads.wrenches.empty());
    for (int c = 0; c < tree->nv; ++c) {
      v[c] = velocity[c];
      dp[c] = force[c];
    }
    return solved(verdict, tree->nv, dp);
  }

 private:
  /// Adds a force to `force` for every joint screw S of each body: the power of the wrench W^c + ad_Vᵀ Π^c
  /// along S. V is the twist of the body. W^c is the sum of the wrenches of gravity and loads on
  /// the bodies of the subtree, the body itself included, and Π^c the sum of their momenta.
  template <class AnyTree> void add_body_forces(const AnyTree& tree, bool has_wrenches) noexcept {
    const auto& link = bodies.links.link;
    g[0] = tree.g;
    for (int i = 1; i <= tree->n; ++i) {
      g[i] = tree.g;
      if constexpr (std::same_as<Rep, BodyFixed>) g[i] = transpose(link[i].C_pi.R) * g[tree->parent[i]];
      Pi[i] = impulse(link[i], bodies.M_body[i], bodies.X[i]);
      W[i] = gravity_wrench(link[i], bodies.M_body[i], g[i]);
      if (has_wrenches) W[i] += push(link[i], W_app[i]);
    }
    for (int i = tree->n; i > 0; --i) {
      const Wrench<Rep, T> sum = W[i] - convected(link[i], bodies.X[i], Pi[i]);
      const int first = tree->first_screw[i];
      for (int s = first; s < tree->first_screw[i + 1]; ++s)
        force[tree->iv[i] + s - first] += sum | bodies.S[s];
      const int p = tree->parent[i];
      if (p == 0) continue;
      Pi[p] += link[i].up(Pi[i]);
      W[p] += link[i].up(W[i]);
    }
  }
};

/// Computes the rates of the state (q, Π), where Π are the spatial momenta of all bodies, by Müller's eq.
/// PEs with erratum 24 of docs/errata.md:
///   (J^s)ᵀ (Π' - W_app) = τ,    M_i^s J_i^s v = Π_i^s.
/// J^s is the spatial Jacobian of all bodies, τ are the drive forces, and W_app the applied wrenches. Body i
/// has the spatial inertia M_i^s, the Jacobian J_i^s and the momentum Π_i^s. Both equations are solved in
/// O(n) by a sweep from the leaves to the roots and one from the roots to the leaves ((D5.8), (D5.10) and
/// (D5.11) of docs/derivations).
template <class T> struct SpatialMomentumForm {
  ArticulatedBodies<Spatial, T> bodies;
  Wrench<Spatial, T>* W;
  TwistRate<Spatial, T>* bias;  ///< V'_i - V'_p at a = 0; entry 0 is the acceleration of the ground, (0, -g)
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T *velocity, *x;

  explicit SpatialMomentumForm(Arena& arena)
      : bodies(arena),
        W(arena.per_body<Wrench<Spatial, T>>()),
        bias(arena.per_body<TwistRate<Spatial, T>>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        velocity(arena.per_velocity<T>()),
        x(arena.per_velocity<T>()) {}

  /// Writes the joint velocities v (nv numbers) that belong to the momenta Π of the n bodies, and the rates
  /// Π' of these momenta. The results may share the memory of arguments. v is computed with the mass matrix
  /// without armatures, which have no part in the momenta of bodies; Π' follows from accelerations, which are
  /// computed with the mass matrix with armatures. If the mass matrix without armatures is singular, v and Π'
  /// are NaN. Π' alone is NaN if the mass matrix with armatures is singular or a number is not finite. O(n).
  Solvability run(const Tree<T>& tree, const T* q, const Momentum<Spatial, T>* Pi, const T* tau,
                  const Loads<T>& loads, T* v, Wrench<Spatial, T>* dPi) noexcept {
    joint_poses(tree, q, bodies.links.C_pi);
    if (!loads.wrenches.empty()) {
      C.run(tree, bodies.links.C_pi);
      sum_applied(tree, loads.wrenches, C.C, W_app);
    }
    bodies.links.run(tree);
    bodies.put_screws_and_inertias(tree);
    Vec3<T>* const origin = bodies.links.origin;
    for (int i = 1; i <= tree->n; ++i)
      if (tree->parent[i] > 0) origin[i] = origin[tree->parent[i]];

    Solvability verdict = put_velocities(tree, Pi);
    for (int c = 0; c < tree->nv; ++c)
      x[c] = loads.joint_losses ? tau[c] - joint_loss(tree, c, velocity[c]) : tau[c];
    if (verdict.ok()) verdict = put_accelerations(tree, !loads.wrenches.empty());
    const Vec3<T> nan = T(std::numeric_limits<double>::quiet_NaN()) * Vec3<T>{T(1), T(1), T(1)};
    for (int i = 1; i <= tree->n; ++i) {
      const Twist<Spatial, T>& X = bodies.X[i];  // V'_i - (0, g)
      const Wrench<Spatial, T> rate = W[i] + bodies.M_body[i] * TwistRate<Spatial, T>{X.w, X.v + tree.g};
      dPi[i - 1] = verdict.ok() ? Wrench<Spatial, T>{rate.m + cross(origin[i], rate.f), rate.f}
                                : Wrench<Spatial, T>{nan, nan};
    }
    for (int c = 0; c < tree->nv; ++c) v[c] = velocity[c];
    return verdict;
  }

 private:
  /// Solves (JᵀMJ) v = JᵀΠ for the joint velocities v, with the Jacobian J, the inertias M and the momenta Π
  /// of all bodies. Armatures are left out, because they have no part in these momenta. bodies.X receives the
  /// twists J v.
  Solvability put_velocities(const Tree<T>& tree, const Momentum<Spatial, T>* Pi) noexcept {
    for (int c = 0; c < tree->nv; ++c) velocity[c] = x[c] = T(0);
    const Solvability verdict = bodies.eliminate_joints(tree, x);
    for (int i = 1; i <= tree->n; ++i) {
      const Momentum<Spatial, T>& given = Pi[i - 1];  // the given momentum is about the inertial origin
      bodies.W[i] = {cross(bodies.links.origin[i], given.p) - given.l, T(-1) * given.p};
    }
    if (verdict.ok()) bodies.accelerate(tree, nullptr, velocity);
    return solved(verdict, tree->nv, velocity);
  }

  /// Computes the joint accelerations from Jᵀ (Π' - W_app) = τ with Π' = M V' - ad_Vᵀ M V, where J is the
  /// Jacobian, M the inertia, V the twist and W_app the applied wrench of all bodies. W receives -ad_Vᵀ M V,
  /// and bodies.X receives V' minus the acceleration of gravity (0, g).
  Solvability put_accelerations(const Tree<T>& tree, bool has_wrenches) noexcept {
    bias[0] = {{}, T(-1) * tree.g};
    bodies.X[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const Twist<Spatial, T> moved = ad(bodies.X[tree->parent[i]], bodies.X[i]);
      bias[i] = {moved.w, moved.v};
      W[i] = velocity_wrench(bodies.M_body[i], bodies.X[i]);
    }
    Solvability verdict;
    if (std::ranges::any_of(tree.armature, [](const T& I) { return I != T(0); }))
      verdict = bodies.eliminate_joints(tree, tree.armature.data());
    for (int i = 1; i <= tree->n; ++i) {
      bodies.W[i] = W[i];
      if (has_wrenches) bodies.W[i] -= push(bodies.links.link[i], W_app[i]);
    }
    if (verdict.ok()) bodies.accelerate(tree, bias, x);
    return solved(verdict, tree->nv, x);
  }
};

}  // namespace axode
