#pragma once
#include <array>

#include "axode/constraints/loops/loop_frames.hpp"

namespace axode::loops {

/// The span of an inextensible belt between two pulleys that turn about parallel axes (D16.15). The first
/// frame has its z along the axes, and the origins of the two frames are the centres of the pulleys. The belt
/// constrains velocities but has no residual, because the number of turns of a pulley does not follow from
/// its pose.
struct Belt {
  std::array<double, 2> radii = {};  ///< radii of the pulleys with their signs, m; see Loop::radii

  static constexpr int rows() { return 1; }
  static constexpr int residuals() { return 0; }

  template <class T> void residual(const LoopFrames<T>&, T*) const {}
  template <class T> void wrenches(const LoopFrames<T>& at, SpatialWrench<T>* W) const {
    const Vec3<T>& z = at.a.R.z;
    const Vec3<T> d = at.b.r - at.a.r, across = d - dot(d, z) * z, turned = cross(z, across);
    const T difference = T(radii[1] - radii[0]), square = dot(across, across),
            span = sqrt(square - difference * difference);
    const Vec3<T> t = (T(1) / square) * (span * across - difference * turned);
    W[0] = force_at(at.b.r - T(radii[1]) * cross(z, t), t);
  }
};

}  // namespace axode::loops
