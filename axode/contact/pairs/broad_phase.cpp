#include "axode/contact/pairs/broad_phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace axode {
namespace {

/// Half the edges of the bounding box of a shape, which has the directions of the inertial axes, m.
Vec3<> half_extent(const ContactShape& shape, const SO3<>& R) noexcept {
  const Vec3<>&h = shape.half, &axis = R.z;
  switch (shape.kind) {
    case ShapeKind::sphere: return {shape.radius, shape.radius, shape.radius};
    case ShapeKind::capsule: {
      const double r = shape.radius, l = shape.half_length;
      return {r + l * std::abs(axis.x), r + l * std::abs(axis.y), r + l * std::abs(axis.z)};
    }
    case ShapeKind::box: {
      const auto along = [&](double x, double y, double z) {
        return h.x * std::abs(x) + h.y * std::abs(y) + h.z * std::abs(z);
      };
      return {along(R.x.x, R.y.x, R.z.x), along(R.x.y, R.y.y, R.z.y), along(R.x.z, R.y.z, R.z.z)};
    }
    case ShapeKind::ellipsoid: {
      const auto along = [&](double x, double y, double z) {
        return std::sqrt(h.x * h.x * x * x + h.y * h.y * y * y + h.z * h.z * z * z);
      };
      return {along(R.x.x, R.y.x, R.z.x), along(R.x.y, R.y.y, R.z.y), along(R.x.z, R.y.z, R.z.z)};
    }
    case ShapeKind::cylinder: {
      const auto along = [&](double x) {
        return shape.half_length * std::abs(x) + shape.radius * std::sqrt(std::max(0.0, 1 - x * x));
      };
      return {along(axis.x), along(axis.y), along(axis.z)};
    }
    case ShapeKind::mesh:
    case ShapeKind::plane: break;
  }
  return {shape.convex.extent, shape.convex.extent, shape.convex.extent};
}

}  // namespace

BroadPhase::BroadPhase(const ContactShapes& shapes) {
  for (int i = 0; i < shapes.size(); ++i) {
    if (shapes[i].kind == ShapeKind::plane)
      planes_.push_back(i);
    else
      boxes_.push_back({.shape = i, .low = {}, .high = {}});
  }
  found_.reserve(shapes.pairs().size());
}

std::span<const std::array<int, 2>> BroadPhase::near(const ContactShapes& shapes,
                                                     std::span<const SE3<>> poses, double margin) noexcept {
  found_.clear();
  const auto add = [&](int i, int j) {
    if (shapes.may_touch(i, j)) found_.push_back({std::min(i, j), std::max(i, j)});
  };
  for (Box& box : boxes_) {
    const SE3<>& pose = poses[box.shape];
    const Vec3<> half = half_extent(shapes[box.shape], pose.R);
    box.low = pose.r - half;
    box.high = pose.r + half;
    if (std::isnan(box.low.x)) box.low.x = -std::numeric_limits<double>::infinity();  // has an order
  }
  for (const int plane : planes_) {
    const Vec3<>& n = poses[plane].R.z;
    for (const Box& box : boxes_) {
      const Vec3<> center = 0.5 * (box.low + box.high), half = box.high - center;
      const double reach = half.x * std::abs(n.x) + half.y * std::abs(n.y) + half.z * std::abs(n.z);
      if (dot(n, center - poses[plane].r) - reach < margin) add(plane, box.shape);
    }
  }
  std::ranges::sort(boxes_, {}, [](const Box& box) { return std::pair(box.low.x, box.shape); });
  for (auto a = boxes_.begin(); a != boxes_.end(); ++a)
    for (auto b = a + 1; b != boxes_.end() && b->low.x - a->high.x < margin; ++b) {
      const double y = std::max(b->low.y - a->high.y, a->low.y - b->high.y);
      const double z = std::max(b->low.z - a->high.z, a->low.z - b->high.z);
      if (std::max(y, z) < margin) add(a->shape, b->shape);
    }
  std::ranges::sort(found_);
  return found_;
}

}  // namespace axode
