#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The twist V_i of every frame (eqs. VbRec, Vsrec, VhRec), rad/s and m/s. V has n_frames entries. O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V);

/// The time derivative V'_i of the components of the twist of every frame (eqs. cVbRec2, dVsRec, dVhRec2),
/// rad/s² and m/s², n_frames entries, without gravity. The linear part of hybrid and mixed rates is the
/// acceleration r'' of the frame's origin; that of body-fixed and spatial rates is not. O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV);

}  // namespace axode
