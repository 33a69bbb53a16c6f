#pragma once
#include <optional>
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// The levels at which the bodies of a planar mechanism are drawn, so that none runs through another one.
struct Levels {
  std::vector<int> of;  ///< level of the ground, 0, and of each body; bodies that meet have different ones
  Vec3<> normal;        ///< normal of the plane in the inertial frame, from level 0 to level 1
};

/// Computes the levels of the bodies, integers that say in which layer along the normal of the plane each
/// body is drawn, if all bodies move in one plane, on hinges with points in that plane and on sliders; empty
/// for other mechanisms. Points nearer to each other than `close` (m) coincide. Of the two normals of the
/// plane, the one on the side of `up` is taken.
std::optional<Levels> levels_of(const Model& model, double close, const Vec3<>& up);

}  // namespace axode::view
