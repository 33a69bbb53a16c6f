#pragma once
#include <concepts>
#include <string_view>

#include "axode/lie/se3.hpp"

namespace axode {

/// A place, that is a frame on a body: a frame of the model, given by number or by name, or a frame with a
/// pose relative to it. If only a point is given, the place has its origin there and the axes of the frame of
/// the model. A name is looked up at every call and must live as long as the Place.
template <class T = double> struct Place {
  int frame = 0;
  SE3<T> offset;
  std::string_view name = {};  ///< name of the frame, instead of its number

  constexpr Place(int f) : frame(f) {}  // NOLINT(google-explicit-constructor): a frame is a place
  constexpr Place(int f, const Vec3<T>& point) : frame(f), offset{{}, point} {}
  constexpr Place(int f, const SE3<T>& pose) : frame(f), offset(pose) {}
  template <std::convertible_to<std::string_view> Name>
  constexpr Place(const Name& of) : name(of) {}  // NOLINT(google-explicit-constructor): a name is a place
  constexpr Place(std::string_view of, const Vec3<T>& point) : offset{{}, point}, name(of) {}
  constexpr Place(std::string_view of, const SE3<T>& pose) : offset(pose), name(of) {}
};

}  // namespace axode
