#pragma once
#include "axode/model/tree.hpp"

/// Geometric parameters π (Müller, section 6.2), six for each body i. Each displaces the subtree of body i,
/// before its joint moves, along a unit screw U: C_i = C_p B_i exp(U π) exp(X_i q_i). C_i and C_p are the
/// poses of body i and its predecessor p, B_i is the pose of body i relative to p at joint coordinates zero,
/// and X_i are the joint screws. U is resolved in the frame that body i has at joint coordinates zero.
namespace axode {

/// The pose of the frame of body i at joint coordinates zero, relative to its present internal frame.
template <class T> SE3<T> frame_at_zero(const Tree<T>& tree, int i, const T* q) noexcept {
  return with_subgroup(tree->kind[i], tree.pitch[i], [&](const auto& joint) {
    const T own = tree.ratio[i] * q[tree->iq[i]] + tree.offset[i];
    const SE3<T> moved = joint.pose(SE3<T>{}, tree->coupled[i] ? &own : q + tree->iq[i]);
    return inverse(moved) * tree.frame_offset[i];
  });
}
/// Calls f(u, screw) for the six unit screws u = 0 to 5 of a frame, angular before linear, each expressed in
/// another frame, relative to which the frame has the pose E.
template <class T, class F> void each_unit_screw(const SE3<T>& E, const F& f) noexcept {
  for (int u = 0; u < 6; ++u) {
    const auto one = [&](int k) { return T(u == k); };
    f(u, Ad(E, Screw<T>{{one(0), one(1), one(2)}, {one(3), one(4), one(5)}}));
  }
}

}  // namespace axode
