#pragma once
#include "axode/model/model.hpp"

namespace axode {

/// Returns a copy of a model with one more collision shape on the ground: a plane named `floor`. The plane is
/// perpendicular to gravity, or to the z-axis if there is no gravity, and lies `height` (m) above the
/// inertial origin. Its coefficient of friction is that of the mechanism. If the model has no
/// ContactDescription, a default one is added, so that simulations count contact. Throws
/// std::invalid_argument if the height is not finite, or if the mechanism can move and no body has a
/// collision shape. Throws ModelError if the model cannot be built with the floor. Allocates.
Model with_floor(const Model& model, double height = 0);

}  // namespace axode
