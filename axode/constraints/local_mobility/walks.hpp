#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/local_mobility/local_mobility.hpp"

namespace axode::higher_order {

/// A joint that a walk around a loop passes: exp(Σ S_k x_k). Its screws are about the inertial origin at q0,
/// and negative if the joint is passed backwards.
struct PassedJoint {
  std::vector<Screw<>> S;
  std::vector<int> coordinates;
};

/// The walks around the loops of a mechanism at q0, in rad and m about the inertial origin.
struct Walks {
  std::vector<ClosureCoordinate> coordinates;
  std::vector<std::vector<PassedJoint>> loops;
  Eigen::MatrixXd couplings;    ///< a row for each coupling, n columns
  std::vector<Vec3<>> centers;  ///< points of the joints that have a position
  std::vector<int> outside;     ///< velocities of joints that are in no loop
};

/// Throws std::invalid_argument with the name of a rolling contact, whose closure cannot be integrated.
Walks walks(const Model& model, std::span<const double> q0);

}  // namespace axode::higher_order
