#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

/// Jacobians: V = J v. A column belongs to a velocity and is a twist for a unit of it. Dense results have nv
/// columns; columns of joints that do not move the place are zero. A coupled joint adds its share to its
/// leader's column.
namespace axode {

/// J_f of a place (eqs. JbX, JsX, Jh, JhJb), measured there; O(path length) and nv to clear the rest.
template <class Rep = BodyFixed, class T>
void jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
              const std::type_identity_t<Place<T>>& place, std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// One column of a Jacobian, for velocity c.
template <class Rep, class T = double> struct JacobianColumn {
  int c;
  Twist<Rep, T> J;
};
/// The columns along the path from the place to the ground only; returns how many. Columns with the same c
/// (coupled joints) add up. O(path length). Throws std::invalid_argument where `columns` is too short.
template <class Rep = BodyFixed, class T>
std::size_t jacobian_columns(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<JacobianColumn<Rep, T>>> columns);

/// The Jacobian of the motion of one place relative to another, as an observer at rest in `base` sees it: Rep
/// is with respect to the base in the role of the inertial frame.
template <class Rep = BodyFixed, class T>
void relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                       const std::type_identity_t<Place<T>>& place,
                       const std::type_identity_t<Place<T>>& base,
                       std::type_identity_t<std::span<Twist<Rep, T>>> J);

/// The instantaneous joint screws J_i^s of all joints (eqs. JsX, bVsRec), in spatial representation, where
/// they serve every body at once: Model::first_screw(i) is the first of joint i, n_screws in all. O(n).
template <class T>
void joint_screws(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                  std::type_identity_t<std::span<Twist<Spatial, T>>> J);

/// The Jacobian of the centre of mass, nv columns in the inertial frame, m per unit velocity; O(n). Throws
/// std::domain_error for a massless model.
template <class T>
void center_of_mass_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             std::type_identity_t<std::span<Vec3<T>>> J);

/// The centroidal momentum matrix: nv columns, the momentum about the centre of mass in inertial axes for a
/// unit of each velocity; O(n). Throws std::domain_error for a massless model.
template <class T>
void centroidal_momentum_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<Momentum<Hybrid, T>>> A);

/// The time derivative of the centroidal momentum matrix at velocity v; O(n).
template <class T>
void centroidal_momentum_matrix_rate(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     std::type_identity_t<std::span<Wrench<Hybrid, T>>> dA);

}  // namespace axode
