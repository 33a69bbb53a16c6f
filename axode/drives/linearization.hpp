#pragma once
#include <Eigen/Core>
#include <span>

#include "axode/drives/drive_system.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The linear system z' = A z + B δu for small deviations z = (δ, δv, δx) from a motion of a mechanism with
/// drives, at a state (q, v, x). δ is the left-trivialised displacement of q (nv numbers), δv the change of v
/// (nv), and δx the change of the drive states x (nx). δu are the changes of the inputs that are functions of
/// time. A is square with 2 nv + nx rows; B has a column for each of these inputs.
struct DriveLinearization {
  Eigen::MatrixXd A, B;
  Solvability solvability;
};

/// Linearises the equations of motion of a mechanism with drives at a time t (s) and a state (q, v, x), with
/// the states x of the drives (D17.4). The branch of each drive's law, such as whether a limit is reached, is
/// chosen at this state and held constant. Springs, dampers and stops of the model and the loads act; units
/// are SI. If `solvability` of the result is not ok(), for example because the mass matrix is singular, the
/// matrices contain NaN. Allocates; O(nv³ + nv² nx + nx²) for nx states of drives. Throws
/// std::invalid_argument for wrong sizes, numbers that are not finite, and mechanisms with loops or
/// prescribed motions.
DriveLinearization linearize_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> v,
                                         std::span<const double> x, const Loads<double>& loads = {});

/// A state of rest: q and states x of the drives for which, with v = 0, accelerations and the rates x' are 0.
struct DriveEquilibrium {
  std::vector<double> q, x;
  bool found = false;
  double residual = 0;  ///< largest acceleration, or x' over the nominal value of x, SI
  Solvability solvability;
};

/// Finds a state of rest of a mechanism with drives, near the configuration q and the drive states x, for the
/// inputs at time t, by Newton's method with exact derivatives. If the linearised equations are singular, as
/// with oil trapped in a cylinder or with an integrator, each step is the one of least norm. The branch of
/// each drive's law, such as whether a limit is reached, is chosen anew for each iterate. Springs of the
/// model act. If the residual (see DriveEquilibrium) stays above 1e-9, `found` is false and the best iterate
/// is returned. Allocates. Throws std::invalid_argument for wrong sizes, numbers that are not finite, and
/// mechanisms with loops or prescribed motions.
DriveEquilibrium equilibrium_with_drives(const Model& model, DriveSystem& drives, double t,
                                         std::span<const double> q, std::span<const double> x);

}  // namespace axode
