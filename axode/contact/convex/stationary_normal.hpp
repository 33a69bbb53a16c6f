#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Evaluates the residual of a candidate: the distance of the point of its simplex from s n, with its normal
/// n and the width s of the gap along n. Reduces the residual to rounding by Newton's method on the branches
/// of the support functions on which the vertices of the simplex lie (D10.8, D10.9). The second derivative of
/// the support function of a rim is unbounded at the axis of the cylinder. Therefore the cap of a cylinder
/// that nearly faces the other body is treated in turn as a rim and as the polygon of the points that are
/// already found.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
