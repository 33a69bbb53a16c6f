#pragma once
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/embedding/task_space.hpp"
#include "axode/derivatives/rates.hpp"

namespace axode {

/// A drive with a spring between its motor and its joint, both referred to the joint: behind a gear with the
/// ratio N the inertia is N² times that of the rotor.
struct ElasticDrive {
  double stiffness;    ///< k, N m/rad or N/m; infinite for a rigid drive
  double inertia = 0;  ///< I of the motor, kg m² or kg
};

/// The motion and the forces of motors, nv numbers each, referred to their joints. Entries without a drive
/// are 0. The position of a rigid drive on a joint with several velocities is 0.
struct MotorMotion {
  std::vector<double> position;  ///< θ, rad or m
  std::vector<double> velocity;  ///< θ', rad/s or m/s
  std::vector<double> force;     ///< u, N m or N
};

/// Feed-forward for elastic drives, by flatness: the motion of the links, with its derivatives up to the
/// fourth, determines the motors. With the forces Q of the springs and their time derivatives,
///   k (θ - q) = Q,  I θ'' + Q = u   ⟹   θ = q + Q/k,  θ' = v + Q'/k,  u = Q + I (a + Q''/k)        (D17.18)
/// where Q are the drive forces of inverse dynamics, without the inertias of the motors. Armatures of the
/// model belong to the links. Motors that start with θ and θ' and get the force u let the links follow the
/// motion without error. Springs of drives have no damping, because a damped drive is not flat in this sense.
class ElasticFeedForward {
 public:
  /// `drives` has a drive for each velocity (nv); those of passive joints are ignored. A motion of a tree
  /// with passive joints must be one that its drives can produce. Throws std::invalid_argument for a model
  /// with springs, for a wrong number of drives, a stiffness that is not positive, an inertia that is
  /// negative or not finite, and a finite stiffness on a joint with several velocities, which has no angle
  /// that a spring could measure.
  ElasticFeedForward(const Model& model, std::vector<ElasticDrive> drives);

  /// Computes the motors of a mechanism without loops from q and `rates`, which are v, a, jerk and snap (4 nv
  /// numbers, row by row). Allocates nothing once `motors` has memory for nv numbers; O(n). Throws
  /// std::invalid_argument for wrong sizes and for a model with loops.
  void evaluate(std::span<const double> q, std::span<const double> rates, MotorMotion& motors,
                const Loads<double>& loads = {});
  /// Computes the motors of a parallel manipulator from a closed configuration q and the task velocities with
  /// three derivatives, V, V', V'' and V''' (4 freedom() numbers, row by row); see
  /// inverse_dynamics_rates() of a TaskSpace. If the verdict is not ok(), the results are NaN. Allocates;
  /// O(limbs). Throws std::invalid_argument for wrong sizes and for a space whose model has other numbers
  /// of velocities.
  [[nodiscard]] TaskVerdict evaluate(TaskSpace& space, std::span<const double> q,
                                     std::span<const double> rates, MotorMotion& motors,
                                     const Loads<double>& loads = {});

 private:
  /// Computes the motors from v, a (and more) and from Q, Q', Q'' in forces_.
  void put_motors(std::span<const double> q, std::span<const double> rates, MotorMotion& motors) const;

  Model model_;
  std::vector<ElasticDrive> drives_;
  std::vector<char> driven_;     ///< nv
  std::vector<int> coordinate_;  ///< nv: the index in q of the coordinate of a velocity, or -1
  std::optional<InverseDynamicsRates<double>> chain_;  ///< if there are no loops
  std::vector<double> forces_, motion_;                ///< Q, Q', Q'' and v, a, ... (3 nv and 4 nv)
};

}  // namespace axode
