#pragma once
#include "axode/kinematics/place.hpp"
#include "axode/model/tree.hpp"
#include "axode/scalar/sine_cosine.hpp"

namespace axode {

/// The pose of the joint frame of body i in the joint frame of its predecessor: B exp(S q_i), with the pose B
/// at q = 0, the joint screw S and the coordinates q_i of joint i. The joint frame of a body is fixed to it
/// at the joint to its predecessor. A coupled joint has the coordinate ratio q + offset with the coordinate q
/// of its leader.
template <class T> SE3<T> joint_pose(const Tree<T>& tree, int i, const T* q) noexcept {
  return with_joint(tree, i, [&](const auto& joint) {
    const T* q_i = q + tree->iq[i];
    const T own = tree.ratio[i] * *q_i + tree.offset[i];
    return joint.pose(tree.B[i], tree->coupled[i] ? &own : q_i);
  });
}

/// Calls f(c, screw) for every joint screw of body i, with the index c of its velocity. The screws are in the
/// frame relative to which the joint frame has the pose C. The screw of a coupled joint is multiplied by its
/// ratio to its leader.
template <class T, class F> void each_screw(const Tree<T>& tree, int i, const SE3<T>& C, F&& f) noexcept {
  with_joint(tree, i, [&](const auto& joint) {
    for (int k = 0; k < joint.nv; ++k) f(tree->iv[i] + k, tree.ratio[i] * joint.column(C, k));
  });
}

/// Walks from a place (a frame on a body) to the ground, or to body `until` on this path. For each joint i on
/// the way, the joint of `until` excluded, calls f(i, c, X) with the column X of joint i in the body-fixed
/// Jacobian of the place for velocity c (Müller, eq. JbX). Returns the pose of the place in the inertial
/// frame or, if `until` is not 0, in the joint frame of body `until`, which is fixed to this body at the
/// joint to its predecessor. O(path length).
template <class T, class F>
SE3<T> each_body_fixed_column(const Tree<T>& tree, const T* q, const Place<T>& place, F&& f,
                              int until = 0) noexcept {
  constexpr int most = 16;  // joints whose sines and cosines are computed at once
  SE3<T> E = tree.frame_offset[place.frame] * place.offset;  // the place in the joint frame of body i
  for (int i = tree->frame_body[place.frame]; i != until;) {
    int body[most], n = 0;
    T angle[most]{}, sine[most], cosine[most];
    for (; i != until && n < most; i = tree->parent[i], ++n) {
      body[n] = i;
      angle[n] = tree.ratio[i] * q[tree->iq[i]] + tree.offset[i];
    }
    sine_cosine(angle, sine, cosine, n);
    for (int k = 0; k < n; ++k) {
      const int j = body[k];
      if (tree->kind[j] == Subgroup::revolute) [[likely]] {
        const T &ratio = tree.ratio[j], x = E.r.x, y = E.r.y;
        const SO3<T>& R = E.R;
        const Screw<T> X{{R.x.z, R.y.z, R.z.z},
                         {R.x.y * x - R.x.x * y, R.y.y * x - R.y.x * y, R.z.y * x - R.z.x * y}};
        f(j, tree->iv[j], ratio * X);
        E = SE3<T>{subgroup::turn(tree.B[j].R, sine[k], cosine[k]), tree.B[j].r} * E;
      } else {
        each_screw(tree, j, inverse(E), [&](int c, const Screw<T>& X) { f(j, c, X); });
        E = joint_pose(tree, j, q) * E;
      }
    }
  }
  return E;
}

/// The last common body of the paths from the ground to bodies i and j, or the ground (0) if there is none.
template <class T> int common_predecessor(const Tree<T>& tree, int i, int j) noexcept {
  while (i != j) {
    int& later = i > j ? i : j;
    later = tree->parent[later];
  }
  return i;
}

}  // namespace axode
