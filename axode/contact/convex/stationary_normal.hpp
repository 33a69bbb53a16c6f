#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Computes the residual of a candidate: the distance of the point of its simplex from s n, with its normal n
/// and the width s of the gap along n. Newton's method then reduces the residual to rounding; it keeps the
/// smooth parts (branches) of the bodies' support functions on which the vertices of the simplex lie (D10.8,
/// D10.9). The rim of a cylinder has a support function whose second derivative is unbounded at the axis of
/// the cylinder. Therefore a cap that nearly faces the other body is treated in turn as a rim and as the
/// polygon of those of its points that have been found.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
