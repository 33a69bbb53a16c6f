#include "axode/constraints/check_loops.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace axode {

void check_drives(const Model& model, std::span<const int> drives) {
  for (const int c : drives)
    if (c < 0 || c >= model.nv())
      throw std::invalid_argument("drives: there is no velocity " + std::to_string(c) + "; model \"" +
                                  model.name() + "\" has velocities 0 to " + std::to_string(model.nv() - 1));
}

std::vector<int> driven(const Model& model, std::span<const int> drives) {
  check_drives(model, drives);
  if (!drives.empty()) return {drives.begin(), drives.end()};
  std::vector<int> all;
  for (int c = 0; c < model.nv(); ++c)
    if (model.loops().driven[static_cast<std::size_t>(c)]) all.push_back(c);
  return all;
}

void check_closed(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v) {
  const Loops& loops = system.model().loops();
  Eigen::VectorXd r(std::max(loops.residuals, loops.rows));
  system.update_kinematics(q.data());
  system.residual(q.data(), r.data());
  for (const LoopRows& loop : loops.all)
    if (const double open = r.segment(loop.first_residual, loop.residuals).norm(); !(open <= closed_enough))
      throw std::invalid_argument(
          "q leaves loop \"" + loop.name + "\" open by " + to_text(open) +
          " (rad and m); assemble() closes it, in a shell --assemble, as \"axode eval FILE --assemble\"");
  system.make_rows(ConstraintLevel::velocity);
  system.velocity_residual(v.data(), r.data());
  const double size = 1 + Eigen::Map<const Eigen::VectorXd>(v.data(), std::ssize(v)).norm();
  for (const LoopRows& loop : loops.all)
    if (const double rate = r.segment(loop.first_row, loop.rows).norm(); !(rate <= closed_enough * size))
      throw std::invalid_argument("v does not keep loop \"" + loop.name + "\" closed: A v is off by " +
                                  to_text(rate) +
                                  " (rad/s and m/s); assemble() finds such velocities, in a shell "
                                  "--assemble, as \"axode eval FILE --assemble\"");
}

void check_accelerations(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v,
                         Numbers<double> a) {
  constexpr double tolerance = 1e-3;  // the tolerance is wide, because accelerations from measurements or
                                      // finite differences have few correct digits
  const Loops& loops = system.model().loops();
  const auto norm = [](Numbers<double> x) {
    return Eigen::Map<const Eigen::VectorXd>(x.data(), std::ssize(x)).norm();
  };
  const double size = 1 + norm(a) + norm(v) * norm(v);
  const std::span<const double> rates = system.acceleration_residual(a.data());
  for (const LoopRows& loop : loops.all) {
    const double error =
        norm(rates.subspan(static_cast<std::size_t>(loop.first_row), static_cast<std::size_t>(loop.rows)));
    if (error <= tolerance * size) continue;
    check_closed(system, q, v);
    throw std::invalid_argument(
        "a does not keep loop \"" + loop.name + "\" closed: A a + gamma is " + to_text(error) +
        " (rad/s^2 and m/s^2) and must be 0, with A from loop_jacobian and gamma from loop_bias");
  }
}

void check_driven(double left, const char* task) {
  if (left > 1e-8)
    throw std::invalid_argument("the drives cannot " + std::string(task) + ": " + to_text(left) +
                                " of the required forces (by norm) is in directions that no drive acts on; "
                                "the drives are the joints that are not passive (a free joint is passive "
                                "unless the drawing has passive = false), or the joints in `drives`");
}

}  // namespace axode
