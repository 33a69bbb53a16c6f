#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The state as (q, V), n + 6n unknowns: the rates of q and V that belong to the twists V of all bodies (in
/// their own frames) and the drive forces. v and dV are the results, nv and n_bodies entries. If V does not
/// belong to joint velocities, its part that the joints allow is used. O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
Solvability twist_form(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       std::type_identity_t<std::span<const Twist<Rep, T>>> V, Numbers<T> tau,
                       std::type_identity_t<std::span<T>> v,
                       std::type_identity_t<std::span<TwistRate<Rep, T>>> dV,
                       const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
