#pragma once
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/model.hpp"

/// The paper's own description of a mechanism, screw by screw, in the frames that the user placed. The
/// kernels use the joint-aligned frames of Tree instead; both give the same poses.
namespace axode {

/// The displacement exp(X q) of a joint with one screw X, or the ordered motion of its joint frame carried to
/// the body frame, S_self C_J(q) S_self⁻¹, for joints with more; q holds the joint's own coordinates.
template <class T> SE3<T> joint_displacement(const Model& model, int i, const T* q) {
  const Joint& joint = model.joint(i);
  if (joint.leader || joint.nv == 1) {
    const Screw<>& X = model.body(i).X[0];
    const T own = joint.leader ? T(joint.leader->ratio) * *q + T(joint.leader->offset) : *q;
    return exp(
        Screw<T>{own * Vec3<T>{T(X.w.x), T(X.w.y), T(X.w.z)}, own * Vec3<T>{T(X.v.x), T(X.v.y), T(X.v.z)}});
  }
  const SE3<T> S = cast<T>(model.body(i).S_self);
  return with_subgroup(joint.kind, T(joint.pitch),
                       [&](const auto& subgroup) { return subgroup.pose(S, q) * inverse(S); });
}

/// C_i = B_1 exp(X_1 q_1) B_2 exp(X_2 q_2) ... along the path to body i, for the ground and every body (eq.
/// POEX).
template <class T> std::vector<SE3<T>> poses_by_body_screws(const Model& model, const T* q) {
  std::vector<SE3<T>> C(model.n_bodies() + 1);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    C[i] = C[body.predecessor] * cast<T>(body.B) * joint_displacement(model, i, q + model.joint(i).iq);
  }
  return C;
}

/// C_i = exp(Y_1 q_1) exp(Y_2 q_2) ... A_i along the path to body i, for the ground and every body (eq.
/// POEY).
template <class T> std::vector<SE3<T>> poses_by_spatial_screws(const Model& model, const T* q) {
  std::vector<SE3<T>> exponentials(model.n_bodies() + 1), C(model.n_bodies() + 1);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const SE3<T> A = cast<T>(model.body(i).A);
    const SE3<T> exp_Y = A * joint_displacement(model, i, q + model.joint(i).iq) * inverse(A);
    exponentials[i] = exponentials[model.body(i).predecessor] * exp_Y;
    C[i] = exponentials[i] * A;
  }
  return C;
}

}  // namespace axode
