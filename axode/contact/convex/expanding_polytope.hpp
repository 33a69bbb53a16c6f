#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Searches for a unit normal along which two cores (convex bodies without the balls that round them) overlap
/// less than along the normal of candidate c. The method is a polytope that expands inside the difference of
/// the cores A and B, the set of all b - a with points a of A and b of B (D10.10). If there is such a normal,
/// c becomes a candidate with the best one and the width of the gap along it, which is minus the overlap, but
/// without points b - a; the caller has to find those that belong to this normal. Returns a proved lower
/// bound of the overlap of the cores, m, or 0 if their difference is flat. For curved cores (cylinders,
/// ellipsoids) the bound does not hold for normals within 0.0045 rad of the normal of c, and the search ends
/// when the bound differs from the overlap along the best normal by at most 1e-5 of this overlap.
double expand(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
