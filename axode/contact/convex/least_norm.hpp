#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// The point of least norm of the difference of the cores, shifted by `shift`, by Wolfe's algorithm (D10.5,
/// D10.6). It starts from the simplex of c, or from c.n if that is empty, and ends when the duality gap is
/// below `gap` (m), when rounding prevents progress, or when the simplex contains the origin. Sets n, s, the
/// simplex and `inside` of c.
void least_norm(CorePair& pair, Candidate& c, const Vec3<>& shift, double gap) noexcept;

}  // namespace axode::convex
