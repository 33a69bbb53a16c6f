#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

namespace axode {

/// Adds the contact points of a pair of shapes with the poses A and B in the inertial frame, if they have a
/// closed form. Otherwise the function returns false, and touch_convex() has to find them; the pair of the
/// list is selected in either case.
template <class T>
[[nodiscard]] bool touch(const ContactShapes& shapes, int i, int j, const SE3<T>& A, const SE3<T>& B,
                         PointList<T>& out) noexcept;

}  // namespace axode
