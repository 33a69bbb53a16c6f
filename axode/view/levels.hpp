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

/// Computes the level of each body of a planar mechanism: the number of the layer along the normal of the
/// plane in which the body is drawn. The result is empty for other mechanisms. A mechanism is planar if its
/// loop joints are hinges, its joints are hinges or sliders with at least one hinge in all, the axes of the
/// hinges are normal to one plane, their points (the origins of the joint frames) are in this plane to within
/// `close` (m), and the sliders move along it. Hinges whose points are nearer to each other than `close`
/// count as hinges at one point. Of the two normals of the plane, the one on the side of the direction `up`
/// is taken.
std::optional<Levels> levels_of(const Model& model, double close, const Vec3<>& up);

}  // namespace axode::view
