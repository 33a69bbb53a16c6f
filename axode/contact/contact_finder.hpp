#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "axode/contact/contact_point.hpp"
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/broad_phase.hpp"

namespace axode {

/// Finds the contact points of a mechanism. It is the scratch memory of one thread; no call depends on an
/// earlier one.
class ContactFinder {
 public:
  /// Reserves memory for `capacity` points; 0 chooses 64 for each shape.
  explicit ContactFinder(ContactShapes shapes, std::size_t capacity = 0);

  /// Finds the points with a gap below `margin` (m), in ascending order of their pairs of shapes. `C` has the
  /// pose of the internal frame of every body in the inertial frame, as BodyPoses gives them: n_bodies + 1
  /// entries, entry 0 for the ground, all finite. Returns false if there are more points than the capacity;
  /// then the points that fit are there. Allocates nothing.
  [[nodiscard]] bool find(std::span<const SE3<>> C, double margin) noexcept;

  /// The points of the last call of find().
  std::span<const ContactPoint> points() const { return {points_.data(), count_}; }
  const ContactShapes& shapes() const { return shapes_; }

 private:
  ContactShapes shapes_;
  BroadPhase broad_phase_;
  std::vector<SE3<>> poses_;  ///< of the shapes in the inertial frame
  std::vector<ContactPoint> points_;
  std::size_t count_ = 0;
};

}  // namespace axode
