#include "axode/constraints/prescribed/prescribed_motion.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/constraints/loop_system/geared_acceleration.hpp"
#include "axode/constraints/prescribed/motion_rows.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/finite.hpp"

namespace axode {

DynamicsAtTime forward_dynamics_at(const Model& model, double t, std::span<const double> q,
                                   std::span<const double> v, std::span<const double> tau,
                                   const Loads<double>& loads, std::span<const PrescribedMotion> motions) {
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  check_configuration(model, q);
  check_size("v", v.size(), nv, "nv");
  check_size("tau", tau.size(), nv, "nv");
  check_loads(model, loads, true);
  for (const auto& [name, x] : {std::pair{"q", q}, {"v", v}, {"tau", tau}})
    if (!finite(x))
      throw std::invalid_argument("forward_dynamics_at: " + std::string(name) + " is not finite");
  if (!std::isfinite(t)) throw std::invalid_argument("forward_dynamics_at: t is " + to_text(t) + " s");
  MotionRows rows(model, motions);
  rows.check_times(t, t);
  LoopSystem<double> system(rows.model());
  rows.impose(t, system);
  DynamicsAtTime found{.solvability = {}, .a = std::vector<double>(nv), .lambda = {}, .motion_forces = {}};
  found.lambda.resize(static_cast<std::size_t>(rows.model().loops().rows));
  found.solvability =
      accelerate_with_losses<double>(system, model, q, v, tau, loads, found.a, found.lambda.data());
  for (const MotionRows::Row& row : rows.rows())
    found.motion_forces.push_back(found.lambda[static_cast<std::size_t>(row.place.row)]);
  found.lambda.resize(static_cast<std::size_t>(model.loops().rows));
  return found;
}

}  // namespace axode
