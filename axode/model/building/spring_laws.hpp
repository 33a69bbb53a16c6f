#pragma once
#include <optional>

#include "axode/model/description.hpp"

/// Force laws of springs, from their descriptions.
namespace axode {

/// The force law of a spring that is described without faults: its curve, with the slopes of a table (D16.3).
/// If it has a preload instead of a rest, the rest is 0.
ForceLaw force_law(const SpringDescription& spring);

/// The deflection at which the curve of a law has a force (D16.4), the one nearest to 0 as far as steps of a
/// part of `size` show it. Nothing if no deflection at which the spring acts has this force.
std::optional<double> deflection_at(const ForceLaw& law, double force, double size);

}  // namespace axode
