#include "axode/integration/exact/gap_course.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace axode {
namespace {

using Coefficients = std::array<double, 6>;

/// The polynomial of a gap over a step, in parts of the step: quintic, or cubic without second rates.
Coefficients course(const Gap& start, const Gap& end, double h) {
  const double D = end.g - start.g, v_0 = h * start.dg, v_1 = h * end.dg;
  const double a_0 = h * h * start.ddg, a_1 = h * h * end.ddg;
  if (!std::isfinite(a_0 + a_1)) return {start.g, v_0, 3 * D - 2 * v_0 - v_1, v_0 + v_1 - 2 * D, 0, 0};
  return {start.g,
          v_0,
          a_0 / 2,
          10 * D - 6 * v_0 - 4 * v_1 - (3 * a_0 - a_1) / 2,
          -15 * D + 8 * v_0 + 7 * v_1 + (3 * a_0 - 2 * a_1) / 2,
          6 * D - 3 * (v_0 + v_1) - (a_0 - a_1) / 2};
}

}  // namespace

GapClosure closure_of(const Gap& start, const Gap& end, double h, double resolution) {
  constexpr double never = std::numeric_limits<double>::infinity(), small = 1e-9;
  constexpr int samples = 48;
  const Coefficients c = course(start, end, h);
  const bool opens = start.g <= resolution;
  double largest = 0;
  for (const double x : c) largest = std::max(largest, std::abs(x));
  std::size_t first = 0;  // the lowest power that is not a rounding error
  if (opens) {
    first = 1;
    while (first < 3 && std::abs(c[first]) <= small * largest) ++first;
  }
  const auto value = [&](double s) {
    double sum = 0;
    for (std::size_t k = c.size(); k-- > first;) sum = sum * s + c[k];
    return sum;
  };
  // A gap that opens counts as closed only after it has been positive beyond rounding, or if it is negative
  // beyond rounding.
  double before = 0, last = value(0), last_but_one = last, least = opens ? -resolution : 0;
  for (int k = 1; k <= samples; ++k) {
    const double s = static_cast<double>(k) / samples, here = value(s);
    if (here < least) return {before, s};
    if (here > resolution) least = 0;
    // The least value between samples, by the parabola through three of them.
    const double bend = last_but_one - 2 * last + here;
    if (k > 1 && bend > 0 && last < last_but_one && last <= here) {
      const double at = s - (1 + 0.5 * (here - last_but_one) / bend) / samples;
      if (value(at) < least) return {before - 1.0 / samples, at};
    }
    last_but_one = last;
    last = here;
    before = s;
  }
  return {never, never};
}

}  // namespace axode
