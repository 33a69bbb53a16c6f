#pragma once
#include "axode/contact/pairs/point_list.hpp"
#include "axode/contact/pairs/supporting_feature.hpp"

namespace axode {

/// The supporting features of two bodies along the unit vector n from a to b, and the radii of the balls that
/// are added to their cores.
template <class T> struct FacingFeatures {
  const Feature<T>&a, &b;
  Vec3<T> n;
  double radius_a = 0, radius_b = 0;  ///< m
  double roundness = 0;               ///< sum of the radii of curvature across two segments, m
  double size = 0;                    ///< length with which rounding errors grow, m
};

/// Adds the corners of the part of the two features that lie beside each other, seen along n (D10.12). Each
/// corner has the gap of the two surfaces along n at its own place. Returns the least gap, infinity if the
/// features do not lie beside each other or have no corners.
template <class T> double clip(const FacingFeatures<T>& features, PointList<T>& out) noexcept;

}  // namespace axode
