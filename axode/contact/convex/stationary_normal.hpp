#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Improves a candidate for the distance of two cores (convex bodies without the balls that round them). A
/// candidate is a unit normal n, the width s of the gap between the cores along n, and a simplex of up to
/// four weighted points b - a, with points a and b of the two cores. The residual of the candidate is the
/// distance of the weighted mean of these points from s n. Newton's method reduces it to rounding; it keeps
/// the smooth parts (branches) of the cores' support functions on which the vertices of the simplex lie
/// (D10.8, D10.9). The second derivative of the support function of a cylinder is unbounded if n is parallel
/// to its axis. If the angle between them is less than 0.1 rad, the method therefore alternates between two
/// models of the cylinder: the polytope of its points in the simplex, which do not move, and the cylinder
/// itself.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
