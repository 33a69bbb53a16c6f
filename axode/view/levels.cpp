#include "axode/view/levels.hpp"

#include <algorithm>
#include <cmath>

namespace axode::view {
namespace {

/// A hinge between two bodies in the reference configuration, in the inertial frame.
struct Hinge {
  int a, b;
  Vec3<> axis, point;
};

/// The hinges of a mechanism, each with its two bodies, its axis and a point on it, and the directions of its
/// sliders, at q = 0 in the inertial frame. hinges_and_sliders() returns them if all joints are hinges or
/// sliders and all loop joints are hinges, and std::nullopt otherwise.
struct Planar {
  std::vector<Hinge> hinges;
  std::vector<Vec3<>> slides;
};
std::optional<Planar> hinges_and_sliders(const Model& model) {
  Planar found;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    const SE3<> joint = body.A * body.S_self;
    const Subgroup kind = model.joint(i).kind;
    if (kind == Subgroup::revolute) {
      found.hinges.push_back({body.predecessor, i, joint.R.z, joint.r});
    } else if (kind == Subgroup::prismatic) {
      found.slides.push_back(joint.R.z);
    } else {
      return std::nullopt;
    }
  }
  for (const Loop& loop : model.loops().joints) {
    if (loop.kind != LoopKind::revolute) return std::nullopt;
    const auto& [a, b] = loop.ends;
    for (const Loop::End& end : loop.ends) {
      const SE3<> pose = model.body(end.body).A * model.body(end.body).S_self * end.F;
      found.hinges.push_back({a.body, b.body, pose.R.z, pose.r});
    }
  }
  return found;
}

/// Groups the bodies by the points where their hinges are: for each point, the bodies that meet there. Hinges
/// nearer to each other than `close` are at the same point.
std::vector<std::vector<int>> bodies_at_pins(std::vector<Hinge> hinges, double close) {
  // Hinges at one point are neighbours along any line; on this one hardly any others are.
  const auto along = [](const Hinge& x) { return dot({0.6180339, 0.7548777, 0.2207440}, x.point); };
  std::ranges::sort(hinges, {}, along);
  std::vector<std::vector<int>> pins;
  std::vector<Vec3<>> points;
  for (const Hinge& x : hinges) {
    std::size_t pin = points.size();
    for (std::size_t k = points.size(); k-- > 0 && along(x) - along({0, 0, {}, points[k]}) <= close;)
      if (norm(points[k] - x.point) <= close) pin = k;
    if (pin == points.size()) {
      points.push_back(x.point);
      pins.emplace_back();
    }
    pins[pin].insert(pins[pin].end(), {x.a, x.b});
  }
  return pins;
}

/// The levels of the bodies that meet at a pin.
struct LevelsAtPin {
  std::vector<bool> taken = {};
  int first_free = 1;  ///< the lowest level from 1 on that no body at the pin has

  bool has(int level) const { return level < std::ssize(taken) && taken[level]; }
  void take(int level) {
    if (std::ssize(taken) <= level) taken.resize(static_cast<std::size_t>(level) + 1);
    taken[level] = true;
    while (has(first_free)) ++first_free;
  }
};

}  // namespace

std::optional<Levels> levels_of(const Model& model, double close, const Vec3<>& up) {
  const std::optional<Planar> found = hinges_and_sliders(model);
  if (!found || found->hinges.empty()) return std::nullopt;
  const std::vector<Hinge>& hinges = found->hinges;
  Vec3<> n = hinges[0].axis;
  if (dot(n, up) < -1e-6) n = -n;
  const double height = dot(n, hinges[0].point);
  const bool in_plane = std::ranges::all_of(hinges, [&](const Hinge& x) {
    return std::abs(dot(n, x.axis)) > 0.9999 && std::abs(dot(n, x.point) - height) <= close;
  });
  const bool along_plane =
      std::ranges::all_of(found->slides, [&](const Vec3<>& e) { return std::abs(dot(n, e)) < 1e-4; });
  if (!in_plane || !along_plane) return std::nullopt;

  const std::vector<std::vector<int>> pins = bodies_at_pins(hinges, close);
  std::vector<std::vector<int>> pins_of(static_cast<std::size_t>(model.n_bodies()) + 1);
  for (std::size_t pin = 0; pin < pins.size(); ++pin)
    for (const int i : pins[pin]) pins_of[i].push_back(static_cast<int>(pin));
  std::vector<int> level(static_cast<std::size_t>(model.n_bodies()) + 1);
  std::vector<LevelsAtPin> taken(pins.size());
  for (int i = 1; i <= model.n_bodies(); ++i) {
    if (model.joint(i).kind == Subgroup::prismatic) {  // a slider is in its rail
      level[i] = level[model.body(i).predecessor];
    } else {
      for (const int pin : pins_of[i]) level[i] = std::max(level[i], taken[pin].first_free);
      level[i] = std::max(level[i], 1);
      while (std::ranges::any_of(pins_of[i], [&](int pin) { return taken[pin].has(level[i]); })) ++level[i];
    }
    for (const int pin : pins_of[i]) taken[pin].take(level[i]);
  }
  return Levels{std::move(level), n};
}

}  // namespace axode::view
