#pragma once
#include "axode/model/description.hpp"

namespace axode::io {

/// Returns the description of the same mechanism with axes, points, centres of mass, inertias and named
/// frames in the construction frame. Numbers that are already given in the construction frame do not change.
/// Rounding noise around 0 and ±1 is removed from poses and from numbers that had to be transformed.
///
/// Loops do not change, because they are drawn in the construction frame or are described relative to bodies
/// and named frames.
///
/// For a planar or spherical joint, a fixed rule gives the axes of the joint frame in the construction frame.
/// If the axes of the given joint frame are rotated relative to them, the coordinates of the joint would
/// change their meaning. In this case the joint keeps its joint frames, and the inertia of its body is not
/// rewritten.
Description in_construction_frame(const Description& description);

}  // namespace axode::io
