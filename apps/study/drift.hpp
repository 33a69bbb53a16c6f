#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// How far joints are from closed, in rad and m, after a motion of the bodies in absolute coordinates. The
/// motion is integrated by the Runge-Kutta method of order 4, without projection on the constraints of the
/// joints.
struct Drift {
  double step;  ///< s
  struct Of {
    double joints_on_ground, all_joints;  ///< largest residuals
  };
  /// Largest residuals of the joint constraints at the end of a motion in absolute coordinates, rad and m,
  /// for three choices of the configuration groups of the bodies: SE(3) for all bodies; SO(3) × R³ for all
  /// bodies; and SE(3) for bodies whose joint on the ground constrains them, SO(3) × R³ for all others.
  Of SE3, SO3xR3, by_joint;
};

/// Computes how far the joints of a mechanism are from closed after a motion of 1 s in absolute coordinates,
/// as the largest residuals of their constraints in rad and m. The motion begins in a random state and has no
/// drive forces. There is a result for each step of 1/64, 1/128, ..., 1/1024 s; it is NaN if the motion has
/// no accelerations because the mass matrix is singular.
std::vector<Drift> drifts(const Model& model);

}  // namespace axode::command
