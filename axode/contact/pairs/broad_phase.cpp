#include "axode/contact/pairs/broad_phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace axode {
namespace {

/// Half the extent of the bounding box of a shape along the inertial axes.
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
  for (int i = 0; i < shapes.size(); ++i)
    (shapes[i].kind == ShapeKind::plane ? planes_ : bounded_).push_back(i);
  boxes_.resize(shapes.size());
  found_.reserve(shapes.pairs().size());
}

std::span<const std::array<int, 2>> BroadPhase::near(const ContactShapes& shapes,
                                                     std::span<const SE3<>> poses, double margin) noexcept {
  found_.clear();
  const auto add = [&](int i, int j) {
    if (shapes.may_touch(i, j)) found_.push_back({std::min(i, j), std::max(i, j)});
  };
  for (const int i : bounded_) {
    const Vec3<> half = half_extent(shapes[i], poses[i].R);
    boxes_[i] = {poses[i].r - half, poses[i].r + half};
    if (std::isnan(boxes_[i].low.x))
      boxes_[i].low.x = -std::numeric_limits<double>::infinity();  // has an order
  }
  for (const int plane : planes_) {
    const Vec3<>& n = poses[plane].R.z;
    for (const int i : bounded_) {
      const Vec3<> center = 0.5 * (boxes_[i].low + boxes_[i].high), half = boxes_[i].high - center;
      const double reach = half.x * std::abs(n.x) + half.y * std::abs(n.y) + half.z * std::abs(n.z);
      if (dot(n, center - poses[plane].r) - reach < margin) add(plane, i);
    }
  }
  std::ranges::sort(bounded_, [&](int i, int j) {
    const double x = boxes_[i].low.x, y = boxes_[j].low.x;
    return x < y || (x == y && i < j);
  });
  for (std::size_t k = 0; k < bounded_.size(); ++k) {
    const Box& a = boxes_[bounded_[k]];
    const auto apart = [&](double one, double other) { return !(other - one < margin); };
    for (std::size_t l = k + 1; l < bounded_.size(); ++l) {
      const Box& b = boxes_[bounded_[l]];
      if (apart(a.high.x, b.low.x)) break;
      if (apart(a.high.y, b.low.y) || apart(b.high.y, a.low.y)) continue;
      if (apart(a.high.z, b.low.z) || apart(b.high.z, a.low.z)) continue;
      add(bounded_[k], bounded_[l]);
    }
  }
  std::ranges::sort(found_);
  return found_;
}

}  // namespace axode
