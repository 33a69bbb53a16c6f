#pragma once
#include <functional>
#include <span>
#include <vector>

#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// The path from a configuration `start` to a configuration `goal` on which every joint moves along its
/// geodesic: q = start ⊕ s X, v = s' X and a = s'' X, where X is the displacement with start ⊕ X = goal, and
/// each joint has a function s of time that rises from 0 to 1. The length of a joint's path is the largest
/// magnitude of its entries of X, and the distance that it has gone is s times this length.
class StraightPath {
 public:
  /// A joint that moves along the path.
  struct Joint {
    int iv, nv;     ///< its velocities are v[iv] to v[iv + nv - 1]
    double length;  ///< the largest |X_c| of its velocities, rad or m
  };

  /// Computes the path from `start` to `goal` on which every joint moves along its geodesic. Throws
  /// std::invalid_argument for wrong sizes, numbers that are not finite, quaternions that are not of unit
  /// norm, and a goal outside the limits of the joints; the start may be outside.
  StraightPath(const Model& model, std::span<const double> start, std::span<const double> goal);

  const Model& model() const { return model_; }
  /// The joints whose start and goal differ.
  std::span<const Joint> joints() const { return joints_; }

  /// Converts limits on velocities, accelerations or jerks (rad or m per s, s² or s³) to one limit for each
  /// joint that moves: the largest speed, acceleration or jerk of the distance that the joint has gone along
  /// its path at which all its velocities are within their limits. On the path the displacements of a joint
  /// from its start are proportional to each other, and the distance is the largest of their magnitudes, rad
  /// or m. `given` has one limit for each velocity, or one for all. Messages call the limits `name`. Throws
  /// std::invalid_argument unless the limits are positive and finite.
  std::vector<double> limits(const char* name, std::span<const double> given) const;
  /// Returns one speed (rad/s or m/s) for each joint that moves: the largest rate of the distance that the
  /// joint has gone along its path at which all its velocities are within their limits. On the path the
  /// displacements of a joint from its start are proportional to each other, and the distance is the largest
  /// of their magnitudes, rad or m. `given` has one limit for each velocity, or one for all, which may be
  /// infinite. If it is empty, the limits of the model are taken. Throws std::invalid_argument for limits
  /// that are not positive; in the model they are allowed for velocities that stay 0.
  std::vector<double> velocity_limits(std::span<const double> given) const;

  /// A function that writes how far each of the joints that move has gone along its path at time t, which is
  /// between 0 and the duration, and the first two derivatives of this distance by t. If they jump at t,
  /// `side` chooses the values before the jump (-1) or after it (1).
  using Profile = std::function<void(double t, int side, std::span<MotionValue> distances)>;
  /// Computes the trajectory on which joints move along their paths as `profile` says. It has at least fifty
  /// steps, and states at all times in `jumps`, where a second or third derivative of the distances that
  /// `profile` writes jumps. Between its states, the trajectory is exact if these distances are polynomials
  /// of degree 5 in time. If no joint moves, it has one state.
  Trajectory follow(std::vector<double> jumps, double duration, const Profile& profile) const;

  /// Two jumps whose distance in time is less than this fraction of the duration are taken as one.
  static constexpr double resolution = 1e-7;

 private:
  std::vector<double> of_joints(std::span<const double> of_velocities) const;

  Model model_;
  std::vector<double> start_, X_;
  std::vector<Joint> joints_;
};

}  // namespace axode
