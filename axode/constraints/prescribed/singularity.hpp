#pragma once
#include <string>

#include "axode/constraints/prescribed/motion_rows.hpp"

namespace axode {

/// Returns a sentence about a singularity, near q, of the equations of loops and prescribed motions together
/// at time t: the motions whose forces grow without bound, and the joints that could move without them
/// (D12.6). It is empty if no singularity is near, or if it is one of the loops alone. Allocates; O(nv³).
std::string nearby_singularity(MotionRows& motions, LoopSystem<double>& system, std::span<const double> q,
                               double t);

}  // namespace axode
