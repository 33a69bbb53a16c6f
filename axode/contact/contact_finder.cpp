#include "axode/contact/contact_finder.hpp"

#include <utility>

#include "axode/contact/pairs/convex_contacts.hpp"
#include "axode/contact/pairs/touch.hpp"

namespace axode {
ContactFinder::ContactFinder(ContactShapes shapes, std::size_t capacity) : shapes_(std::move(shapes)) {
  const std::size_t n = static_cast<std::size_t>(shapes_.size());
  points_.resize(capacity > 0 ? capacity : 64 * n);
  poses_.resize(n);
  broad_phase_ = BroadPhase(shapes_);
}

bool ContactFinder::find(std::span<const SE3<>> C, double margin) noexcept {
  for (int i = 0; i < shapes_.size(); ++i) poses_[i] = C[shapes_[i].body] * shapes_[i].pose;
  PointList<> out(points_, margin);
  for (const auto& [i, j] : broad_phase_.near(shapes_, poses_, margin))
    if (!touch(shapes_, i, j, poses_[i], poses_[j], out))
      touch_convex(shapes_[i], poses_[i], shapes_[j], poses_[j], out);
  count_ = out.count();
  return out.complete();
}

}  // namespace axode
