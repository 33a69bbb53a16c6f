#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "axode/contact/law/contact_law.hpp"
#include "axode/lie/vec3.hpp"

namespace axode {

class VelocityProblem;

/// A contact point, and the force and the moment that act there. Coordinates are in the inertial frame.
struct ContactForce {
  int a = 0, b = 0;            ///< the two shapes, numbered as in ContactShapes
  int body_a = 0, body_b = 0;  ///< the bodies that the shapes move with; 0 is the ground
  Vec3<> point;                ///< half-way between the two surfaces, see ContactPoint, m
  Vec3<> normal;               ///< unit vector from shape a to shape b
  double gap = 0;              ///< distance of the two surfaces, negative in overlap, m
  Vec3<> force = {};           ///< force on b by normal pressure and sliding friction, N; a receives -force
  Vec3<> moment = {};          ///< moment on b by drilling and rolling friction, N m
  double friction = 0;         ///< coefficient of sliding friction
  LawBranch branch = LawBranch::open;
  std::uint64_t key = 0;  ///< identifies the contact from step to step, see ContactPoint

  double normal_force() const { return dot(force, normal); }
  Vec3<> friction_force() const { return force - normal_force() * normal; }
};

/// The name of a branch of the contact law: open, stick or slide.
constexpr std::string_view to_string(LawBranch branch) {
  switch (branch) {
    case LawBranch::open: return "open";
    case LawBranch::stick: return "stick";
    case LawBranch::slide: break;
  }
  return "slide";
}

/// Adds the impulse of one contact to `out`: to out.force the impulse on the second shape, b, at the contact
/// point (N s), and to out.moment the angular impulse on b by drilling and rolling friction (N m s); the
/// caller divides them by the length of the step. If the unknowns of the problem are accelerations instead of
/// velocities, its multipliers are forces, and nothing has to be divided. `block` is the index of the contact
/// in the problem, `lambda` has the multipliers of all constraint rows of the problem, and `normal` is the
/// normal of the contact for which its rows were computed.
void add_impulse(const VelocityProblem& problem, std::size_t block, const double* lambda,
                 const Vec3<>& normal, ContactForce& out) noexcept;
/// Returns whether one contact is open, sticks or slides, from the solution of a contact problem. It is open
/// if the multiplier of its normal row is not positive. Otherwise it slides if the norm of its sliding,
/// drilling and rolling velocities is above `at_rest` (m/s), and sticks if not. In this norm the angular
/// velocities of drilling and rolling are multiplied by their coefficients of friction, which are lengths.
/// `block` is the index of the contact in the problem. `lambda` has the multipliers of all constraint rows,
/// and `u` their velocities (m/s, rad/s), which are not multiplied by coefficients of friction. If the
/// unknowns of the problem are accelerations, u and at_rest are accelerations too.
LawBranch branch_after(const VelocityProblem& problem, std::size_t block, const double* lambda,
                       const double* u, double at_rest) noexcept;

}  // namespace axode
