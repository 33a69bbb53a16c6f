#pragma once
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/constraints/mechanisms.hpp"

/// Mechanisms whose mobility of higher order is known, drawn by their joints.
namespace axode::test {

/// A joint of a drawing.
struct Pair {
  JointKind kind = JointKind::revolute;
  Vec3<> axis, point;
  Vec3<> second_axis{};
};

inline LoopKind loop_kind(JointKind kind) {
  for (const LoopTraits& loop : loop_kinds)
    if (loop.name == to_string(kind)) return loop.kind;
  throw std::invalid_argument("no loop joint is of this kind");
}

struct Drawing {
  Description description{.name = "mechanism", .bodies = {}, .frames = {}};

  Drawing& body(const std::string& name, const std::string& on, const Pair& pair) {
    BodyDescription body =
        bar(name, on, pair.kind, pair.axis, pair.point, pair.point + Vec3<>{0.3, 0.4, 0.5});
    body.joint.second_axis = pair.second_axis;
    body.joint.pitch = pair.kind == JointKind::helical ? 0.2 : 0;
    description.bodies.push_back(body);
    return *this;
  }
  Drawing& loop(const std::string& first, const std::string& second, const Pair& pair) {
    LoopDescription loop{.between = {first, second}, .kind = loop_kind(pair.kind)};
    if (traits(loop.kind).has("axis")) loop.axis = pair.axis;
    if (traits(loop.kind).has("second_axis")) loop.second_axis = pair.second_axis;
    loop.point = pair.point;
    loop.pitch = pair.kind == JointKind::helical ? 0.2 : 0;
    description.loops.push_back(loop);
    return *this;
  }
  Model model() const { return ModelBuilder(description).build(); }
};

/// One loop of pairs between link 0 (the ground), link 1, ..., cut at one of them.
inline Drawing ring_of(const std::vector<Pair>& pairs, std::size_t cut) {
  Drawing out;
  const std::size_t n = pairs.size();
  const auto name = [&](std::size_t k) { return k % n == 0 ? "ground" : "link " + std::to_string(k); };
  for (std::size_t k = 0; k < cut; ++k) out.body(name(k + 1), name(k), pairs[k]);
  for (std::size_t k = n - 1; k > cut; --k) {
    Pair back = pairs[k];
    if (back.kind == JointKind::universal) std::swap(back.axis, back.second_axis);
    out.body(name(k), name(k + 1), back);
  }
  return out.loop(name(cut), name(cut + 1), pairs[cut]);
}
inline Drawing ring_of(const std::vector<Pair>& pairs) { return ring_of(pairs, pairs.size() - 1); }

inline Pair pin(const Vec3<>& point, const Vec3<>& axis = {0, 0, 1}) {
  return {JointKind::revolute, axis, point};
}
inline Drawing planar(const std::vector<Vec3<>>& points) {
  std::vector<Pair> pairs;
  for (const Vec3<>& point : points) pairs.push_back(pin(point));
  return ring_of(pairs);
}

/// Dimensions of a Watt mechanism: its coupler reaches from (x - s k / 2, h1) to (x + s k / 2, -h2) between
/// level cranks a1 and a2, which lie towards -s and s. The point (x, 0) of the coupler moves up.
struct Watt {
  double h1, h2, a1, a2, k = 0;

