#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Finds the point of least norm of the difference B - A of two convex sets (all b - a with points a of A and
/// b of B), shifted by the vector `shift`, by Wolfe's algorithm (D10.5, D10.6). It starts from the simplex of
/// the candidate c (a simplex of such points, a normal and the width of the gap along it) or, if this is
/// empty, from its normal. It ends when the duality gap is at most `gap` (m), when rounding prevents
/// progress, or when the simplex contains the origin. Sets the normal of c, the width of the gap along it,
/// the simplex, and `inside`, which says whether the simplex contains the origin.
void least_norm(CorePair& pair, Candidate& c, const Vec3<>& shift, double gap) noexcept;

}  // namespace axode::convex
