#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

/// Contact points of pairs of shapes that have a closed form. Every function adds the points with a gap below
/// the margin of the list, with normals from the first shape to the second one. The poses are those of the
/// shapes in the inertial frame.
namespace axode {

/// The half-space of a plane against any other shape; the points are on the surface of that shape. A sphere
/// and an ellipsoid have their lowest point, a capsule the lowest points of both half balls, a box and a hull
/// their vertices, of more than 16 that are within the margin the deepest and the outermost ones. A cylinder
/// has four points on either rim: the lowest one, and three more a quarter of a turn apart.
template <class T>
void touch_plane(const SE3<T>& plane, const ContactShape& shape, const SE3<T>& pose,
                 PointList<T>& out) noexcept;

/// Two spheres or capsules. Capsules have a point where their axes are nearest, and a point at either end of
/// the part along which they lie side by side.
template <class T>
void touch_round(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept;

/// A box and a sphere, whose centre may be inside the box.
template <class T>
void touch_box_and_sphere(const ContactShape& box, const SE3<T>& A, const ContactShape& sphere,
                          const SE3<T>& B, PointList<T>& out) noexcept;

}  // namespace axode