  void draw(Drawing& out, const std::string& prefix, double x, double s) const {
    const Vec3<> upper{x - s * k / 2, h1, 0}, lower{x + s * k / 2, -h2, 0};
    out.body(prefix + "crank", "ground", pin(upper - Vec3<>{s * a1, 0, 0}));
    out.body(prefix + "coupler", prefix + "crank", pin(upper));
    out.body(prefix + "rocker", "ground", pin(lower + Vec3<>{s * a2, 0, 0}));
    out.loop(prefix + "coupler", prefix + "rocker", pin(lower));
  }
};
inline Drawing watt_slider(const Watt& watt) {
  Drawing out;
  watt.draw(out, "", 0, 1);
  out.body("slider", "ground", {JointKind::prismatic, {0, 1, 0}, {}});
  return out.loop("coupler", "slider", pin({}));
}
/// Two Watt mechanisms, one the mirror of the other, with a bar of length L between their points (Connelly
/// and Servatius 1994).
inline Drawing double_watt(double L, const Watt& watt) {
  Drawing out;
  watt.draw(out, "a ", 0, 1);
  out.body("bar", "a coupler", pin({}));
  watt.draw(out, "b ", L, -1);
  return out.loop("bar", "b coupler", pin({L, 0, 0}));
}
/// N four-bars in a row, all bars of length 1, flat.
inline Drawing four_bars(int N) {
  Drawing out;
  std::string last = "left bar";
  out.body(last, "ground", pin({}));
  for (int k = 1; k <= N; ++k) {
    const std::string coupler = "coupler " + std::to_string(k), bar = "bar " + std::to_string(k);
    out.body(coupler, last, pin({double(k), 0, 0})).body(bar, "ground", pin({double(k), 0, 0}));
    out.loop(coupler, bar, pin({k + 1.0, 0, 0}));
    last = coupler;
  }
  return out;
}
inline Drawing cube() {
  const Vec3<> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return ring_of({pin({0, 0, 0}, y), pin({1, 0, 0}, z), pin({1, -1, 0}, x), pin({1, -1, 1}, y),
                  pin({0, -1, 1}, z), pin({0, 0, 1}, x)});
}
inline Drawing folded_bricard() {
  std::vector<Pair> pairs;
  for (int k = 0; k < 6; ++k)
    pairs.push_back(pin({double(k % 2), 0, 0},
                        {0, std::cos(k * std::numbers::pi / 3), std::sin(k * std::numbers::pi / 3)}));
  return ring_of(pairs);
}
inline Drawing sarrus() {
  const Vec3<> x{1, 0, 0}, y{0, 1, 0};
  return ring_of({pin({1, 0, 0}, y), pin({2, 0, 1}, y), pin({1, 0, 2}, y), pin({0, 1, 2}, x),
                  pin({0, 2, 1}, x), pin({0, 1, 0}, x)});
}
/// A kite whose pins at (2, 0) turn about a second axis as well.
inline Drawing kite_with_crosses() {
  const Vec3<> y{0, 1, 0};
  return ring_of(
      {pin({0, 0, 0}), pin({2, 0, 0}), pin({2, 0, 0}, y), pin({3, 0, 0}), pin({2, 0, 0}, y), pin({2, 0, 0})});
}
/// Wunderlich's mechanism (1954), the edges of a cube as twelve bars in a plane with pins in its corners, so that
/// its faces are parallelograms or antiparallelograms. Bars along the same direction of the cube have the same
/// length: 1.25, 1 and 0.75. A motion of two freedoms with two antiparallelograms and one of one freedom with four
/// meet here. xjk is the bar along x between the corners (0, j, k) and (1, j, k); x00 is the ground.
inline Drawing wunderlich() {
  const auto corner = [](int x, int y, int z) {
    const Vec3<> along_x{1, z == 0 ? 0.75 : -0.75, 0}, along_y{0, 1, 0}, along_z{0, 0.75, 0};
    return double(x) * along_x + double(y) * along_y + double(z) * along_z;
  };
  Drawing out;
  out.body("y00", "ground", pin(corner(0, 0, 0))).body("y10", "ground", pin(corner(1, 0, 0)));
  out.body("z00", "ground", pin(corner(0, 0, 0))).body("z10", "ground", pin(corner(1, 0, 0)));
  out.body("x10", "y00", pin(corner(0, 1, 0))).body("x01", "z00", pin(corner(0, 0, 1)));
  out.body("z01", "y00", pin(corner(0, 1, 0))).body("z11", "y10", pin(corner(1, 1, 0)));
  out.body("y01", "z00", pin(corner(0, 0, 1))).body("y11", "z10", pin(corner(1, 0, 1)));
  out.body("x11", "z01", pin(corner(0, 1, 1)));
  out.loop("x10", "y10", pin(corner(1, 1, 0)));
  out.loop("x01", "z10", pin(corner(1, 0, 1)));
  out.loop("z01", "y01", pin(corner(0, 1, 1)));
  out.loop("x11", "z11", pin(corner(1, 1, 1)));
  return out.loop("z11", "y11", pin(corner(1, 1, 1)));
}
/// Three legs with universal joints at either end, between a base of radius 1 and a platform.
inline Drawing three_upu(double top, bool locked, bool radial = false) {
  Drawing out;
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * std::numbers::pi * k / 3, c = std::cos(angle), s = std::sin(angle);
    const Vec3<> r{c, s, 0}, t{-s, c, 0}, B = r, P = top * r + Vec3<>{0, 0, 1};
    const Vec3<> l = (1 / norm(P - B)) * (P - B), first = radial ? r : t, second = radial ? t : cross(l, t);
    const std::string leg = "leg " + std::to_string(k) + " ";
    out.body(leg + "cross", "ground", pin(B, first)).body(leg + "lower", leg + "cross", pin(B, second));
    std::string last = leg + "lower";
    if (!locked) out.body(leg + "upper", last, {JointKind::prismatic, l, P});
    if (!locked) last = leg + "upper";
    if (k == 0) {
      out.body(leg + "top", last, pin(P, second)).body("platform", leg + "top", pin(P, first));
    } else {
      out.loop(last, "platform", {JointKind::universal, second, P, first});
    }
  }
  return out;
}

}  // namespace axode::test
