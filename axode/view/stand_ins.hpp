#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode::view {

/// Placeholder shapes for bodies without a visible shape; entry i - 1 belongs to body i, and entries of other
/// bodies are computed as well. They are capsules from the joint of the body, or from its centre of mass if
/// the joint has no point, to the joints, frames and loops on the body. If there are none of these, the shape
/// is the solid ellipsoid with the mass and inertia of the body. Poses are in the body frames.
std::vector<std::vector<ShapeDescription>> stand_ins(const Model& model);

}  // namespace axode::view
