#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

namespace axode {

/// Adds the contact points of the pair (i, j) of shapes with the poses A and B in the inertial frame, and
/// returns true, if the points have a closed form. Otherwise the function adds nothing and returns false;
/// then touch_convex() is needed. In either case the pair becomes the selected one of the list of points.
template <class T>
[[nodiscard]] bool touch(const ContactShapes& shapes, int i, int j, const SE3<T>& A, const SE3<T>& B,
                         PointList<T>& out) noexcept;

}  // namespace axode
