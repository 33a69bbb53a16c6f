#pragma once
#include <cstddef>
#include <span>

#include "axode/contact/contact_point.hpp"

namespace axode {

/// A list of contact points of pairs of shapes, in memory that the caller provides.
template <class T = double> class PointList {
 public:
  PointList(std::span<ContactPointOf<T>> memory, double margin) : memory_(memory), margin_(margin) {}

  /// Selects the pair of shapes (a, b) to which the points of the next calls of add() belong. If `flipped`,
  /// the normals that are given to add() point from b to a.
  void select(int a, int b, bool flipped) noexcept {
    a_ = a;
    b_ = b;
    flipped_ = flipped;
  }
  double margin() const noexcept { return margin_; }

  /// Adds a point if its gap is below the margin. `feature` (below 2^24) distinguishes the points of a pair.
  void add(const Vec3<T>& point, const Vec3<T>& n, const T& gap, std::uint32_t feature) noexcept {
    if (!(gap < T(margin_))) return;
    if (count_ == memory_.size()) {
      complete_ = false;
      return;
    }
    memory_[count_++] = {a_, b_, point, flipped_ ? -n : n, gap, contact_key(a_, b_, feature)};
  }
  std::size_t count() const noexcept { return count_; }
  /// Whether there was memory for every point.
  bool complete() const noexcept { return complete_; }

 private:
  std::span<ContactPointOf<T>> memory_;
  double margin_;
  std::size_t count_ = 0;
  bool complete_ = true, flipped_ = false;
  int a_ = 0, b_ = 0;
};

}  // namespace axode
