#pragma once
#include <Eigen/Core>
#include <span>

#include "axode/drives/drive_system.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The linear system z' = A z + B δu for small deviations z = (δ, δv, δx) from the motion of a mechanism with
/// drives through a state (q, v, x). δ is the left-trivialised displacement of q and δv the change of v (nv
/// numbers each), δx is the change of the states of the drives (nx numbers), and δu is the change of those
/// inputs of drives that are functions of time. A is square with 2 nv + nx rows; B has as many rows and a
/// column for each of DriveSystem::inputs().
struct DriveLinearization {
  Eigen::MatrixXd A, B;
  Solvability solvability;
};

/// Computes the linear system z' = A z + B δu of DriveLinearization at a time t (s) and state (q, v, x) by
/// (D17.4). The statuses of the drives, which select branches of their laws, are chosen for this state and
/// constant in the derivatives. Springs, dampers and stops of the model and the loads act; units are SI.
/// Allocates; O(nv³ + nv² nx + nx²). If the status is not ok(), A and B contain NaN. Throws
/// std::invalid_argument for wrong sizes, for q, v or x that are not finite, and for mechanisms with loops or
/// prescribed motions.
DriveLinearization linearize_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> v,
                                         std::span<const double> x, const Loads<double>& loads = {});

/// A state of rest of a mechanism with drives: a configuration q and drive states x in which, with v = 0, all
/// accelerations are 0 and x' = 0.
struct DriveEquilibrium {
  std::vector<double> q, x;
  bool found = false;
  double residual = 0;  ///< largest acceleration, or x' over the nominal value of x, SI
  Solvability solvability;
};

/// Finds a state of rest near (q, x) for the inputs that the drives have at time t, by Newton's method with
/// exact derivatives and decreasing residuals. If the equations are singular, as with oil that is trapped in
/// a cylinder or with an integrator, each step is the one of least norm, so that the result is near the
/// start. The statuses of the drives are chosen again for each iterate. Springs of the model act. If the
/// residual stays above 1e-9, `found` is false and the best iterate is returned. Allocates. Throws
/// std::invalid_argument for wrong sizes, for q or x that are not finite, and for mechanisms with loops or
/// prescribed motions.
DriveEquilibrium equilibrium_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> x);

}  // namespace axode
