#pragma once
#include "axode/contact/convex/core_pair.hpp"

namespace axode::convex {

/// Evaluates the residual of c and closes it by Newton's method on the active branches of the support
/// functions (D10.8, D10.9). A cap of a cylinder that nearly faces the other body is treated in turn as a rim
/// and as the polygon of the points that are already found, because the second derivative of the support
/// function of a rim is unbounded at its axis.
void close_residual(CorePair& pair, Candidate& c) noexcept;

}  // namespace axode::convex
