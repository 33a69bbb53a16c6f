#pragma once
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// A singularity of a parallel manipulator near a configuration, or at it.
struct TaskSingularity {
  enum class Type {
    limb,        ///< type 1 (Gosselin and Angeles): joints of a limb can move while the platform is at rest
    drives,      ///< type 2: the platform can move while all drives are locked
    constraint,  ///< the limbs leave the platform one freedom more than at regular configurations (Zlatanov
                 ///< et al.)
  };
  Type type{};
  int limb = -1;        ///< index of the limb in a singularity of type 1; otherwise -1
  double distance = 0;  ///< least singular value of the matrix that loses rank, divided by the largest one; 0
                        ///< at the singularity
  /// The motion of the platform that becomes free in a singularity of type `drives` or `constraint`, a twist
  /// (ω; v) about the inertial origin. It is scaled such that the larger of |ω| and |u| / length is 1, where
  /// u is the velocity of the centre of the loop joints on the platform, and length their mean distance from
  /// this centre.
  Twist<Spatial> twist;
  std::vector<std::string> joints;  ///< velocities of the limb that can move, or drives that act against each
                                    ///< other
  std::string sentence;             ///< one sentence for the user, with the screw of the twist
};

/// Finds the singularities of a parallel manipulator near a configuration q with closed loops. In a
/// singularity of each type a matrix loses rank:
///   - type 1: the Jacobian of the loop equations of one limb (a chain that carries the platform) by the
///     limb's own velocities;
///   - type 2: the matrix that maps the motions of the platform that the limbs allow to the velocities of the
///     drives;
///   - constraint singularities: the matrix of the conditions of all limbs on the twist of the platform.
/// The distance from a singularity is the least singular value of this matrix at q that is not 0 at regular
/// configurations, divided by the largest one. Singularities with a distance below `within` are returned.
/// Lengths are divided by the mean distance of the loop joints on the platform from their centre. Allocates;
/// one singular value decomposition for each limb. Throws std::invalid_argument for a mechanism without a
/// platform, for a wrong size of q, a q that leaves a loop open, and `within` that is not from 0 to 1.
[[nodiscard]] std::vector<TaskSingularity> singularities(TaskSpace& space, std::span<const double> q,
                                                         double within = 1e-3);

}  // namespace axode
