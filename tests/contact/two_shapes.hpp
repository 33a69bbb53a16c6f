#pragma once
#include <array>
#include <vector>

#include "axode/contact.hpp"
#include "axode/contact/convex/convex_distance.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/lie/random_quantities.hpp"

/// Two free bodies with a collision shape each.
namespace axode::test {

inline constexpr std::array bounded_kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box,
                                          ShapeKind::cylinder, ShapeKind::ellipsoid};

inline ShapeDescription collision_shape(ShapeKind kind, const Vec3<>& size, double radius, double length) {
  return {.role = ShapeDescription::Role::collision,
          .kind = kind,
          .size = size,
          .radius = radius,
          .length = length};
}
/// A shape with half sizes between 0.15 and 0.5 m.
inline ShapeDescription random_collision_shape(Random<double>& random, ShapeKind kind) {
  const auto length = [&] { return random.number(0.15, 0.5); };
  const double scale = kind == ShapeKind::box ? 2 : 1;
  return collision_shape(kind, {scale * length(), scale * length(), scale * length()}, length(),
                         2 * length());
}

inline Model free_bodies(const std::vector<ShapeDescription>& shapes) {
  Description d{.name = "free bodies", .bodies = {}};
  for (std::size_t k = 0; k < shapes.size(); ++k)
    d.bodies.push_back({.name = "body " + std::to_string(k),
                        .joint = {.kind = JointKind::free},
                        .inertia = MassProperties{.mass = 1, .com = {}, .Theta = {1, 1, 1, 0, 0, 0}},
                        .shapes = {shapes[k]}});
  return ModelBuilder(std::move(d)).build();
}

/// Two shapes at given poses.
struct TwoShapes {
  ContactShapes shapes;
  ContactFinder finder;

  TwoShapes(const ShapeDescription& a, const ShapeDescription& b)
      : shapes(free_bodies({a, b})), finder(shapes) {}

  std::span<const ContactPoint> find(const SE3<>& A, const SE3<>& B, double margin) {
    const std::array<SE3<>, 3> C{SE3<>{}, A * inverse(shapes[0].pose), B * inverse(shapes[1].pose)};
    EXPECT_TRUE(finder.find(C, margin));
    return finder.points();
  }
  ConvexDistance distance(const SE3<>& A, const SE3<>& B) const {
    return convex_distance(shapes[0].convex, A, shapes[1].convex, B);
  }
  double size() const { return shapes[0].convex.extent + shapes[1].convex.extent; }
};

}  // namespace axode::test
