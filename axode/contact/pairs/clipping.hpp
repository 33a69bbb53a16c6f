#pragma once
#include "axode/contact/pairs/point_list.hpp"
#include "axode/contact/pairs/supporting_feature.hpp"

namespace axode {

/// The supporting features of two convex bodies a and b, which are the faces or segments that face each other
/// along the unit vector n from a to b, and the radii of the balls that round the bodies.
template <class T> struct FacingFeatures {
  const Feature<T>&a, &b;
  Vec3<T> n;
  double radius_a = 0, radius_b = 0;  ///< radii of the balls, m
  double roundness = 0;               ///< sum of the radii of curvature across the segments of a and b, m
  double size = 0;                    ///< size of the bodies, by which rounding errors are judged, m
};

/// Clips the supporting feature (face or segment) of one body by that of the other, seen along n, and adds
/// the corners of the part in which both lie (D10.12) as contact points. The gap of each corner is the
/// distance of the two surfaces along n at this corner. Returns the least gap. Returns infinity if the
/// features do not overlap when seen along n, if two segments do not run side by side, or if a body has no
/// feature.
template <class T> double clip(const FacingFeatures<T>& features, PointList<T>& out) noexcept;

}  // namespace axode
