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

/// Computes the levels of the bodies if all of them move in one plane, on hinges and sliders whose points lie
/// in that plane; empty for other mechanisms. Points nearer to each other than `close` (m) coincide. `up`
/// chooses the sense of the normal.
std::optional<Levels> levels_of(const Model& model, double close, const Vec3<>& up);

}  // namespace axode::view
