#pragma once
#include "axode/model/description.hpp"

namespace axode::io {

/// Rewrites a description so that axes, points, centres of mass, inertias and frames are in the construction
/// frame; the mechanism stays the same. Numbers that are given in the construction frame already do not
/// change. Rounding noise around 0 and ±1 is removed from poses and from numbers that had to be transformed.
///
/// Loops do not change: they are drawn in the construction frame, or have frames relative to frames that do
/// not move.
///
/// If the frame of a planar or spherical joint is rotated relative to the one that follows from the
/// construction frame, the joint keeps its joint frames and its body its inertia, because otherwise its
/// coordinates would change their meaning.
Description in_construction_frame(const Description& description);

}  // namespace axode::io
