#pragma once
#include "axode/lie/se3.hpp"

namespace axode {

/// A place on a mechanism: a frame of the model, or a point or pose given in that frame.
template <class T = double> struct Place {
  int frame;
  SE3<T> offset;

  constexpr Place(int f) : frame(f) {}  // NOLINT(google-explicit-constructor): a frame is a place
  constexpr Place(int f, const Vec3<T>& point) : frame(f), offset{{}, point} {}
  constexpr Place(int f, const SE3<T>& pose) : frame(f), offset(pose) {}
};

}  // namespace axode
