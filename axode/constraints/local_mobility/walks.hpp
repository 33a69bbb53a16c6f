#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/local_mobility/local_mobility.hpp"

namespace axode::higher_order {

/// A joint on the way around a loop. Its displacement is exp(Σ S_k x_k) with its coordinates x_k and screws
/// S_k, about the inertial origin at the configuration q0. If the way leads from the body to its predecessor,
/// the screws have the opposite sign.
struct PassedJoint {
  std::vector<Screw<>> S;
  std::vector<int> coordinates;
};

/// For each loop of a mechanism, the joints in the order in which they are passed on the way around it, with
/// their screws (rad and m, about the inertial origin) at the configuration q0.
struct Walks {
  std::vector<ClosureCoordinate> coordinates;
  std::vector<std::vector<PassedJoint>> loops;
  Eigen::MatrixXd couplings;    ///< one row for each coupling, one column for each coordinate
  std::vector<Vec3<>> centers;  ///< points of all joints whose position matters
  std::vector<int> outside;     ///< indices of velocities of joints that are in no loop
};

/// Finds the joints on the ways around all loops, with their screws at the configuration q0. Throws
/// std::invalid_argument, with the name of the loop, for a rolling contact or a belt.
Walks walks(const Model& model, std::span<const double> q0);

}  // namespace axode::higher_order
