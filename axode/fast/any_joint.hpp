#pragma once
#include "axode/model/tree.hpp"

/// Joints other than hinges in the fast kernels. Each of them is computed by itself, in its own frame, by
/// functions that are not inlined.
namespace axode {

/// The relative pose C_{p,i} of joint i, which may be of any kind.
template <class T, class S>
[[gnu::noinline]] SE3<T> any_joint_pose(const Tree<S>& tree, int i, const T* q) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T own = T(tree.ratio[i]) * q[tree->iq[i]] + T(tree.offset[i]);
    return joint.pose(cast<T>(tree.B[i]), tree->coupled[i] ? &own : q + tree->iq[i]);
  });
}
/// The motion S x of joint i, for velocities or accelerations x of all joints.
template <class T, class S>
[[gnu::noinline]] Twist<BodyFixed, T> any_joint_twist(const Tree<S>& tree, int i, const T* x) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T* const x_i = x + tree->iv[i];
    const T own = T(tree.ratio[i]) * x_i[0];
    return joint.twist(tree->coupled[i] ? &own : x_i);
  });
}
/// Adds Sᵀ W of joint i to the forces of its velocities.
template <class T, class S>
[[gnu::noinline]] void project_on_any_joint(const Tree<S>& tree, int i, const Wrench<BodyFixed, T>& W,
                                            T* tau) noexcept {
  with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const auto Q = joint.project(W);
    for (int k = 0; k < joint.nv; ++k) tau[tree->iv[i] + k] += T(tree.ratio[i]) * Q[k];
  });
}

}  // namespace axode
