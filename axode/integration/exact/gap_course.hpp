#pragma once
#include "axode/integration/exact/contact_phase.hpp"

namespace axode {

/// The two times between which a gap becomes negative in a step, as fractions of the length of the step: the
/// gap is not negative at `before`, and negative at `after`. Both are infinite if the gap does not close.
struct GapClosure {
  double before, after;
};

/// Finds when a gap first becomes negative in a step of length h (s). The gap is taken as the polynomial in
/// time that has its values and rates at both ends of the step. If the gap is at most `resolution` at the
/// start, its value there counts as 0: a gap that then opens, after a bounce or because its contact has just
/// opened, closes only after it has been larger than `resolution`, or where it is less than -`resolution`
/// (D11.33).
GapClosure closure_of(const Gap& start, const Gap& end, double h, double resolution);

}  // namespace axode
