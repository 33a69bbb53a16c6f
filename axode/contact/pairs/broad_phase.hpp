#pragma once
#include <array>
#include <span>
#include <vector>

#include "axode/contact/contact_shapes.hpp"

namespace axode {

/// Finds the pairs of shapes whose bounding boxes are nearer than a margin, by a sweep along the x-axis. It
/// is the scratch memory of one thread.
class BroadPhase {
 public:
  BroadPhase() = default;
  explicit BroadPhase(const ContactShapes& shapes);

  /// The pairs (i, j), i < j, of shapes that may touch and whose bounding boxes, or plane and bounding box,
  /// are nearer than `margin` (m) at these poses of the shapes. In ascending order. O(n log n) and the number
  /// of boxes that overlap along x.
  std::span<const std::array<int, 2>> near(const ContactShapes& shapes, std::span<const SE3<>> poses,
                                           double margin) noexcept;

 private:
  struct Box {
    int shape;
    Vec3<> low, high;
  };
  std::vector<int> planes_;
  std::vector<Box> boxes_;  ///< of all other shapes, in the order of their low x
  std::vector<std::array<int, 2>> found_;
};

}  // namespace axode
