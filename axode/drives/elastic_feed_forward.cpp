#include "axode/drives/elastic_feed_forward.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/text.hpp"

namespace axode {
namespace {

void check_drive(const ElasticDrive& drive, bool has_coordinate, const std::string& velocity) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument("the drive of \"" + velocity + "\" " + what);
  };
  if (!(drive.stiffness > 0))
    refuse("has the stiffness " + to_text(drive.stiffness) +
           "; expected a positive number, or infinity for a rigid drive");
  if (!(drive.inertia >= 0) || std::isinf(drive.inertia))
    refuse("has the inertia " + to_text(drive.inertia) + "; expected a finite number that is not negative");
  if (!has_coordinate && !std::isinf(drive.stiffness))
    refuse("is elastic, but its joint has several velocities; give it an infinite stiffness");
}

void check_apart(const MotorMotion& motors, std::span<const double> q, std::span<const double> rates) {
  for (const std::vector<double>* const x : {&motors.position, &motors.velocity, &motors.force}) {
    check_separate("motors", std::span<const double>(*x), "q", q);
    check_separate("motors", std::span<const double>(*x), "rates", rates);
  }
}

}  // namespace

ElasticFeedForward::ElasticFeedForward(const Model& model, std::vector<ElasticDrive> drives)
    : model_(model),
      drives_(std::move(drives)),
      driven_(model.loops().driven),
      coordinate_(static_cast<std::size_t>(model.nv()), -1) {
  const std::size_t nv = coordinate_.size();
  check_size("drives", drives_.size(), nv, "nv");
  if (!model.springs().empty())
    throw std::invalid_argument("ElasticFeedForward does not count springs, and model \"" + model.name() +
                                "\" has springs; remove them");
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    if (!joint.leader && joint.nv == 1) coordinate_[static_cast<std::size_t>(joint.iv)] = joint.iq;
  }
  const std::vector<std::string> names = velocity_names(model);
  for (std::size_t c = 0; c < nv; ++c)
    if (driven_[c]) check_drive(drives_[c], coordinate_[c] >= 0, names[c]);
  if (model.loops().empty()) chain_.emplace(model, 2);
  forces_.resize(3 * nv);
  motion_.resize(4 * nv);
}

void ElasticFeedForward::evaluate(std::span<const double> q, std::span<const double> rates,
                                  MotorMotion& motors, const Loads<double>& loads) {
  if (!chain_)
    throw std::invalid_argument("model \"" + model_.name() +
                                "\" has loops; pass a TaskSpace of it, and task velocities");
  check_configuration(model_, q);
  check_size("rates", rates.size(), motion_.size(), "4 nv");
  check_apart(motors, q, rates);
  chain_->evaluate(q, rates, forces_, loads);
  put_motors(q, rates, motors);
}

TaskVerdict ElasticFeedForward::evaluate(TaskSpace& space, std::span<const double> q,
                                         std::span<const double> rates, MotorMotion& motors,
                                         const Loads<double>& loads) {
  check_size("velocities of the space", static_cast<std::size_t>(space.model().nv()), driven_.size(), "nv");
  check_apart(motors, q, rates);
  const TaskVerdict verdict = inverse_dynamics_rates(space, q, rates, forces_, motion_, loads);
  put_motors(q, motion_, motors);
  return verdict;
}

void ElasticFeedForward::put_motors(std::span<const double> q, std::span<const double> rates,
                                    MotorMotion& motors) const {
  const std::size_t nv = driven_.size();
  for (std::vector<double>* const x : {&motors.position, &motors.velocity, &motors.force}) x->assign(nv, 0);
  for (std::size_t c = 0; c < nv; ++c) {
    if (!driven_[c]) continue;
    const auto& [k, I] = drives_[c];
    const double Q = forces_[c], dQ = forces_[nv + c], ddQ = forces_[2 * nv + c];
    if (coordinate_[c] >= 0) motors.position[c] = q[static_cast<std::size_t>(coordinate_[c])] + Q / k;
    motors.velocity[c] = rates[c] + dQ / k;
    motors.force[c] = Q + I * (rates[nv + c] + ddQ / k);
  }
}

}  // namespace axode
