#pragma once
#include <array>
#include <cmath>

#include "axode/contact/convex/convex_shape.hpp"

/// Support functions h(n) = max of n·x over the points x of a core. A convex shape is the sum of its core and
/// a ball. The core is a box, a cylinder, a hull or, for an ellipsoid, the set of its points whose distance
/// from its surface is at least the radius of the ball. A support function consists of smooth branches, each
/// of which belongs to a vertex of a box or hull, to one of the two caps of a cylinder (0 is the upper, 1 the
/// lower one), or to the whole core of an ellipsoid (0).
namespace axode::convex {

template <class T> Vec3<T> unit(const Vec3<T>& a) { return (T(1) / norm(a)) * a; }
/// A unit vector that is perpendicular to the unit vector n.
template <class T> Vec3<T> perpendicular(const Vec3<T>& n) {
  const bool across_x = n.x < T(0.6) && -n.x < T(0.6);
  return unit(across_x ? Vec3<T>{T(0), -n.z, n.y} : Vec3<T>{-n.y, n.x, T(0)});
}

/// Returns the unit vector along the part of n that is perpendicular to the unit vector `axis`; if n is
/// parallel to the axis, returns `otherwise`. The result is perpendicular to the axis to rounding.
template <class T> Vec3<T> across(const Vec3<T>& axis, const Vec3<T>& n, const Vec3<T>& otherwise) {
  const Vec3<T> side = cross(axis, n);
  const T sine2 = dot(side, side);
  return sine2 > T(1e-24) ? cross((T(1) / sqrt(sine2)) * side, axis) : otherwise;
}

/// The number of the sector in which the unit vector n lies, 0 to 26. The directions are divided into one
/// sector for each vertex, edge and face of a cube; 13, the number of its centre, does not occur.
inline int sector(const Vec3<>& n) {
  const auto third = [](double x) { return (x > -0.38) + (x > 0.38); };
  return third(n.x) + 3 * third(n.y) + 9 * third(n.z);
}

/// The point of the core (the shape without the ball that is added to it) that one smooth part (branch) of
/// its support function gives for the unit normal n, in the axes of the shape.
inline Vec3<> branch_point(const ConvexShape& shape, int branch, const Vec3<>& n) {
  const Vec3<>& h = shape.size;
  switch (shape.core) {
    case ConvexShape::Core::box:
      return {branch & 1 ? -h.x : h.x, branch & 2 ? -h.y : h.y, branch & 4 ? -h.z : h.z};
    case ConvexShape::Core::hull: return shape.hull->vertices[branch];
    case ConvexShape::Core::cylinder: {
      const double rho = std::sqrt(n.x * n.x + n.y * n.y), scale = rho > 0 ? h.x / rho : 0;
      return {scale * n.x, scale * n.y, branch != 0 ? -h.z : h.z};
    }
    case ConvexShape::Core::ellipsoid: break;
  }
  const Vec3<> q{h.x * n.x, h.y * n.y, h.z * n.z};
  return (1 / norm(q)) * Vec3<>{h.x * q.x, h.y * q.y, h.z * q.z} - shape.radius * n;
}

/// The number of the smooth part (branch) of the core's support function to which the unit normal n belongs;
/// the core is the shape without the ball that is added to it. For a hull this is the vertex that is highest
/// along n. The search for it starts at the vertex `hint` or, if this is higher, at a stored vertex for
/// directions like n, and walks to ever higher neighbours.
inline int support_branch(const ConvexShape& shape, const Vec3<>& n, int hint) {
  const Vec3<>& h = shape.size;
  switch (shape.core) {
    case ConvexShape::Core::box:
      return int(h.x > 0 && n.x < 0) | int(h.y > 0 && n.y < 0) << 1 | int(h.z > 0 && n.z < 0) << 2;
    case ConvexShape::Core::cylinder: return h.z > 0 && n.z < 0;
    case ConvexShape::Core::ellipsoid: return 0;
    case ConvexShape::Core::hull: break;
  }
  const Hull& hull = *shape.hull;
  const int start = hull.start[sector(n)];
  if (dot(n, hull.vertices[start]) > dot(n, hull.vertices[hint])) hint = start;
  double best = dot(n, hull.vertices[hint]);
  for (int last = -1; last != hint;) {
    last = hint;
    for (int k = hull.first_neighbour[last]; k < hull.first_neighbour[last + 1]; ++k) {
      const int neighbour = hull.neighbours[k];
      const double height = dot(n, hull.vertices[neighbour]);
      if (height > best) {
        best = height;
        hint = neighbour;
      }
    }
  }
  return hint;
}

/// A point of the body, its ball included, that is farthest along the unit vector n in the axes of the shape.
inline Vec3<> support_point(const ConvexShape& shape, const Vec3<>& n) {
  return branch_point(shape, support_branch(shape, n, 0), n) + shape.radius * n;
}

/// The second derivative of the support function of the core (the shape without the ball that is added to it)
/// at the unit normal n: the entries uu, uv and vv of a matrix in the basis of two tangents u and v. It has
/// the radii of curvature (in m) as eigenvalues, and is 0 for boxes and hulls.
inline std::array<double, 3> support_hessian(const ConvexShape& shape, const Vec3<>& n, const Vec3<>& u,
                                             const Vec3<>& v) {
  const Vec3<>& h = shape.size;
  if (shape.core == ConvexShape::Core::cylinder) {
    const double rho2 = n.x * n.x + n.y * n.y, scale = h.x / (rho2 * std::sqrt(rho2));
    const double eu = n.x * u.y - n.y * u.x, ev = n.x * v.y - n.y * v.x;
    return {scale * eu * eu, scale * eu * ev, scale * ev * ev};
  }
  if (shape.core != ConvexShape::Core::ellipsoid) return {};
  const auto stretch = [&](const Vec3<>& a) { return Vec3<>{h.x * a.x, h.y * a.y, h.z * a.z}; };
  const Vec3<> p = stretch(n), pu = stretch(u), pv = stretch(v);
  const double q = norm(p), gu = dot(p, pu) / q, gv = dot(p, pv) / q, r = shape.radius;
  return {(dot(pu, pu) - gu * gu) / q - r, (dot(pu, pv) - gu * gv) / q, (dot(pv, pv) - gv * gv) / q - r};
}

}  // namespace axode::convex
