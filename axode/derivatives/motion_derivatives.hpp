#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// Receives the derivatives by q and v of the twist V of a place, which is a frame on a body, and of the time
/// derivative V' of the components of V. Components are those of the representation Rep. Each of the four
/// spans has nv twists, one for each direction of q or v. The spans must not overlap.
template <class Rep, class T> struct MotionDerivatives {
  std::span<Twist<Rep, T>> V_q, V_v;  ///< ∂V/∂q and ∂V/∂v; ∂V/∂v is the Jacobian and equal to ∂V'/∂a
  std::span<Twist<Rep, T>> dV_q, dV_v;  ///< ∂V'/∂q and ∂V'/∂v
};

/// Computes the partial derivatives by q and v of the twist V(q, v) of a place and of the time derivative
/// V'(q, v, a) of its components, without gravity. A place is a frame on a body. The representation Rep
/// (body-fixed, spatial, hybrid or mixed) determines the axes and the reference point of the components.
/// Direction k of q is q ⊕ ε e_k. O(n), no allocation. Throws std::invalid_argument for a wrong size,
/// quaternions that are not of unit norm, a frame that does not exist and results that overlap.
template <RecursionRepresentation Rep, class T>
void motion_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                        const std::type_identity_t<Place<T>>& place,
                        const std::type_identity_t<MotionDerivatives<Rep, T>>& d);

/// The change of the motion of a place, a frame on a body, along one direction: the displacement X of its
/// pose C, which becomes C exp(ε X^), in body-fixed components, and the changes of the components of its
/// twist V and of their time derivative V', both in the representation Rep.
template <class Rep, class T> struct MotionChange {
  Twist<BodyFixed, T> X;
  Twist<Rep, T> V, dV;
};
/// Computes the changes of the pose, of the twist V and of V' of a place, a frame on a body, along one
/// direction (dq, dv, da). O(n).
template <RecursionRepresentation Rep, class T>
MotionChange<Rep, T> motion_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                Numbers<T> a, const std::type_identity_t<Place<T>>& place, Numbers<T> dq,
                                Numbers<T> dv, Numbers<T> da);

/// Coefficients w of the linear function w.X · X + w.V · V + w.dV · V' of the motion of a place, a frame on a
/// body, whose gradient motion_vjp() computes. X is an infinitesimal displacement of the pose C of the place,
/// which becomes C exp(ε X^), in body-fixed components. V and V' are the components of the twist of the place
/// and their time derivative, both in the representation Rep.
template <class Rep, class T> struct MotionWeights {
  Wrench<BodyFixed, T> X;
  Wrench<Rep, T> V, dV;
};
/// Receives the gradients by q, v and a (nv entries each) of a function of the motion of a place, which is a
/// frame on a body. The function is a weighted sum of the components of the twist of the place, of their time
/// derivative, and of an infinitesimal displacement of the place from its present pose, in body-fixed
/// components. The three spans must not overlap.
template <class T> struct MotionGradients { std::span<T> q, v, a; };
/// Computes the gradient, with respect to q, v and a, of the sum w.X · X + w.V · V + w.dV · V' for a place,
/// which is a frame on a body. X is the infinitesimal displacement of its pose C, which becomes C exp(ε X^),
/// in body-fixed components; V is the twist of the place. The part of X in the gradient by q is Jᵀ w.X with
/// the body-fixed Jacobian J of the place. O(n). For several places, add the results.
template <RecursionRepresentation Rep, class T>
void motion_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                const std::type_identity_t<Place<T>>& place,
                const std::type_identity_t<MotionWeights<Rep, T>>& w,
                const std::type_identity_t<MotionGradients<T>>& gradient);

}  // namespace axode
