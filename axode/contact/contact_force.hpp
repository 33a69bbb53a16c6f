#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "axode/contact/law/contact_law.hpp"
#include "axode/lie/vec3.hpp"

namespace axode {

class VelocityProblem;

/// A point of contact and what acts there. Coordinates are in the inertial frame.
struct ContactForce {
  int a = 0, b = 0;            ///< the two shapes as ContactShapes numbers them
  int body_a = 0, body_b = 0;  ///< the bodies that the shapes move with; 0 is the ground
  Vec3<> point;                ///< half-way between the two surfaces, see ContactPoint, m
  Vec3<> normal;               ///< unit vector from a to b
  double gap = 0;              ///< negative in overlap, m
  Vec3<> force = {};           ///< on b, of normal pressure and sliding friction, N; a receives the opposite
  Vec3<> moment = {};          ///< on b, of drilling and rolling friction, N m
  double friction = 0;         ///< coefficient of sliding friction
  LawBranch branch = LawBranch::open;
  std::uint64_t key = 0;  ///< the same from step to step, see ContactPoint

  double normal_force() const { return dot(force, normal); }
  Vec3<> friction_force() const { return force - normal_force() * normal; }
};

/// The name of a branch: open, stick or slide.
constexpr std::string_view to_string(LawBranch branch) {
  switch (branch) {
    case LawBranch::open: return "open";
    case LawBranch::stick: return "stick";
    case LawBranch::slide: break;
  }
  return "slide";
}

/// Adds the impulse of the contact with a block of a problem to the force and moment of `out`. `lambda` has
/// the multipliers of all rows of the problem, and `normal` is that of its rows.
void add_impulse(const VelocityProblem& problem, std::size_t block, const double* lambda,
                 const Vec3<>& normal, ContactForce& out) noexcept;
/// The branch of the contact with a block: open without an impulse; otherwise slide if the velocities u of
/// its rows (of all rows, in physical units) are faster than `at_rest` in the tangent plane, and stick if
/// not.
LawBranch branch_after(const VelocityProblem& problem, std::size_t block, const double* lambda,
                       const double* u, double at_rest) noexcept;

}  // namespace axode
