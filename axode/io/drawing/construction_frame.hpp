#pragma once
#include "axode/model/description.hpp"

namespace axode::io {

/// Returns the description of the same mechanism with axes, points, centres of mass, inertias and named
/// frames in the construction frame: the inertial frame, in which the mechanism is drawn at q = 0. Rounding
/// noise around 0 and ±1 is removed from poses and from numbers that had to be transformed.
///
/// Exception: if axis and point in the construction frame would give a planar or spherical joint other joint
/// frames, and its coordinates another meaning, the joint is described by its joint frames and the inertia of
/// its body is kept.
Description in_construction_frame(const Description& description);

}  // namespace axode::io
