#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::command {

/// How far joints in absolute coordinates are from closed, in rad and m, after a motion by rk4 in which nothing
/// projects the bodies back.
struct Drift {
  double step;  ///< s
  struct Of {
    double joints_on_ground, all_joints;  ///< largest residuals
  };
  /// By the groups on which the bodies step: SE(3), SO(3) × R³, and SE(3) only for a body whose joint on the
  /// ground constrains it.
  Of SE3, SO3xR3, by_joint;
};

/// The drift of a random state in motion without drive forces after a second, for steps of 1/64, 1/128, ..., 1/1024
/// s. NaN where accelerations do not exist.
std::vector<Drift> drifts(const Model& model);

}  // namespace axode::command
