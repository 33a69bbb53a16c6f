#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "axode/contact/contact_point.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/broad_phase.hpp"

namespace axode {

/// Finds the points at which the collision shapes of a mechanism touch or nearly touch. An object is the
/// scratch memory of one thread; the result of a call does not depend on earlier calls.
class ContactFinder {
 public:
  /// Reserves memory for `capacity` contact points, or for 64 points for each shape if `capacity` is 0.
  explicit ContactFinder(ContactShapes shapes, std::size_t capacity = 0);

  /// Finds the contact points with a gap below `margin` (m), in ascending order of their pairs of shapes. `C`
  /// has the pose of the internal frame (the joint frame) of every body in the inertial frame: n_bodies + 1
  /// entries, entry 0 for the ground, all finite. Returns false if there are more points than the capacity;
  /// points() then has only as many as fit. Allocates nothing.
  [[nodiscard]] bool find(std::span<const SE3<>> C, double margin) noexcept;

  /// The contact points that the last call of find() found.
  std::span<const ContactPoint> points() const { return {points_.data(), count_}; }
  const ContactShapes& shapes() const { return shapes_; }

 private:
  ContactShapes shapes_;
  BroadPhase broad_phase_;
  std::vector<SE3<>> poses_;  ///< poses of the shapes in the inertial frame
  std::vector<ContactPoint> points_;
  std::size_t count_ = 0;
};

}  // namespace axode
