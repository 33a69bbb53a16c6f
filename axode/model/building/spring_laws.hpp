#pragma once
#include <optional>

#include "axode/model/description.hpp"

/// Functions that compute the force laws of springs from their descriptions.
namespace axode {

/// The force law of a spring without faults: its curve and, for a table, the slopes and energies at the
/// points (D16.3). If the spring has a preload, its length or angle of rest is still unknown and set to 0.
ForceLaw force_law(const SpringDescription& spring);

/// A deflection at which the curve of a force law has the given force (D16.4); empty if none is found where
/// the spring acts. The deflection of a linear curve follows directly. For other curves it is searched on
/// both sides of 0 in steps of size/256 up to `size`, a typical deflection (m or rad), then in steps that are
/// 16, 256, ... times as long, and refined to rounding. Of several solutions it is the one nearest to 0,
/// unless one step contains two of them.
std::optional<double> deflection_at(const ForceLaw& law, double force, double size);

}  // namespace axode
