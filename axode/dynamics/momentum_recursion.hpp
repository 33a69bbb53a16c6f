#pragma once
#include "axode/dynamics/forward_dynamics_recursion.hpp"
#include "axode/dynamics/spatial_tree.hpp"

namespace axode {

/// Σ of something of every body over the subtree behind each joint.
template <class T, class X> void sum_subtrees(const Tree<T>& tree, X* x) noexcept {
  for (int i = tree.n; i > 0; --i) x[tree.parent[i]] += x[i];
}

/// Spatial twists of all bodies.
template <class T> void spatial_twists(const SpatialTree<T>& s, const T* v, Twist<Spatial, T>* V) noexcept {
  V[0] = {};
  for (int i = 1; i <= s.tree.n; ++i) {
    V[i] = V[s.tree.parent[i]];
    s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { V[i] += v[c] * J; });
  }
}

/// The momenta of the subtrees, Π_i^A; that of everything is entry 0.
template <class T>
Momentum<Spatial, T>* subtree_momenta(SpatialTree<T>& s, const Twist<Spatial, T>* V) noexcept {
  Momentum<Spatial, T>* Pi = s.arena.template per_body<Momentum<Spatial, T>>();
  for (int i = 0; i <= s.tree.n; ++i) Pi[i] = s.M_body[i] * V[i];
  sum_subtrees(s.tree, Pi);
  return Pi;
}

template <class T> Twist<Spatial, T>* twists_at(SpatialTree<T>& s, const T* v) noexcept {
  Twist<Spatial, T>* V = s.arena.template per_body<Twist<Spatial, T>>();
  spatial_twists(s, v, V);
  return V;
}

/// The rates v and dp of the state (q, p), see momentum_form().
template <class T, TreeOf<T> AnyTree>
Solvability solve_momentum_form(const AnyTree& tree, Workspace<T>& workspace, const T* q, const T* p,
                                const T* tau, const Loads<T>& loads, T* v, T* dp) noexcept {
  SpatialTree<T> s(tree, workspace, q);
  typename Workspace<T>::Arena rest = s.arena;
  const MassMatrixSolver<Spatial, T> solver{tree, rest, s.link};
  for (int c = 0; c < tree.nv; ++c) v[c] = p[c];
  solver.solve(v);

  const Twist<Spatial, T>* V = twists_at(s, v);
  const Momentum<Spatial, T>* Pi = subtree_momenta(s, V);
  Wrench<Spatial, T>* W = s.arena.template per_body<Wrench<Spatial, T>>();
  for (int i = 0; i <= tree.n; ++i) W[i] = s.M_body[i] * TwistRate<Spatial, T>{{}, tree.g};
  if (!loads.wrenches.empty()) {
    SE3<T>* C = s.arena.template per_body<SE3<T>>();
    Wrench<BodyFixed, T>* W_app = s.arena.template per_body<Wrench<BodyFixed, T>>();
    for (int i = 0; i <= tree.n; ++i) C[i] = s.link[i].C;
    sum_applied(tree, loads.wrenches, C, W_app);
    for (int i = 0; i <= tree.n; ++i) W[i] += s.link[i].push(W_app[i]);
  }
  sum_subtrees(tree, W);
  for (int c = 0; c < tree.nv; ++c) dp[c] = loads.joint_losses ? tau[c] - joint_loss(tree, c, v[c]) : tau[c];
  for (int i = 1; i <= tree.n; ++i)
    s.each_screw(i, [&](int c, const Twist<Spatial, T>& J) { dp[c] += (W[i] | J) + (Pi[i] | ad(V[i], J)); });
  return solver.solvability();
}

}  // namespace axode
