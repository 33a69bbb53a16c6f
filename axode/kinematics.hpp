#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/higher_order.hpp"
#include "axode/kinematics/inverse_kinematics.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/kinematics/jacobian_partials.hpp"

/// Where every body is and how it moves. T is the scalar of the workspace, double or float; Rep is BodyFixed,
/// Spatial, Hybrid or Mixed. q has nq, v and a have nv entries; results have n_frames entries: the ground,
/// the bodies in the model's order, the other frames, each in the frame that the user placed. Everything is
/// O(n), allocates nothing, and throws std::invalid_argument for a wrong size or a quaternion off 1.
namespace axode {

/// C_i, the pose of every frame in the inertial frame (eqs. POEX, aVbRec2), m.
template <class T>
void poses(const Model& model, Workspace<T>& workspace, Numbers<T> q,
           std::type_identity_t<std::span<SE3<T>>> C);

/// V_i, the twist of every frame (eqs. VbRec, Vsrec, VhRec), rad/s and m/s.
template <class Rep = BodyFixed, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V);

/// V'_i, the time derivative of the components of every twist (eqs. cVbRec2, dVsRec, dVhRec2), rad/s² and
/// m/s². Hybrid and mixed rates hold the acceleration r'' of the frame's origin; body-fixed and spatial ones
/// do not. Gravity is not part of it.
template <class Rep = BodyFixed, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV);

/// The centre of mass of all moving bodies in the inertial frame, m. Throws std::domain_error for a massless
/// model.
template <class T> Vec3<T> center_of_mass(const Model& model, Workspace<T>& workspace, Numbers<T> q);

}  // namespace axode
