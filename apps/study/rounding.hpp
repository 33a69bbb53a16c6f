#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// The largest rounding errors of forces and accelerations in a few random states, relative to the largest
/// force or acceleration, for each representation of twists. `inertial` is the spatial representation of A.
/// Müller's paper (see docs/notation.md), about the inertial origin; `spatial` is that of the library, about
/// the origin of each root body.
struct RoundingErrors {
  struct Of {
    double body, spatial, inertial, hybrid, mixed;
  };
  double distance;   ///< of the root bodies from the inertial origin, m
  double heaviness;  ///< factor of the inertia of the last body
  double condition;  ///< of the mass matrix
  Of inverse_dynamics, forward_dynamics;
};

/// The rounding errors of inverse and forward dynamics for root bodies that are 0, 1, 10, ..., 1e6 m away
/// from the inertial origin, and then for a last body whose inertia is 1e1 to 1e4 times as large. The errors
/// are differences from the results in long double.
std::vector<RoundingErrors> rounding_errors(const Model& model);

}  // namespace axode::command
