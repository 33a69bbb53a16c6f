#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

namespace axode {

/// Adds the contact points of the pair (i, j) of shapes with the poses A and B in the inertial frame if they
/// have a closed form, or else returns false; then touch_convex() is needed. Either way the pair is selected
/// in the list of points.
template <class T>
[[nodiscard]] bool touch(const ContactShapes& shapes, int i, int j, const SE3<T>& A, const SE3<T>& B,
                         PointList<T>& out) noexcept;

}  // namespace axode
