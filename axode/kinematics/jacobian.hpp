#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

/// Jacobians: V = J v. A column belongs to a velocity and is the twist for a unit of this velocity. Dense
/// results have nv columns; columns of joints that do not move the place are zero. The screw of a coupled
/// joint is added to the column of its leader.
namespace axode {

/// The Jacobian J_f of a place (eqs. JbX, JsX, Jh, JhJb). O(path length), and O(nv) to clear the other
/// columns.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
              const std::type_identity_t<Place<T>>& place, std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// The Jacobians of all frames, one after the other: nv columns for each of n_frames. Poses and joint screws
/// are computed once, so that it takes a few times as long as `poses`. O(n) and O(path length) for each
/// frame, and O(nv) to clear the other columns.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);
/// The Jacobians of several places, nv columns for each place, in the order of the places.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<const Place<T>>> places,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// The column of a Jacobian that belongs to velocity c.
template <RecursionRepresentation Rep, class T = double> struct JacobianColumn {
  int c;
  Twist<Rep, T> J;
};
/// Writes only those columns of the Jacobian of a place that belong to joints on the path from the place to
/// the ground, and returns their number. If joints are coupled, several columns may have the same velocity c;
/// they add up. O(path length). Throws std::invalid_argument if `columns` is too short.
template <RecursionRepresentation Rep = BodyFixed, class T>
std::size_t jacobian_columns(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<JacobianColumn<Rep, T>>> columns);

/// The Jacobian of the motion of one place relative to another one, `base`, for an observer at rest in
/// `base`, which takes the role of the inertial frame for Rep.
template <RecursionRepresentation Rep = BodyFixed, class T>
void relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place,
                       const std::type_identity_t<Place<T>>& base,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J);

}  // namespace axode
