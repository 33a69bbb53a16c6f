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

/// Computes the level of each body of a planar mechanism, an integer that says in which layer along the
/// normal of the plane the body is drawn. The result is empty for other mechanisms. In a planar mechanism all
/// joints and loop joints are hinges, and joints may also be sliders. The axes of all hinges are normal to
/// one plane, their points (the origins of the joint frames) are at most `close` (m) away from it, and
/// sliders move along it. Hinges whose points are nearer to each other than `close` count as hinges at one
/// point. Of the two normals of the plane, the one on the side of `up` is taken.
std::optional<Levels> levels_of(const Model& model, double close, const Vec3<>& up);

}  // namespace axode::view
