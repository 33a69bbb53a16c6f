#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Searches for a unit normal along which two cores A and B (convex bodies without the balls that round them)
/// overlap less than along the normal of the candidate c. The method is a polytope that expands inside the
/// difference of the cores, the set of all b - a with points a of A and b of B (D10.10). If there is such a
/// normal, c receives the best one and the width of the gap along it, which is minus the overlap, but no
/// points b - a. Returns a lower bound of the overlap of the cores (m), or 0 if their difference is flat. If
/// a core is a cylinder or an ellipsoid, the bound does not account for normals within 0.0045 rad of the
/// normal of c.
double expand(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
