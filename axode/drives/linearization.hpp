#pragma once
#include <Eigen/Core>
#include <span>

#include "axode/drives/drive_system.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The linear system z' = A z + B δu of small deviations z = (δ, δv, δx) from the motion of a mechanism with
/// drives through a state, where δx are those of the states of the drives, and δu those of the inputs that
/// are functions of time. A is square, with 2 nv + nx rows; B has a column for each of DriveSystem::inputs().
struct DriveLinearization {
  Eigen::MatrixXd A, B;
  Solvability solvability;
};

/// Computes the linear system at a state (q, v, x) and a time by (D17.4). The drives have the statuses that
/// belong to the state. Units, springs and loads are as in linearize(). Allocates; O(nv³ + nx²). Throws
/// std::invalid_argument for wrong sizes, and for mechanisms with loops or prescribed motions.
DriveLinearization linearize_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> v,
                                         std::span<const double> x, const Loads<double>& loads = {});

/// A state of rest of a mechanism with drives: a configuration q and states x in which nothing accelerates
/// and x' = 0.
struct DriveEquilibrium {
  std::vector<double> q, x;
  bool found = false;
  double residual = 0;  ///< the largest remaining acceleration, or rate of a state over its nominal value, SI
  Solvability solvability;
};

/// Finds a state of rest near (q, x) at the inputs of a time by Newton's method with exact derivatives; where
/// these are singular, as for trapped oil or an integrator, the nearest such state. Statuses are those of the
/// last iterate. Springs are counted. Allocates. Throws as linearize_with_drives().
DriveEquilibrium equilibrium_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> x);

}  // namespace axode
