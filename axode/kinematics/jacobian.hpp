#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

/// Jacobians J of places, which are frames on bodies: V = J v is the twist of a place at the velocities v. A
/// dense Jacobian has nv columns, each the twist for a unit of one velocity, and zero if this does not move
/// the place. A coupled joint moves with the velocity of another joint, its leader, times a constant ratio.
/// The screw of a coupled joint, times the ratio, is added to the column of its leader.
namespace axode {

/// Computes the Jacobian of a place (a frame on a body): nv columns, which are the twists of the place, in
/// the representation Rep, for a unit of each velocity (eqs. JbX, JsX, Jh, JhJb of Müller's paper, see
/// docs/notation.md). O(path length) for the path to the ground, and O(nv) to clear the other columns.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
              const std::type_identity_t<Place<T>>& place, std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// The Jacobians of all n_frames frames, one after the other, with nv columns for each frame. O(n), O(path
/// length) for each frame, and O(nv) for each frame to clear the other columns.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);
/// The Jacobians of several places (frames on bodies), with nv columns for each place, in the order of the
/// places.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<const Place<T>>> places,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// The column J of a Jacobian that belongs to velocity c.
template <RecursionRepresentation Rep, class T = double> struct JacobianColumn {
  int c;
  Twist<Rep, T> J;
};
/// Writes the columns of the Jacobian of a place (a frame on a body) only for joints on the path from the
/// place to the ground, and returns the number of columns. If joints are coupled, several columns may have
/// the same velocity c; the Jacobian's column c is their sum. O(path length). Throws std::invalid_argument if
/// `columns` is too short.
template <RecursionRepresentation Rep = BodyFixed, class T>
std::size_t jacobian_columns(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<JacobianColumn<Rep, T>>> columns);

/// The Jacobian (nv columns) of the motion of one place (a frame on a body) relative to another one, `base`,
/// which replaces the inertial frame in the definition of the representation Rep.
template <RecursionRepresentation Rep = BodyFixed, class T>
void relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place,
                       const std::type_identity_t<Place<T>>& base,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J);

}  // namespace axode
