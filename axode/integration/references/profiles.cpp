#include "axode/integration/references/profiles.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "axode/integration/references/straight_path.hpp"

namespace axode {
namespace {

using Span = std::span<const double>;
using Vector = std::vector<double>;

/// The shortest phase of acceleration, as a fraction of the whole duration, that a trajectory resolves.
constexpr double shortest_ramp = 10 * StraightPath::resolution;

/// A trapezoidal velocity profile: s rises from 0 to 1 as a function of u = t / duration, with constant
/// acceleration until u = ramp, constant velocity, and constant deceleration from u = 1 - ramp on.
struct Trapezoid {
  double duration;    ///< the shortest time within the limits, s
  double ramp = 0.5;  ///< ratio of the time of acceleration to the whole time

  Trapezoid(double length, double velocity, double acceleration)
      : duration(2 * std::sqrt(length / acceleration)) {
    if (!(acceleration * duration / 2 > velocity)) return;
    ramp = std::max(velocity / acceleration / (length / velocity + velocity / acceleration), shortest_ramp);
    duration = length / velocity / (1 - ramp);
  }
  /// Computes s and its derivatives by u. `side` is -1 for values before a jump at u, 1 for those after it.
  MotionValue at(double u, int side) const {
    const double most = 1 / (ramp * (1 - ramp)), from_end = 1 - u,
                 shifted = u + side * StraightPath::resolution;
    if (shifted < ramp) return {u * u * most / 2, u * most, most};
    if (shifted > 1 - ramp) return {1 - from_end * from_end * most / 2, from_end * most, -most};
    return {(u - ramp / 2) / (1 - ramp), 1 / (1 - ramp), 0};
  }
};

}  // namespace

Trajectory quintic_profile(const Model& model, Span start, Span goal, const ProfileLimits& limits) {
  const StraightPath path(model, start, goal);
  const Vector velocity = path.velocity_limits(limits.velocity),
               acceleration = path.limits("acceleration", limits.acceleration);
  double duration = 0;
  for (std::size_t j = 0; j < path.joints().size(); ++j) {
    const double length = path.joints()[j].length;
    duration = std::max({duration, 15.0 / 8 * length / velocity[j],
                         std::sqrt(10 / std::numbers::sqrt3 * length / acceleration[j])});
  }
  const MotionFunction s(MotionDescription{
      .of = {}, .kind = MotionDescription::Kind::ramp, .from = 0, .to = 1, .start = 0, .end = duration});
  return path.follow({}, duration, [&](double t, int, std::span<MotionValue> distances) {
    const MotionValue at = s(t);
    for (std::size_t j = 0; j < distances.size(); ++j) {
      const double length = path.joints()[j].length;
      distances[j] = {length * at.s, length * at.ds, length * at.dds};
    }
  });
}

Trajectory trapezoidal_profile(const Model& model, Span start, Span goal, const ProfileLimits& limits) {
  const StraightPath path(model, start, goal);
  const Vector velocity = path.velocity_limits(limits.velocity),
               acceleration = path.limits("acceleration", limits.acceleration);
  std::vector<Trapezoid> profiles;
  double duration = 0;
  for (std::size_t j = 0; j < path.joints().size(); ++j) {
    profiles.emplace_back(path.joints()[j].length, velocity[j], acceleration[j]);
    duration = std::max(duration, profiles.back().duration);
  }
  Vector jumps;
  for (const Trapezoid& profile : profiles)
    for (const double u : {profile.ramp, 1 - profile.ramp}) jumps.push_back(u * duration);
  return path.follow(jumps, duration, [&](double t, int side, std::span<MotionValue> distances) {
    for (std::size_t j = 0; j < distances.size(); ++j) {
      const MotionValue at = profiles[j].at(t / duration, side);
      const double length = path.joints()[j].length;
      distances[j] = {length * at.s, length / duration * at.ds, length / (duration * duration) * at.dds};
    }
  });
}

}  // namespace axode
