#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Prescribed motions ((D12.1) to (D12.4) of docs/derivations): the angle or displacement of a joint with one
/// velocity, or the distance between the two points that a rod connects, follows a function s of time. A
/// motion is an equation like those of loops: the rate of the angle, displacement or distance is s'. Its
/// multiplier is the force that the motion needs, in N m for an angle and in N otherwise; a positive force
/// along a rod pushes its ends apart. The power of the force is the force times s'.
namespace axode {

/// A prescribed motion in addition to those in the description of a mechanism.
struct PrescribedMotion {
  std::string of;  ///< name of a joint of one velocity, or of a loop of kind rod
  MotionFunction function;
};

/// The result of forward_dynamics_at().
struct DynamicsAtTime {
  Solvability solvability;
  std::vector<double> a;              ///< accelerations (nv)
  std::vector<double> lambda;         ///< multipliers of the loops (loops().rows)
  std::vector<double> motion_forces;  ///< force of each motion, in the order of the model's motions followed
                                      ///< by those of the argument `motions`
};

/// Computes the accelerations of a mechanism at time t (s), the multipliers of its loops, and the forces of
/// the prescribed motions of the model and of those in `motions`. A motion sets the angle or displacement of
/// a joint, or the length of a rod, as a function of time. If the motions leave no degree of freedom, this is
/// inverse dynamics. q and v should close the loops and follow the motions; deviations are not corrected.
/// Springs are ignored. Throws std::invalid_argument for wrong sizes, numbers that are not finite, motions of
/// joints or rods that do not exist, and a time t at which the function of a motion is not known. Allocates;
/// O(n + m² d + m³) for n bodies, m equations of loops and motions, and at most d joints between a body and
/// the ground.
[[nodiscard]] DynamicsAtTime forward_dynamics_at(const Model& model, double t, std::span<const double> q,
                                                 std::span<const double> v, std::span<const double> tau,
                                                 const Loads<double>& loads = {},
                                                 std::span<const PrescribedMotion> motions = {});

}  // namespace axode
