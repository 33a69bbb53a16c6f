#pragma once
#include <string>

#include "axode/constraints/prescribed/motion_rows.hpp"

namespace axode {

/// Explains a singularity near q of the equations of loops and prescribed motions at time t. The returned
/// sentence names the motions whose forces grow without bound, and the joints that could move while all
/// motions stand still (D12.6). It is empty if no singularity is near, or if the loops alone are singular.
/// Allocates; O(nv³).
std::string nearby_singularity(MotionRows& motions, LoopSystem<double>& system, std::span<const double> q,
                               double t);

}  // namespace axode
