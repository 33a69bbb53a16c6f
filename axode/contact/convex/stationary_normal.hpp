#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Evaluates the residual of candidate c, the distance of the point of its simplex from s n, and reduces it
/// to rounding by Newton's method on the active branches of the support functions (D10.8, D10.9). The second
/// derivative of the support function of a rim is unbounded at the axis of the cylinder. Therefore the cap of
/// a cylinder that nearly faces the other body is treated in turn as a rim and as the polygon of the points
/// that are already found.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
