#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "axode/model.hpp"

/// Mechanisms with loops that are closed in the drawn configuration.
namespace axode::test {

/// A slender bar from p to q. Its joint, at p, connects it to another bar.
inline BodyDescription bar(const std::string& name, const std::string& on, JointKind kind, const Vec3<>& axis,
                           const Vec3<>& p, const Vec3<>& q) {
  const Vec3<> d = q - p;
  const double l = dot(d, d) + 0.01;
  return {
      .name = name,
      .predecessor = on,
      .joint = {.kind = kind, .axis = axis, .point = p},
      .inertia = MassProperties{.mass = 1,
                                .com = 0.5 * (p + q),
                                .Theta = {(l - d.x * d.x) / 12, (l - d.y * d.y) / 12, (l - d.z * d.z) / 12,
                                          -d.x * d.y / 12, -d.x * d.z / 12, -d.y * d.z / 12},
                                .in = GivenIn::construction_frame}};
}

/// The bars P0 P1, P1 P2, ... in a row. A loop connects the end of the last one to the ground.
inline Description ring(const std::vector<Vec3<>>& P, const std::vector<Vec3<>>& axes) {
  Description ring{.name = "ring", .gravity = {0, -9.81, 0}, .bodies = {}, .frames = {}};
  std::string last = "ground";
  for (std::size_t k = 0; k + 1 < P.size(); ++k) {
    const std::string name = "bar" + std::to_string(k);
    ring.bodies.push_back(bar(name, last, JointKind::revolute, axes[k], P[k], P[k + 1]));
    last = name;
  }
  ring.loops.push_back({.between = {last, "ground"}, .axis = axes.back(), .point = P.back()});
  return ring;
}

/// Turned in space, so that nothing of it lies in a plane of coordinates.
inline Description four_bar(const SO3<>& R = exp_SO3(Vec3<>{1, 2, 3})) {
  const Vec3<> z = R.z;
  Description d = ring({R * Vec3<>{0, 0, 0}, R * Vec3<>{0, 1, 0}, R * Vec3<>{2, 2, 0}, R * Vec3<>{3, 0, 0}},
                       {z, z, z, z});
  d.name = "four-bar";
  return d;
}

/// Six bars of length 1 along the edges of a cube. Their loop has five rows, one of which is redundant
/// because of the geometry.
inline Description bricard() {
  const std::vector<Vec3<>> P{{1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}, {0, 0, 0}};
  std::vector<Vec3<>> axes;
  for (std::size_t k = 0; k < 6; ++k) axes.push_back(cross(P[k] - P[(k + 5) % 6], P[(k + 1) % 6] - P[k]));
  Description d = ring(P, axes);
  d.name = "Bricard";
  return d;
}

inline Description slider_crank() {
  Description d{.name = "slider-crank", .bodies = {}, .frames = {}};
  d.bodies.push_back(bar("crank", "ground", JointKind::revolute, {0, 0, 1}, {0, 0, 0}, {0, 1, 0}));
  d.bodies.push_back(bar("rod", "crank", JointKind::revolute, {0, 0, 1}, {0, 1, 0}, {2, 0, 0}));
  d.bodies.push_back(bar("slider", "ground", JointKind::prismatic, {1, 0, 0}, {2, 0, 0}, {2.3, 0, 0}));
  d.loops.push_back({.name = "pin", .between = {"rod", "slider"}, .axis = {0, 0, 1}, .point = {2, 0, 0}});
  return d;
}

/// A platform on six legs. Each leg has a universal joint at its foot and a spherical joint at its top.
inline Description gough() {
  Description d{.name = "Gough", .bodies = {}, .frames = {}};
  d.bodies.push_back({.name = "platform",
                      .joint = {.kind = JointKind::free},
                      .inertia = MassProperties{.mass = 10,
                                                .com = {0, 0, 1.2},
                                                .Theta = {.5, .6, .9, 0, 0, 0},
                                                .in = GivenIn::construction_frame}});
  const auto at = [](double r, double w, int k, double z) {
    const double angle = 2.1 * (k / 2) + (k % 2 == 0 ? -w : w);
    return Vec3<>{r * std::cos(angle), r * std::sin(angle), z};
  };
  for (int k = 0; k < 6; ++k) {
    const Vec3<> p = at(1, .9, k, 0), e = at(.6, .2, k, 1.2), x = cross(e - p, Vec3<>{0, 0, 1});
    const std::string foot = "foot" + std::to_string(k), leg = "leg" + std::to_string(k);
    BodyDescription lower = bar(foot, "ground", JointKind::universal, x, p, 0.5 * (p + e));
    lower.joint.second_axis = cross(e - p, x);
    d.bodies.push_back(std::move(lower));
    d.bodies.push_back(bar(leg, foot, JointKind::prismatic, e - p, e, .4 * e + .6 * p));
    d.loops.push_back({.between = {leg, "platform"}, .kind = LoopKind::spherical, .point = e});
  }
  return d;
}

/// A sphere or a disc of radius 0.3 that rolls on the plane z = 0. Gravity need not be perpendicular to the
/// plane.
inline Description wheel(bool sphere, const Vec3<>& gravity = {0, 0, -9.81}) {
  Description d{.name = sphere ? "sphere" : "disc", .gravity = gravity, .bodies = {}, .frames = {}};
  d.bodies.push_back({.name = "wheel",
                      .joint = {.kind = JointKind::free},
                      .inertia = MassProperties{.mass = 2,
                                                .com = {0, 0, .3},
                                                .Theta = sphere ? Sym3<>{.072, .072, .072, 0, 0, 0}
                                                                : Sym3<>{.045, .09, .045, 0, 0, 0}}});
  LoopDescription contact{
      .name = "contact", .between = {"ground", "wheel"}, .kind = LoopKind::rolling, .center = {0, 0, .3}};
  if (!sphere) contact.wheel_axis = Vec3<>{0, 1, 0};
  d.loops.push_back(contact);
  return d;
}

}  // namespace axode::test
