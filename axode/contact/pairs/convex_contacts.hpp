#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/displaced.hpp"
#include "axode/contact/pairs/point_list.hpp"

/// Contact points of convex bodies that may touch with a face. Poses are in the inertial frame.
namespace axode {

/// Adds the contact points of any two shapes that are not planes. The normal is the direction of the least
/// distance. Each shape has a supporting feature, the flat part of its surface that faces the other shape.
/// The points are the corners of the region in which both features overlap when seen along the normal. If
/// no corner is as near as the least distance, the midpoint of the nearest points is added as well.
void touch_convex(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  PointList<>& out) noexcept;

/// Adds the points of touch_convex() with their derivatives if both shapes are boxes or hulls. The normal is
/// that of a face or the common perpendicular of two edges. Returns false if it is neither, because a corner
/// is nearest to a corner or to an edge, or if one of the shapes is round.
bool touch_polytopes(const ContactShape& a, const SE3<Displaced>& A, const ContactShape& b,
                     const SE3<Displaced>& B, PointList<Displaced>& out) noexcept;

/// Adds the contact points of two boxes a and b: the corners of the region in which the faces that face each
/// other overlap when seen along the normal. Of the face normals of both boxes and the common perpendiculars
/// of their edges, the normal is the one along which the boxes are separated most. If the separations differ
/// by rounding errors only, a face is preferred to a pair of edges, and a face of a to one of b. If no corner
/// is as near as the greatest separation, the function adds nothing and returns false; then
/// touch_convex(), the function for any two convex shapes, must be called.
template <class T>
bool touch_boxes(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept;

}  // namespace axode
