#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

/// Jacobians: V = J v. A column belongs to a velocity and is a twist for a unit of it. Dense results have nv
/// columns; columns of joints that do not move the place are zero. A coupled joint adds its share to its
/// leader's column.
namespace axode {

/// J_f of a place (eqs. JbX, JsX, Jh, JhJb), measured there; O(path length) and nv to clear the rest.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
              const std::type_identity_t<Place<T>>& place, std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// Those of all frames, one after the other: nv columns for each of n_frames. Poses and joint screws are found once, so
/// that it takes a few times as long as `poses`; O(n) and O(path length) for each frame, and nv to clear the rest.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);
/// Those of some places only, in their order.
template <RecursionRepresentation Rep = BodyFixed, class T>
void jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
               std::type_identity_t<std::span<const Place<T>>> places,
               std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// One column of a Jacobian, for velocity c.
template <RecursionRepresentation Rep, class T = double> struct JacobianColumn {
  int c;
  Twist<Rep, T> J;
};
/// The columns along the path from the place to the ground only; returns how many. Columns with the same c
/// (coupled joints) add up. O(path length). Throws std::invalid_argument where `columns` is too short.
template <RecursionRepresentation Rep = BodyFixed, class T>
std::size_t jacobian_columns(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<JacobianColumn<Rep, T>>> columns);

/// The Jacobian of the motion of one place relative to another, as an observer at rest in `base` sees it: Rep
/// is with respect to the base in the role of the inertial frame.
template <RecursionRepresentation Rep = BodyFixed, class T>
void relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place,
                       const std::type_identity_t<Place<T>>& base,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J);

}  // namespace axode
