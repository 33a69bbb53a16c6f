#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// The largest rounding errors of the forces and accelerations of a few random states, relative to the
/// largest force or acceleration, in each representation. `inertial` is the paper's own spatial form, about
/// the inertial origin; the library's is about the origins of the root bodies.
struct RoundingErrors {
  struct Of {
    double body, spatial, inertial, hybrid, mixed;
  };
  double distance;   ///< of the root bodies from the inertial origin, m
  double heaviness;  ///< factor of the inertia of the last body
  double condition;  ///< of the mass matrix
  Of inverse_dynamics, forward_dynamics;
};

/// The errors at distances of 0, 1, 10, ..., 1e6 m, and then with the last body heavier by 1e1 to 1e4. They
/// are differences to results with the digits of long double.
std::vector<RoundingErrors> rounding_errors(const Model& model);

}  // namespace axode::command
