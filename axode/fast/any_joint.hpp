#pragma once
#include "axode/model/tree.hpp"

/// Joints that are no hinges, in the fast kernels: one at a time, in its own frame, out of line.
namespace axode {

/// C_{p,i} of a joint of any kind.
template <class T, class S>
[[gnu::noinline]] SE3<T> any_joint_pose(const Tree<S>& tree, int i, const T* q) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T own = T(tree.ratio[i]) * q[tree->iq[i]] + T(tree.offset[i]);
    return joint.pose(cast<T>(tree.B[i]), tree->coupled[i] ? &own : q + tree->iq[i]);
  });
}
/// S x, for velocities or accelerations x.
template <class T, class S>
[[gnu::noinline]] Twist<BodyFixed, T> any_joint_twist(const Tree<S>& tree, int i, const T* x) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T* const x_i = x + tree->iv[i];
    const T own = T(tree.ratio[i]) * x_i[0];
    return joint.twist(tree->coupled[i] ? &own : x_i);
  });
}
/// Adds Sᵀ W to the forces of its velocities.
template <class T, class S>
[[gnu::noinline]] void project_on_any_joint(const Tree<S>& tree, int i, const Wrench<BodyFixed, T>& W,
                                            T* tau) noexcept {
  with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const auto Q = joint.project(W);
    for (int k = 0; k < joint.nv; ++k) tau[tree->iv[i] + k] += T(tree.ratio[i]) * Q[k];
  });
}

}  // namespace axode
