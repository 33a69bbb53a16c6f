#pragma once
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// A singularity of a parallel manipulator near a configuration, or at it.
struct TaskSingularity {
  enum class Type {
    limb,        ///< type 1 (Gosselin and Angeles): joints of a limb can move while the platform is at rest
    drives,      ///< type 2: the platform can move while all drives are locked
    constraint,  ///< the limbs leave the platform a freedom more than elsewhere (Zlatanov et al.)
  };
  Type type{};
  int limb = -1;        ///< of a singularity of type 1
  double distance = 0;  ///< least singular value divided by the largest one; 0 at the singularity
  Twist<Spatial>
      twist;  ///< motion of the platform that becomes free, about the inertial origin, for `drives`
              ///< and `constraint`; the largest of its parts ω and ω-independent v is 1
  std::vector<std::string> joints;  ///< joints of the limb that move, or drives that hold each other
  std::string sentence;             ///< for the user, with the screw of the twist
};

/// Finds the singularities of types 1 and 2 and the constraint singularities whose distance at a closed
/// configuration q is less than `within`. Lengths are measured in the mean distance of the loop joints on the
/// platform from their centre, about which twists are taken, so that distances have no unit. Where a
/// singularity of a limb and one of the drives are found together, it is one of type 3. Allocates; a singular
/// value decomposition for each limb. Throws std::invalid_argument for a mechanism without a platform, a
/// wrong q, and `within` that is not from 0 to 1.
[[nodiscard]] std::vector<TaskSingularity> singularities(TaskSpace& space, std::span<const double> q,
                                                         double within = 1e-3);

}  // namespace axode
