#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "axode/model/model.hpp"

/// The configuration manifold: q has model.nq() coordinates, tangent vectors have model.nv() components, in
/// the joints' left-trivialised directions. All functions throw std::invalid_argument for a wrong size, and for steps
/// so large that a result would not be finite.
namespace axode {

/// Every joint at zero, quaternions at the identity.
std::vector<double> neutral(const Model& model);

/// A configuration within the limits, uniform for each joint: unlimited angles in [-π, π], unlimited lengths
/// in [-1, 1] m, rotations uniform on SO(3). The same seed gives the same configuration.
std::vector<double> random_configuration(const Model& model, std::uint64_t seed);

/// q ⊕ dv: every joint moved along its left-trivialised direction dv.
std::vector<double> integrate(const Model& model, std::span<const double> q, std::span<const double> dv);

/// q1 ⊖ q0: the dv with q0 ⊕ dv = q1, by the shorter way round on rotations (a planar joint's angle is met up
/// to whole turns, a quaternion up to its sign).
std::vector<double> difference(const Model& model, std::span<const double> q0, std::span<const double> q1);

/// q0 ⊕ s (q1 ⊖ q0): screw motion of every joint, q0 at s = 0 and q1 at s = 1.
std::vector<double> interpolate(const Model& model, std::span<const double> q0, std::span<const double> q1,
                                double s);

/// Lower and upper limit of each coordinate; infinite where there is none and for quaternions.
struct CoordinateLimits {
  std::vector<double> lower, upper;
};
CoordinateLimits limits(const Model& model);

/// The nearest configuration within the limits.
std::vector<double> clamp(const Model& model, std::span<const double> q);

/// Throws std::invalid_argument that names the caller's argument and the joint where q has the wrong size or
/// a quaternion's norm is off 1 by more than 1e-6 (1e-4 in float).
void check_configuration(const Model& model, std::span<const double> q, const char* argument = "q");
void check_configuration(const Model& model, std::span<const float> q, const char* argument = "q");

/// Throws std::invalid_argument that names the argument, the actual and the expected size.
void check_size(const char* argument, std::size_t actual, std::size_t expected, const char* meaning);

}  // namespace axode
