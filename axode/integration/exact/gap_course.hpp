#pragma once
#include "axode/integration/exact/contact_phase.hpp"

namespace axode {

/// The time at which a gap closes in a step, as a part of the step. The gap is negative at `after` and not
/// negative at `before`. Both are infinite if the gap does not close.
struct GapClosure {
  double before, after;
};

/// Finds whether a gap closes in a step of length h (s) from its values and rates at both ends of the step,
/// by the polynomial with these values. A gap of at most `resolution` at the start that opens, after a bounce
/// or because its contact became open, closes only when it has been positive (D11.33).
GapClosure closure_of(const Gap& start, const Gap& end, double h, double resolution);

}  // namespace axode
