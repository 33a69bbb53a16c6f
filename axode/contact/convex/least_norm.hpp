#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Finds the point of least norm of the difference B - A of the cores, shifted by `shift`, by Wolfe's
/// algorithm (D10.5, D10.6). It starts from the simplex of c or, if this is empty, from the normal c.n. It
/// ends when the duality gap is at most `gap` (m), when rounding prevents progress, or when the simplex
/// contains the origin. Sets the normal n, the bound s, the simplex and `inside` of c.
void least_norm(CorePair& pair, Candidate& c, const Vec3<>& shift, double gap) noexcept;

}  // namespace axode::convex
