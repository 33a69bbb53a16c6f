#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// Where the derivatives of V and of V', the time derivative of its components, go, a column for each of nv directions. They
/// may not overlap.
template <class Rep, class T> struct MotionDerivatives {
  std::span<Twist<Rep, T>> V_q, V_v;  ///< V_v, which is ∂V'/∂a as well, is the Jacobian
  std::span<Twist<Rep, T>> dV_q, dV_v;
};

/// The partial derivatives of the components of the twist V(q, v) of a place and of their time derivative V'(q, v, a), gravity
/// not included. Directions of q are those of q ⊕ ε e_k. O(n), no allocation. Throws std::invalid_argument for a
/// wrong size, a quaternion off 1, a frame that does not exist and results that overlap.
template <RecursionRepresentation Rep, class T>
void motion_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                        const std::type_identity_t<Place<T>>& place,
                        const std::type_identity_t<MotionDerivatives<Rep, T>>& d);

/// What changes with a place: its pose by a displacement, C exp(ε X^), its twist and the time derivative of that.
template <class Rep, class T> struct MotionChange {
  Twist<BodyFixed, T> X;
  Twist<Rep, T> V, dV;
};
/// How pose, V and V' change along (dq, dv, da), the matrices of motion_derivatives() times a direction. O(n).
template <RecursionRepresentation Rep, class T>
MotionChange<Rep, T> motion_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                Numbers<T> a, const std::type_identity_t<Place<T>>& place, Numbers<T> dq,
                                Numbers<T> dv, Numbers<T> da);

/// Weights of the components of a change.
template <class Rep, class T> struct MotionWeights {
  Wrench<BodyFixed, T> X;
  Wrench<Rep, T> V, dV;
};
/// Where gradients with respect to q, v and a go: nv entries each. They may not overlap.
template <class T> struct MotionGradients { std::span<T> q, v, a; };
/// The gradient of the weighted sum of the components of pose, V and V': the transposed matrices times the weights. O(n).
/// Of poses of several places sum what each of them gives.
template <RecursionRepresentation Rep, class T>
void motion_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                const std::type_identity_t<Place<T>>& place,
                const std::type_identity_t<MotionWeights<Rep, T>>& w,
                const std::type_identity_t<MotionGradients<T>>& gradient);

}  // namespace axode
