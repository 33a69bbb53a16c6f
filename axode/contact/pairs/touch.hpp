#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

namespace axode {

/// Adds the contact points of the pair of shapes i and j, with the poses A and B in the inertial frame, if
/// there is a closed form for this pair. Otherwise returns false; then the function for any two convex
/// shapes, touch_convex(), must be called. In both cases, points that are added next belong to this pair.
template <class T>
[[nodiscard]] bool touch(const ContactShapes& shapes, int i, int j, const SE3<T>& A, const SE3<T>& B,
                         PointList<T>& out) noexcept;

}  // namespace axode
