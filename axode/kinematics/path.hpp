#pragma once
#include "axode/kinematics/place.hpp"
#include "axode/model/tree.hpp"

namespace axode {

/// The pose of body i's joint frame in its predecessor's internal frame, B exp(S q).
template <class T> SE3<T> joint_pose(const Tree<T>& tree, int i, const T* q) noexcept {
  return with_joint(tree, i, [&](const auto& joint) {
    const T* q_i = q + tree.iq[i];
    const T own = tree.ratio[i] * *q_i + tree.offset[i];
    return joint.pose(tree.B[i], tree.coupled[i] ? &own : q_i);
  });
}

/// f(c, screw) for every joint screw of body i, seen from where its joint frame has pose C. A coupled joint's
/// screw is scaled by its ratio, so that it belongs to a unit velocity of its leader. c is the index of the
/// velocity.
template <class T, class F> void each_screw(const Tree<T>& tree, int i, const SE3<T>& C, F&& f) noexcept {
  with_joint(tree, i, [&](const auto& joint) {
    for (int k = 0; k < joint.nv; ++k) f(tree.iv[i] + k, tree.ratio[i] * joint.column(C, k));
  });
}

/// Walks from a place to the root, or to body `until`: f(i, c, X) with the body-fixed Jacobian's column X =
/// J_{f,c}^b of joint i for velocity c (eq. JbX). Returns the pose of the place in the inertial frame, or in
/// the internal frame of that body. O(path length).
template <class T, class F>
SE3<T> each_body_fixed_column(const Tree<T>& tree, const T* q, const Place<T>& place, F&& f,
                              int until = 0) noexcept {
  SE3<T> E = tree.frame_offset[place.frame] * place.offset;  // the place in the joint frame of body i
  for (int i = tree.frame_body[place.frame]; i != until; i = tree.parent[i]) {
    each_screw(tree, i, inverse(E), [&](int c, const Screw<T>& X) { f(i, c, X); });
    E = joint_pose(tree, i, q) * E;
  }
  return E;
}

/// The last body on the paths to both of two bodies; the ground where there is no other.
template <class T> int common_predecessor(const Tree<T>& tree, int i, int j) noexcept {
  while (i != j) {
    int& later = i > j ? i : j;
    later = tree.parent[later];
  }
  return i;
}

}  // namespace axode
