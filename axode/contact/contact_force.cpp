#include "axode/contact/contact_force.hpp"

#include <cmath>

#include "axode/contact/law/contact_system.hpp"

namespace axode {

void add_impulse(const VelocityProblem& problem, std::size_t block, const double* lambda,
                 const Vec3<>& normal, ContactForce& out) noexcept {
  const VelocityProblem::Block& b = problem.blocks()[block];
  const ContactFrame axes = contact_frame(normal);
  const auto impulse = [&](int row) {
    const std::size_t k = static_cast<std::size_t>(b.first + row);
    return problem.c[k] * lambda[k];
  };
  out.force += impulse(0) * axes.n + impulse(1) * axes.t1 + impulse(2) * axes.t2;
  if (b.rows > 3) out.moment += impulse(3) * axes.n;
  if (b.rows > 4) out.moment += impulse(4) * axes.t1 + impulse(5) * axes.t2;
}

LawBranch branch_after(const VelocityProblem& problem, std::size_t block, const double* lambda,
                       const double* u, double at_rest) noexcept {
  const VelocityProblem::Block& b = problem.blocks()[block];
  if (!(lambda[b.first] > 0)) return LawBranch::open;
  double squares = 0;
  for (int row = b.first + 1; row < b.first + b.rows; ++row) {
    // A sliding velocity counts also if its coefficient of friction is 0. An angular velocity is multiplied
    // by its coefficient, a length, so that it is in m/s.
    const double c = row < b.first + 3 ? 1 : problem.c[static_cast<std::size_t>(row)];
    squares += c * u[row] * c * u[row];
  }
  return std::sqrt(squares) > at_rest ? LawBranch::slide : LawBranch::stick;
}

}  // namespace axode
