#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// What stands for each moving body, at number i - 1, that has nothing to be seen: capsules from its joint, or its centre
/// of mass where the joint has no place, to the joints, frames and loops that it carries; where it carries none, the solid
/// ellipsoid of its mass and inertia. Poses are in the body frames.
std::vector<std::vector<ShapeDescription>> stand_ins(const Model& model);

}  // namespace axode::view
