#include "axode/integration/references/straight_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "axode/integration/references/number_checks.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Vector = std::vector<double>;

std::string numbered(const char* name, std::size_t k) {
  return std::string(name) + "[" + std::to_string(k) + "]";
}

void check_within_limits(const Model& model, Span goal) {
  const CoordinateLimits limit = limits(model);
  for (std::size_t k = 0; k < goal.size(); ++k)
    if (goal[k] < limit.lower[k] || goal[k] > limit.upper[k])
      throw std::invalid_argument(numbered("goal", k) + " is " + to_text(goal[k]) + "; coordinate " +
                                  quoted(coordinate_names(model)[k]) + " has the limits " +
                                  to_text(limit.lower[k]) + " and " + to_text(limit.upper[k]) +
                                  ", and clamp gives the nearest configuration within limits");
}

/// The number of steps of a trajectory without jumps.
constexpr double fewest_steps = 50;

/// The times of a trajectory: start, jumps and end, and equal steps in between, at least fewest_steps in all.
Vector times_with(Vector jumps, double duration) {
  jumps.push_back(duration);
  std::ranges::sort(jumps);
  Vector times{0};
  for (const double jump : jumps) {
    const double from = times.back(), length = jump - from;
    if (length <= StraightPath::resolution * duration) continue;
    const double count = std::ceil(length / duration * fewest_steps);
    for (double k = 1; k <= count; ++k) times.push_back(k < count ? from + length * (k / count) : jump);
  }
  times.back() = duration;
  return times;
}

/// Returns nv limits, one for each velocity; `given` has nv limits or one for all. Throws
/// std::invalid_argument, with the text `rule`, unless all of them are positive and at most `most`.
Vector positive(const Model& model, const char* name, Span given, double most, const char* rule) {
  for (std::size_t k = 0; k < given.size(); ++k)
    if (!(given[k] > 0) || !(given[k] <= most))
      throw std::invalid_argument(numbered(name, k) + " is " + to_text(given[k]) + "; " + rule);
  return for_each_velocity(model, name, given);
}

}  // namespace

StraightPath::StraightPath(const Model& model, Span start, Span goal) : model_(model) {
  for (const auto& [name, q] : {std::pair{"start", start}, {"goal", goal}}) {
    check_configuration(model, q, name);
    check_finite(name, q);
  }
  check_within_limits(model, goal);
  start_ = normalize(model, start);
  X_ = difference(model, start_, normalize(model, goal));
  for (const axode::Joint& joint : model.joints()) {
    double length = 0;
    for (int c = joint.iv; c < joint.iv + joint.nv; ++c)
      length = std::max(length, std::abs(X_[static_cast<std::size_t>(c)]));
    if (length > 0) joints_.push_back({joint.iv, joint.nv, length});
  }
}

Vector StraightPath::limits(const char* name, Span given) const {
  return of_joints(positive(model_, name, given, std::numeric_limits<double>::max(),
                            "a limit must be positive and finite"));
}

Vector StraightPath::velocity_limits(Span given) const {
  if (!given.empty())
    return of_joints(positive(model_, "velocity", given, std::numeric_limits<double>::infinity(),
                              "a limit must be positive"));
  const Vector of_model = axode::velocity_limits(model_);
  for (std::size_t c = 0; c < of_model.size(); ++c)
    if (!(of_model[c] > 0) && X_[c] != 0)
      throw std::invalid_argument("velocity is missing, and model " + quoted(model_.name()) +
                                  " has the limit " + to_text(of_model[c]) + " for " +
                                  quoted(velocity_names(model_)[c]) + ", which has to move by " +
                                  to_text(X_[c]) + "; give positive limits");
  return of_joints(of_model);
}

Trajectory StraightPath::follow(Vector jumps, double duration, const Profile& profile) const {
  Vector x(X_.size()), v(x), a(x), before(x);
  const Vector tau(x.size());
  std::vector<MotionValue> distances(joints_.size());
  const auto set = [&](double t, int side, Vector& acceleration) {
    profile(t, side, distances);
    for (std::size_t j = 0; j < joints_.size(); ++j)
      for (int i = joints_[j].iv; i < joints_[j].iv + joints_[j].nv; ++i) {
        const auto c = static_cast<std::size_t>(i);
        const double direction = X_[c] / joints_[j].length;
        x[c] = distances[j].s * direction;
        v[c] = distances[j].ds * direction;
        acceleration[c] = distances[j].dds * direction;
      }
  };
  Trajectory motion(model_);
  for (const double t : times_with(std::move(jumps), duration)) {
    set(t, -1, before);
    set(t, 1, a);
    motion.append(t, integrate(model_, start_, x), v, before, tau);
    if (a != before) motion.jump(v, a);
  }
  motion.steps = motion.size() - 1;
  return motion;
}

Vector StraightPath::of_joints(Span of_velocities) const {
  Vector all;
  for (const Joint& joint : joints_) {
    double most = std::numeric_limits<double>::infinity();
    for (int i = joint.iv; i < joint.iv + joint.nv; ++i) {
      const auto c = static_cast<std::size_t>(i);
      if (X_[c] != 0) most = std::min(most, of_velocities[c] * (joint.length / std::abs(X_[c])));
    }
    all.push_back(most);
  }
  return all;
}

}  // namespace axode
