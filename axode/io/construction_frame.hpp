#pragma once
#include "axode/model/description.hpp"

namespace axode::io {

/// The same mechanism with axes, points, centres of mass, inertias and frames in the construction frame. What
/// is given there already keeps its numbers; poses and what had to be moved lose rounding noise around 0 and
/// ±1.
///
/// Loops keep what they are told: they are drawn there, or have frames in frames that stay where they are.
///
/// A planar or spherical joint whose frame is turned against the one that the construction frame gives it
/// keeps its joint frames, and its body its inertia, for its coordinates would else change their meaning.
Description in_construction_frame(const Description& description);

}  // namespace axode::io
