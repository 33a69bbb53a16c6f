#pragma once
#include "axode/model/model.hpp"

namespace axode {

/// The mechanism on a floor: with a plane of the ground as one more collision shape, named `floor`, across
/// gravity at a height (m) above the inertial origin, or across z without gravity. Its friction is that of
/// the mechanism, see ContactDescription, which the mechanism has from now on, so that simulations count
/// contact. Throws std::invalid_argument if the height is not finite, or if the mechanism moves and no body
/// has a collision shape; ModelError if the mechanism cannot be built with the floor. Allocates.
Model with_floor(const Model& model, double height = 0);

}  // namespace axode
