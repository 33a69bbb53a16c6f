#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

/// Contact points of convex bodies that may touch with a face. Poses are in the inertial frame.
namespace axode {

/// Adds the contact points of any two shapes that are not planes. The normal is the direction of the least
/// distance. The points are the corners of the part in which the supporting features (the facing flat parts)
/// of both shapes lie beside each other. If no corner is as near as the least distance, the midpoint of the
/// nearest points is added as well.
void touch_convex(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  PointList<>& out) noexcept;

/// Adds the contact points of two boxes a and b: the corners of the part in which their facing faces or edges
/// lie beside each other. The normal is chosen among the face normals of both boxes and the common
/// perpendiculars of their edges: it is the one along which the boxes are separated most. If the separation
/// differs only by rounding or 1e-6 of the size, faces of a are preferred to faces of b, and faces to pairs
/// of edges. If none of these normals is the direction of the least distance, the function adds nothing and
/// returns false; then the function for any two convex shapes, touch_convex(), must be called.
template <class T>
bool touch_boxes(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept;

}  // namespace axode
