#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Improves a candidate for the distance of two cores (convex bodies without the balls that round them). A
/// candidate is a unit normal n, the width s of the gap between the cores along n, and a simplex of up to
/// four points b - a, with points a and b of the two cores. The residual of the candidate is the distance
/// of the weighted sum of these points from s n. Newton's method reduces it to rounding; it keeps the
/// smooth parts (branches) of the cores' support functions on which the vertices of the simplex lie
/// (D10.8, D10.9). The rim of a cylinder has a support function whose second derivative is unbounded at
/// the axis of the cylinder. Therefore a cap that nearly faces the other body is replaced in turn by its
/// rim and by the polygon of its points in the simplex.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
