#pragma once
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/embedding/task_space.hpp"
#include "axode/derivatives/rates.hpp"

namespace axode {

/// A drive with a spring between its motor and its joint. Stiffness and inertia are referred to the joint: if
/// a gear with the ratio N is between motor and spring, the inertia is N² times that of the rotor.
struct ElasticDrive {
  double stiffness;    ///< k, N m/rad or N/m; infinite for a rigid drive
  double inertia = 0;  ///< I of the motor, kg m² or kg
};

/// The motion and the forces of motors, referred to their joints: nv numbers each, one for each velocity of
/// the model. Entries of velocities without a drive are 0. The position is also 0 on a joint with several
/// velocities, where the drive is rigid.
struct MotorMotion {
  std::vector<double> position;  ///< θ, rad or m
  std::vector<double> velocity;  ///< θ', rad/s or m/s
  std::vector<double> force;     ///< u, N m or N
};

/// Feed-forward for elastic drives, by flatness: the motion of the links, with its derivatives up to the
/// fourth, determines the motors. A motor with the inertia I, the position θ and the force u drives a joint
/// with q, v and a through a spring of stiffness k. With the force Q of the spring and its time derivatives,
///   k (θ - q) = Q,  I θ'' + Q = u   ⟹   θ = q + Q/k,  θ' = v + Q'/k,  u = Q + I (a + Q''/k)        (D17.18)
/// Q are the drive forces of inverse dynamics without the inertias of the motors. Armatures of the model
/// count as inertia of the links. If the motors start with θ and θ' and have the force u, the links follow
/// the motion without error. The springs of the drives have no damping, because a drive with a damper is not
/// flat in this sense.
class ElasticFeedForward {
 public:
  /// Takes a drive for each velocity (nv); those of passive joints are ignored. If a tree has passive joints,
  /// the drives must be able to produce the motion that evaluate() is given. Throws std::invalid_argument for
  /// a model with springs, for a wrong number of drives, a stiffness that is not positive, an inertia that is
  /// negative or not finite, and a finite stiffness on a joint with several velocities, which has no angle
  /// that a spring could measure.
  ElasticFeedForward(const Model& model, std::vector<ElasticDrive> drives);

  /// Computes positions, velocities and forces of the motors of a mechanism without loops from q and `rates`,
  /// which are v, a, jerk and snap (4 nv numbers, row by row). Allocates nothing once `motors` has memory for
  /// nv numbers; O(n). Throws std::invalid_argument for wrong sizes, for results that overlap arguments and
  /// for a model with loops.
  void evaluate(std::span<const double> q, std::span<const double> rates, MotorMotion& motors,
                const Loads<double>& loads = {});
  /// Computes positions, velocities and forces of the motors of a parallel manipulator from a configuration q
  /// with closed loops and the task velocities with three derivatives, V, V', V'' and V''' (`rates`, four
  /// rows of freedom() numbers of the task space); see inverse_dynamics_rates() of a TaskSpace. If the result
  /// is not ok(), the entries of all drives are NaN. Allocates; O(m) for m limbs. Throws
  /// std::invalid_argument for wrong sizes, for results that overlap arguments and for a space whose model
  /// does not have nv velocities.
  [[nodiscard]] TaskVerdict evaluate(TaskSpace& space, std::span<const double> q,
                                     std::span<const double> rates, MotorMotion& motors,
                                     const Loads<double>& loads = {});

 private:
  /// Computes the motors from q, from `rates` (v, a and further rows) and from Q, Q' and Q'' in forces_.
  void put_motors(std::span<const double> q, std::span<const double> rates, MotorMotion& motors) const;

  Model model_;
  std::vector<ElasticDrive> drives_;
  std::vector<char> driven_;     ///< nv: whether the velocity has a drive
  std::vector<int> coordinate_;  ///< nv: the index in q of the coordinate of a velocity, or -1
  std::optional<InverseDynamicsRates<double>> chain_;  ///< empty if there are loops
  std::vector<double> forces_, motion_;                ///< Q, Q', Q'' and v, a, ... (3 nv and 4 nv)
};

}  // namespace axode
