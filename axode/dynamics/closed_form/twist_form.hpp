#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The equations of motion for the state (q, V), where V are the twists of all bodies in any of the four
/// representations. From q, V and the drive forces, twist_form() computes the joint velocities v (nv entries)
/// and the rates dV of the twists (n_bodies entries). If V is not compatible with the joints, the relative
/// twists of neighbouring bodies are projected onto the joint screws (least squares). If the mass matrix is
/// singular, the returned Solvability says so, and dV is NaN. O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability twist_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       std::type_identity_t<std::span<const Twist<Rep, T>>> V, Numbers<T> tau,
                       std::type_identity_t<std::span<T>> v,
                       std::type_identity_t<std::span<TwistRate<Rep, T>>> dV,
                       const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
