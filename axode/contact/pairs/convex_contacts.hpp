#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

/// Contact points of convex bodies that may touch with a face. The poses are those of the shapes in the
/// inertial frame.
namespace axode {

/// Any two shapes that are not planes. The normal is that of the certified distance of the bodies, and the
/// points are the corners of the part of their supporting features that lie beside each other, see clip(). If
/// none of these is as near as the bodies are, the witness points of the distance are a contact as well.
void touch_convex(const ContactShape& a, const SE3<>& A, const ContactShape& b, const SE3<>& B,
                  PointList<>& out) noexcept;

/// Two boxes, as touch_convex(), with the normal of greatest separation among the face normals of both and
/// the common perpendiculars of their edges. A face of a is preferred to one of b, and a face to two edges,
/// as long as this costs no more than rounding and 1e-6 of the size. Boxes whose nearest direction is
/// none of these need touch_convex(): then the function returns false and adds nothing.
template <class T>
bool touch_boxes(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept;

}  // namespace axode
