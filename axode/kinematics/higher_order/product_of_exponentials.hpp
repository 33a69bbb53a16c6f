#pragma once
#include <vector>

#include "axode/lie/se3.hpp"
#include "axode/model/model.hpp"

/// Poses by products of exponentials of joint screws, for the body frames that the user placed.
namespace axode {

/// The displacement of the body frame by joint i: exp(X q) for one joint screw X, otherwise S_self C_J(q)
/// S_self⁻¹ with the pose S_self of the joint frame on the body and the joint's motion C_J(q). q has only the
/// coordinates of this joint. If the joint is coupled, q has the coordinate of its leader instead, and the
/// displacement is exp(X (ratio q + offset)) with the ratio and the offset of the coupling.
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

/// The poses C_i = B_1 exp(X_1 q_1) B_2 exp(X_2 q_2) ... of the ground and every body, as products along the
/// path to body i (Müller, eq. POEX), with the pose B_i relative to the predecessor at q = 0 and the joint
/// screw X_i in the body frame.
template <class T> std::vector<SE3<T>> poses_by_body_screws(const Model& model, const T* q) {
  std::vector<SE3<T>> C(model.n_bodies() + 1);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    C[i] = C[body.predecessor] * cast<T>(body.B) * joint_displacement(model, i, q + model.joint(i).iq);
  }
  return C;
}

/// The poses C_i = exp(Y_1 q_1) exp(Y_2 q_2) ... A_i of the ground and every body, as products along the path
/// to body i (Müller, eq. POEY), with the pose A_i of body i and the joint screws Y_i in the inertial frame
/// at q = 0.
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
