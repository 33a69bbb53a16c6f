#pragma once
#include "axode/contact/contact_shapes.hpp"
#include "axode/contact/pairs/point_list.hpp"

/// Contact points of the pairs of shapes that have a closed form. Every function adds points to a list `out`
/// if the gap between the surfaces (m, negative in overlap) is less than out.margin(). Normals point from the
/// first shape to the second one. Poses are in the inertial frame.
namespace axode {

/// Adds the contact points of a plane, which bounds a half-space, and any other shape. They are on the
/// surface of the other shape: the lowest point (against the normal of the plane) of a sphere or an
/// ellipsoid, the lowest points of both half balls of a capsule, the vertices of a box or a hull, and on each
/// rim of a cylinder the lowest point and three more a quarter of a turn apart. If more than 16 vertices of a
/// hull are nearer to the plane than out.margin(), only the deepest one and the outermost ones in eight
/// directions along the plane are added.
template <class T>
void touch_plane(const SE3<T>& plane, const ContactShape& shape, const SE3<T>& pose,
                 PointList<T>& out) noexcept;

/// Adds the contact points of two spheres or capsules. If one is a sphere, there is one point. The axes of
/// two capsules are segments, which need not be parallel. They lie side by side along the part where their
/// projections on the axis of `a` overlap. At each end of this part, an end of one axis and the nearest point
/// of the other give a contact point. The point where the axes are nearest is added if its gap is smaller
/// than both gaps at the ends. It is the only point if the points at both ends coincide.
template <class T>
void touch_round(const ContactShape& a, const SE3<T>& A, const ContactShape& b, const SE3<T>& B,
                 PointList<T>& out) noexcept;

/// The contact point of a box and a sphere. The centre of the sphere may be inside the box.
template <class T>
void touch_box_and_sphere(const ContactShape& box, const SE3<T>& A, const ContactShape& sphere,
                          const SE3<T>& B, PointList<T>& out) noexcept;

}  // namespace axode
