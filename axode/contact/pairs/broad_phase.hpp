#pragma once
#include <array>
#include <span>
#include <vector>

#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// Finds the pairs of shapes whose bounding boxes are nearer than a margin, by a sweep along the x-axis. An
/// object is the scratch memory of one thread.
class BroadPhase {
 public:
  BroadPhase() = default;
  explicit BroadPhase(const ContactShapes& shapes);

  /// Returns the pairs (i, j), i < j, of shapes that the model allows to touch and whose bounding boxes are
  /// nearer than `margin` (m) along each inertial axis, in ascending order. A pair with a plane is returned
  /// if the bounding box of the other shape is nearer to the plane than `margin`. `poses` are those of the
  /// shapes in the inertial frame. Costs O(n log n) for n shapes, plus the number of pairs of boxes that are
  /// nearer than `margin` along x, plus the number of planes times the number of other shapes.
  std::span<const std::array<int, 2>> near(const ContactShapes& shapes, std::span<const SE3<>> poses,
                                           double margin) noexcept;

 private:
  struct Box {
    int shape;
    Vec3<> low, high;
  };
  std::vector<int> planes_;
  std::vector<Box> boxes_;  ///< bounding boxes of all other shapes, in the order of low.x
  std::vector<std::array<int, 2>> found_;
};

}  // namespace axode
