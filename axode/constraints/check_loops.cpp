#include "axode/constraints/check_loops.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "axode/constraints/stable_norm.hpp"

namespace axode {
namespace {

/// The part of `x` that belongs to one range of rows.
std::span<const double> loop_part(std::span<const double> x, int first, int size) {
  return x.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size));
}

}  // namespace

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
  std::vector<double> r(static_cast<std::size_t>(std::max(loops.residuals, loops.rows)));
  system.update_kinematics(q.data());
  system.residual(q.data(), r.data());
  for (const LoopRows& loop : loops.all)
    if (const double open = stable_norm(loop_part(r, loop.first_residual, loop.residuals));
        !is_within(open, closed_enough))
      throw std::invalid_argument(
          "q leaves loop \"" + loop.name + "\" open by " + to_text(open) +
          " (rad and m); assemble() closes it, in a shell --assemble, as \"axode eval FILE --assemble\"");
  system.make_rows(ConstraintLevel::velocity);
  system.velocity_residual(v.data(), r.data());
  const double size = 1 + stable_norm(v);
  for (const LoopRows& loop : loops.all)
    if (const double rate = stable_norm(loop_part(r, loop.first_row, loop.rows));
        !is_within(rate, closed_enough * size))
      throw std::invalid_argument("v does not keep loop \"" + loop.name + "\" closed: A v is off by " +
                                  to_text(rate) +
                                  " (rad/s and m/s); assemble() finds such velocities, in a shell "
                                  "--assemble, as \"axode eval FILE --assemble\"");
}

void check_accelerations(LoopSystem<double>& system, Numbers<double> q, Numbers<double> v,
                         Numbers<double> a) {
  constexpr double tolerance = 1e-3;  // the tolerance is wide, because accelerations from measurements or
                                      // finite differences have few correct digits
  const double speed = stable_norm(v);
  const double bound = tolerance * (1 + stable_norm(a)) + (tolerance * speed) * speed;
  const std::span<const double> rates = system.acceleration_residual(a.data());
  for (const LoopRows& loop : system.model().loops().all) {
    const double error = stable_norm(loop_part(rates, loop.first_row, loop.rows));
    if (is_within(error, bound)) continue;
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
