#pragma once
#include "axode/kinematics/forward_recursion.hpp"

namespace axode {

/// What every formula on joint screws in spatial representation starts from: J_i^s of all joints and the
/// inertia M_i^c of all that joint i moves, about the inertial origin.
template <class T> struct SpatialTree {
  const Tree<T>& tree;
  typename Workspace<T>::Arena arena;
  Link<Spatial, T>* link;  ///< the poses of the bodies
  Inertia<T>* M_body;
  Inertia<T>* M;  ///< composite
  Twist<Spatial, T>* J;

  template <TreeOf<T> AnyTree>
  SpatialTree(const AnyTree& t, Workspace<T>& workspace, const T* q) noexcept
      : tree(t),
        arena(workspace),
        link(body_links<Spatial>(t, arena, q)),
        M_body(arena.template per_body<Inertia<T>>()),
        M(arena.template per_body<Inertia<T>>()),
        J(arena.template per_screw<Twist<Spatial, T>>()) {
    joint_columns(t, link, J);
    M_body[0] = M[0] = {};
    for (int i = 1; i <= tree.n; ++i) M_body[i] = M[i] = transform(link[i].C, t.M[i]);
    for (int i = tree.n; i > 0; --i) M[tree.parent[i]] += M[i];
  }

  /// f(c, J_c) for the screws of the joint of body i, with the index c of the velocity.
  template <class F> void each_screw(int i, F&& f) const {
    for (int s = tree.first_screw[i]; s < tree.first_screw[i + 1]; ++s)
      f(tree.iv[i] + s - tree.first_screw[i], J[s]);
  }
};

}  // namespace axode
