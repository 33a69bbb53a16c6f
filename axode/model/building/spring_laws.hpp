#pragma once
#include <optional>

#include "axode/model/description.hpp"

/// Functions that compute the force laws of springs from their descriptions.
namespace axode {

/// The force law of a spring without faults (D16.3). With a preload, its length or angle of rest is still 0.
ForceLaw force_law(const SpringDescription& spring);

/// Finds a deflection at which a force law has the given force (D16.4); empty if none is found. The search
/// begins at 0 and goes in both directions: in steps of size/256 up to `size`, a typical deflection (m or
/// rad), then in steps that are 16, 256, ... times as long. Of several solutions the one nearest to 0 is
/// found, unless one step contains two of them.
std::optional<double> deflection_at(const ForceLaw& law, double force, double size);

}  // namespace axode
