#pragma once
#include <optional>

#include "axode/model/description.hpp"

/// Functions that compute the force laws of springs from their descriptions.
namespace axode {

/// The force law of a spring without faults (D16.3). With a preload, its length or angle of rest is still 0.
ForceLaw force_law(const SpringDescription& spring);

/// A deflection at which a force law has the given force (D16.4); empty if none is found. It is searched on
/// both sides of 0 in steps of size/256 up to `size`, a typical deflection (m or rad), then in steps 16, 256,
/// ... times as long. Of several solutions it is the one nearest to 0, unless one step contains two of them.
std::optional<double> deflection_at(const ForceLaw& law, double force, double size);

}  // namespace axode
