#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "axode/model/model.hpp"

/// The ten inertial parameters of each moving body, in which the equations of motion are linear:
///
///   π = (m, m c_x, m c_y, m c_z, Θ_xx, Θ_yy, Θ_zz, Θ_xy, Θ_xz, Θ_yz).
///
/// In the body frame c is the centre of mass, and Θ the rotational inertia about the origin. Bodies that are
/// fixed to the body are included.
namespace axode {

std::array<double, 10> inertial_parameters(const Inertia<double>& M);
Inertia<double> inertia_of(std::span<const double, 10> parameters);
/// The parameters of the moving bodies 1, 2, ..., one after the other: 10 n_bodies numbers.
std::vector<double> inertial_parameters(const Model& model);
/// The names of the 10 n_bodies parameters: `<body> m`, `<body> m cx`, ..., `<body> Iyz`.
std::vector<std::string> parameter_names(const Model& model);

}  // namespace axode
