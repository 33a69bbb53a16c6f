#pragma once
#include "axode/model/tree.hpp"

/// Functions of one joint of any kind, in its frame. They are not inlined, because most joints are hinges.
namespace axode {

/// The pose C_{p,i} of the internal frame of body i relative to that of its predecessor p.
template <class T, class S>
[[gnu::noinline]] SE3<T> any_joint_pose(const Tree<S>& tree, int i, const T* q) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T own = T(tree.ratio[i]) * q[tree->iq[i]] + T(tree.offset[i]);
    return joint.pose(cast<T>(tree.B[i]), tree->coupled[i] ? &own : q + tree->iq[i]);
  });
}
/// The screw S x of joint i, with its screws S in the joint frame and the numbers of x (nv) for its
/// velocities. If x are velocities, this is the twist of the body relative to its predecessor.
template <class T, class S>
[[gnu::noinline]] Twist<BodyFixed, T> any_joint_twist(const Tree<S>& tree, int i, const T* x) noexcept {
  return with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const T* const x_i = x + tree->iv[i];
    const T own = T(tree.ratio[i]) * x_i[0];
    return joint.twist(tree->coupled[i] ? &own : x_i);
  });
}
/// Adds Sᵀ W to the entries of `tau` (nv) for the velocities of joint i, with the joint screws S and the
/// wrench W in the joint frame.
template <class T, class S>
[[gnu::noinline]] void project_on_any_joint(const Tree<S>& tree, int i, const Wrench<BodyFixed, T>& W,
                                            T* tau) noexcept {
  with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
    const auto Q = joint.project(W);
    for (int k = 0; k < joint.nv; ++k) tau[tree->iv[i] + k] += T(tree.ratio[i]) * Q[k];
  });
}

}  // namespace axode
