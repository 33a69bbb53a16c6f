#pragma once
#include "axode/model/description.hpp"

namespace axode::io {

/// Returns the description of the same mechanism with axes, points, centres of mass, inertias and named
/// frames in the construction frame: the inertial frame, in which the mechanism is drawn at q = 0. Numbers
/// that are already given in the construction frame do not change. Rounding noise around 0 and ±1 is removed
/// from poses and from numbers that had to be transformed.
///
/// Loops do not change: they are given in the construction frame already, or relative to bodies and named
/// frames.
///
/// If a planar or spherical joint is given in the construction frame, a fixed rule determines the axes of its
/// joint frame. If the present joint frame has other axes, the coordinates of the joint would change their
/// meaning. In this case the joint keeps its joint frames, and the inertia of its body does not change.
Description in_construction_frame(const Description& description);

}  // namespace axode::io
