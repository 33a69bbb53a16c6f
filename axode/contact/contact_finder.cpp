#include "axode/contact/contact_finder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "axode/contact/pairs/closed_forms.hpp"
#include "axode/contact/pairs/convex_contacts.hpp"

namespace axode {
namespace {

bool is_round(const ContactShape& shape) {
  return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule;
}

/// Adds the points of one pair of shapes.
void touch(const ContactShapes& shapes, int i, int j, const SE3<>* poses, PointList& out) noexcept {
  const auto is = [&](int k, ShapeKind kind) { return shapes[k].kind == kind; };
  const bool first_is_plane = is(i, ShapeKind::plane);
  if (first_is_plane || is(j, ShapeKind::plane)) {
    const int plane = first_is_plane ? i : j, other = first_is_plane ? j : i;
    out.select(plane, other, false);
    return touch_plane(poses[plane], shapes[other], poses[other], out);
  }
  out.select(i, j, false);
  if (is_round(shapes[i]) && is_round(shapes[j]))
    return touch_round(shapes[i], poses[i], shapes[j], poses[j], out);
  if (is(i, ShapeKind::box) && is(j, ShapeKind::box))
    return touch_boxes(shapes[i], poses[i], shapes[j], poses[j], out);
  if (is(i, ShapeKind::box) && is(j, ShapeKind::sphere))
    return touch_box_and_sphere(shapes[i], poses[i], shapes[j], poses[j], out);
  if (is(i, ShapeKind::sphere) && is(j, ShapeKind::box)) {
    out.select(i, j, true);
    return touch_box_and_sphere(shapes[j], poses[j], shapes[i], poses[i], out);
  }
  touch_convex(shapes[i], poses[i], shapes[j], poses[j], out);
}

}  // namespace

ContactFinder::ContactFinder(ContactShapes shapes, std::size_t capacity) : shapes_(std::move(shapes)) {
  const std::size_t n = static_cast<std::size_t>(shapes_.size());
  points_.resize(capacity > 0 ? capacity : 64 * n);
  poses_.resize(n);
  broad_phase_ = BroadPhase(shapes_);
}

bool ContactFinder::find(std::span<const SE3<>> C, double margin) noexcept {
  for (int i = 0; i < shapes_.size(); ++i) poses_[i] = C[shapes_[i].body] * shapes_[i].pose;
  PointList out(points_, margin);
  for (const auto& [i, j] : broad_phase_.near(shapes_, poses_, margin))
    touch(shapes_, i, j, poses_.data(), out);
  count_ = out.count();
  return out.complete();
}

}  // namespace axode
