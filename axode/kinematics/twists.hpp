#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The twist V_i of every frame (Müller, eqs. VbRec, Vsrec, VhRec), rad/s and m/s. V has n_frames entries.
/// O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V);

/// Computes the time derivative V'_i of the components of the twist of every frame (Müller, eqs. cVbRec2,
/// dVsRec, dVhRec2): n_frames entries in rad/s² and m/s², without gravity. In hybrid and mixed representation
/// its linear part is the acceleration r'' of the frame's origin; in body-fixed and spatial representation it
/// is not. O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV);

}  // namespace axode
