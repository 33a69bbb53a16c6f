#pragma once
#include "axode/model/model.hpp"

namespace axode {

/// Returns a copy of a model with one more collision shape on the ground, a plane named `floor`. The plane is
/// perpendicular to gravity (to the z-axis if there is no gravity), and lies `height` (m) above the inertial
/// origin. It has the coefficient of friction of the mechanism's contact settings; a model without such
/// settings gets the default ones, so that it is simulated with contact. Allocates. Throws
/// std::invalid_argument if the height is not finite, or if the mechanism can move and no body has a
/// collision shape, and ModelError if the model cannot be built with the floor.
Model with_floor(const Model& model, double height = 0);

}  // namespace axode
