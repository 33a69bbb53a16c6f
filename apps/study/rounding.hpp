#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// The largest rounding errors of forces and accelerations in a few random states, relative to the largest
/// force or acceleration, for each representation of twists. `inertial` is the spatial representation of A.
/// Müller's paper (see docs/notation.md), about the inertial origin; `spatial` is that of the library, about
/// the origin of each root body (a body joined to the ground).
struct RoundingErrors {
  struct Of {
    double body, spatial, inertial, hybrid, mixed;
  };
  double distance;   ///< displacement of the root bodies, m
  double heaviness;  ///< factor of the inertia of the last body
  double condition;  ///< largest condition number of the mass matrix in the states
  Of inverse_dynamics, forward_dynamics;
};

/// Computes the rounding errors of inverse and forward dynamics for variants of a mechanism. In the first
/// variants the root bodies (bodies joined to the ground) are displaced by 0, 1, 10, ..., 1e6 m from their
/// poses in the mechanism. In the others the inertia of the last body is multiplied by 10, 100, 1e3 and 1e4.
/// The errors are differences from the results in long double.
std::vector<RoundingErrors> rounding_errors(const Model& model);

}  // namespace axode::command
