#pragma once
#include "axode/contact/pairs/point_list.hpp"
#include "axode/contact/pairs/supporting_feature.hpp"

namespace axode {

/// The supporting features of two convex bodies a and b, which are the faces or segments that face each other
/// along the unit vector n from a to b. The feature of a capsule is its axis, from which the surface is one
/// radius away.
template <class T> struct FacingFeatures {
  const Feature<T>&a, &b;
  Vec3<T> n;
  double radius_a = 0, radius_b = 0;  ///< radii of the balls, m
  double roundness = 0;               ///< sum of the radii of curvature across the segments of a and b, m
  double size = 0;                    ///< size of the bodies, by which rounding errors are judged, m
};

/// Clips the supporting feature (face or segment) of one body by that of the other, seen along the unit
/// vector n from the first body to the second one, and adds the corners of their common part as contact
/// points ((D10.12) of docs/derivations). The gap of a corner (m, negative if the bodies overlap) is the
/// distance of the two surfaces along n at this corner. Returns the least gap, or infinity if there is no
/// common part, if a face is almost parallel to n, or if a body has no feature.
template <class T> double clip(const FacingFeatures<T>& features, PointList<T>& out) noexcept;

}  // namespace axode
