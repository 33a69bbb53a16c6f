#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Searches for a normal along which two cores overlap less than along the normal of candidate c, by a
/// polytope that expands inside the difference B - A of the cores (D10.10). If there is such a normal, c
/// receives the best one and the width of the gap along it, with an empty simplex. Returns a proved lower
/// bound of the overlap of the cores, m; 0 if the difference is flat. For curved cores (cylinders,
/// ellipsoids) normals within 0.0045 rad of that of c are left out of the bound, and the search ends when the
/// bound is within 1e-5 of the overlap.
double expand(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
