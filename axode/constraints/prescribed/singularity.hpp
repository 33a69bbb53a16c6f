#pragma once
#include <string>

#include "axode/constraints/prescribed/motion_rows.hpp"

namespace axode {

/// A sentence about the singularity of the rows of loops and motions that is near a configuration: the
/// motions whose forces grow without bound, and the joints that would move without them, see (D12.6) of
/// docs/derivations. Empty if no singularity is near, or if it is one of the loops alone. `t` is the time of
/// the motions. Allocates; O(nv³).
std::string nearby_singularity(MotionRows& motions, LoopSystem<double>& system, std::span<const double> q,
                               double t);

}  // namespace axode
