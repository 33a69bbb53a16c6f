#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/model/model.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

/// Prescribed motions: the angle or displacement of a joint with one velocity, or the length of a rod,
/// follows a function s of time ((D12.1) to (D12.4) of docs/derivations). A motion is a loop equation that
/// sets the velocity to s' instead of 0. Its multiplier is the force that is needed for the motion, in N m
/// for an angle and in N for a length; a positive force along a rod pushes its ends apart. Its power is the
/// force times s'.
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

/// Computes the accelerations of a mechanism at time t (s) if joints or rods follow prescribed motions: the
/// motions of the model and those in `motions`. Also computes the multipliers of the loops and the forces of
/// the motions. If the motions leave no degree of freedom, this is inverse dynamics. q and v should close the
/// loops and follow the motions; deviations are not corrected. Springs are ignored. Throws
/// std::invalid_argument for wrong sizes, numbers that are not finite, motions of joints or rods that do not
/// exist, and a time at which a motion is not known. Allocates; O(n + m d + m² d + m³) for n bodies and m
/// equations of loops and motions on paths of d joints.
[[nodiscard]] DynamicsAtTime forward_dynamics_at(const Model& model, double t, std::span<const double> q,
                                                 std::span<const double> v, std::span<const double> tau,
                                                 const Loads<double>& loads = {},
                                                 std::span<const PrescribedMotion> motions = {});

}  // namespace axode
