#pragma once
#include <optional>
#include <span>
#include <vector>

#include "axode/constraints/embedding/task_space.hpp"
#include "axode/derivatives/rates.hpp"

namespace axode {

/// A drive with a spring between motor and joint. Stiffness and inertia are referred to the joint: if the
/// motor drives the spring by a gear of the ratio N, `inertia` is N² times the inertia of the rotor.
struct ElasticDrive {
  double stiffness;    ///< k, N m/rad or N/m; infinite for a rigid drive
  double inertia = 0;  ///< I of the motor, kg m² or kg
};

/// The motion and the forces of motors, referred to their joints: one number for each velocity of the model
/// (nv). Entries for velocities without a drive are 0. Positions are also 0 for joints with several
/// velocities, which have rigid drives.
struct MotorMotion {
  std::vector<double> position;  ///< θ, rad or m
  std::vector<double> velocity;  ///< θ', rad/s or m/s
  std::vector<double> force;     ///< u, N m or N
};

/// Feed-forward for elastic drives, by flatness: the motion of the links, with its derivatives up to the
/// fourth, determines the motors. A motor with the inertia I, the position θ and the force u drives a joint
/// with the position q, velocity v and acceleration a through an undamped spring of stiffness k. With the
/// spring force Q and its time derivatives,
///   k (θ - q) = Q,  I θ'' + Q = u   ⟹   θ = q + Q/k,  θ' = v + Q'/k,  u = Q + I (a + Q''/k)        (D17.18)
/// Q is the drive force by inverse dynamics without the inertias I; armatures of the model count as inertia
/// of the links. If the motors start with θ and θ' and have the force u, the links follow the motion without
/// error.
class ElasticFeedForward {
 public:
  /// Takes a drive for each velocity (nv); those of passive joints are ignored. Throws std::invalid_argument
  /// for a model with springs, a wrong number of drives, a stiffness that is not positive, an inertia that is
  /// negative or not finite, and a finite stiffness on a joint with several velocities, which has no angle
  /// for a spring.
  ElasticFeedForward(const Model& model, std::vector<ElasticDrive> drives);

  /// Computes positions, velocities and forces of the motors of a mechanism without loops from q and `rates`:
  /// v, a, jerk and snap (4 nv numbers). If joints are passive, the drives must be able to produce this
  /// motion. Allocates nothing once `motors` has memory for nv numbers; O(n). Throws std::invalid_argument
  /// for wrong sizes, results that overlap arguments, and a model with loops.
  void evaluate(std::span<const double> q, std::span<const double> rates, MotorMotion& motors,
                const Loads<double>& loads = {});
  /// Computes positions, velocities and forces of the motors of a parallel manipulator from a configuration q
  /// with closed loops and `rates`: the task velocities V of `space` and their derivatives V', V'' and V''',
  /// one after the other. If the returned verdict is not ok(), the entries of all drives are NaN. Allocates;
  /// O(m) for m limbs, the chains that carry the platform. Throws std::invalid_argument for wrong sizes, for
  /// results that overlap arguments, and if the models of `space` and of this object have different numbers
  /// of velocities.
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
