#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Searches for a normal with less overlap than c by a polytope that expands inside the difference of the
/// cores (D10.10); c receives the best normal and its bound, with an empty simplex, if there is one. Returns
/// a sure lower bound of the overlap of the cores, m. For curved cores the bound leaves out a cap of 0.0045
/// rad about the normal, and ends within 1e-5 of the overlap.
double expand(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
