#pragma once
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// A target pose of a place, which is a frame on a body. With the pose C of the place, the error is the screw
/// log(C⁻¹ C_target), whose angular part (rad) and linear part (m) are scaled by the weights. A weight of 0
/// leaves a part free; if the orientation is free, the error is the distance of the origins.
struct PoseTarget {
  Place<> place;
  SE3<> pose;
  double angular_weight = 1, linear_weight = 1;
};

struct InverseKinematicsOptions {
  double tolerance = 1e-9;  ///< tolerance of the norm of the weighted error
  int iterations = 60;      ///< largest number of iterations from each start
  int restarts = 40;        ///< largest number of restarts from random configurations within the limits
  std::uint64_t seed = 1;   ///< seed of the restarts
  bool limits = true;       ///< whether joints are kept within their position limits
  /// Configuration that the joints approach in the null space of the targets; empty if there is none.
  std::span<const double> posture = {};
  std::function<bool()> monitor = {};  ///< called before each start; if it returns false, the search ends
};

enum class InverseKinematicsStatus {
  solved,  ///< the error is within the tolerance
  /// Every start ended in a configuration that no small step improves. The targets are probably out of reach.
  stalled,
  /// The search ended before a solution was found: the error still decreased when the iterations from some
  /// start were used up, or options.monitor, the caller's function, ended the search.
  iteration_limit,
};
std::string_view to_string(InverseKinematicsStatus status);

struct InverseKinematicsResult {
  InverseKinematicsStatus status{};
  std::vector<double> q;  ///< best configuration that was found
  double residual = 0;    ///< norm of the weighted error at q
  int iterations = 0;     ///< number of iterations of all starts together
  int restarts = 0;
};

/// Computes a configuration in which places (frames on bodies) have given poses, by the damped least squares
/// of Levenberg and Marquardt. The error of a place with the pose C is log(C⁻¹ C_target), with the weights of
/// the target; its derivative by q is -dexp⁻¹ J^b with the body-fixed Jacobian J^b of the place. The search
/// starts at q0, and then at most options.restarts times at random configurations until the targets are
/// reached. A joint at a limit that it would cross is held there. If options.posture is given, the joints
/// then move towards this configuration as far as the targets allow. Allocates. Throws std::invalid_argument
/// for wrong sizes, unknown frames, and numbers out of range.
[[nodiscard]] InverseKinematicsResult inverse_kinematics(const Model& model,
                                                         std::span<const PoseTarget> targets,
                                                         std::span<const double> q0,
                                                         const InverseKinematicsOptions& options = {});

}  // namespace axode
