#pragma once
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "axode/kinematics/arguments.hpp"
#include "axode/kinematics/place.hpp"

namespace axode {

/// A pose that a place shall take. The error is the screw log(C⁻¹ C_target), its angular part (rad) and
/// linear part (m) scaled by the weights. A weight of 0 leaves a part free; where it is the orientation, the
/// error is the distance of the origins.
struct PoseTarget {
  Place<> place;
  SE3<> pose;
  double angular_weight = 1, linear_weight = 1;
};

struct InverseKinematicsOptions {
  double tolerance = 1e-9;  ///< on the norm of the weighted error
  int iterations = 60;      ///< at most, from each start
  int restarts = 40;        ///< from random configurations within the limits, after the first start
  std::uint64_t seed = 1;   ///< of the restarts
  bool limits = true;       ///< keep joints within their position limits
  std::span<const double> posture = {};  ///< a configuration to stay near in the null space of the targets
  std::function<bool()> monitor = {};    ///< asked before each start; false ends the search
};

enum class InverseKinematicsStatus {
  solved,   ///< the error is within the tolerance
  stalled,  ///< every start ended in a configuration that no small step improves: out of reach, most likely
  iteration_limit,  ///< some start still improved when its iterations were used up, or the monitor ended the search
};
std::string_view to_string(InverseKinematicsStatus status);

struct InverseKinematicsResult {
  InverseKinematicsStatus status{};
  std::vector<double> q;  ///< the best configuration met
  double residual = 0;    ///< norm of the weighted error there
  int iterations = 0;     ///< over all starts
  int restarts = 0;
};

/// The configuration in which places take given poses, by Levenberg and Marquardt's damped least squares on
/// SE(3) with the exact derivative -dexp⁻¹ J^b of the error. Starts at q0; joints at a limit that they would
/// cross are held there. With a posture the joints move towards it as far as the targets leave them free.
/// Allocates. Throws std::invalid_argument for wrong sizes, unknown frames, and numbers that make no sense.
[[nodiscard]] InverseKinematicsResult inverse_kinematics(const Model& model,
                                                         std::span<const PoseTarget> targets,
                                                         std::span<const double> q0,
                                                         const InverseKinematicsOptions& options = {});

}  // namespace axode
