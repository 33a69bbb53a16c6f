#pragma once
#include <algorithm>

namespace axode {

/// Finds the time in a step from t_0 to t_1 at which the least margin of the drives becomes negative, by
/// regula falsi (Illinois) and bisection. The margin is margin_0 ≥ 0 at t_0 and margin_1 < 0 at t_1.
class SwitchSearch {
 public:
  SwitchSearch(double t_0, double t_1, double margin_0, double margin_1)
      : resolution_(std::max(1e-13 * (t_1 - t_0), 1e-15 * t_1)),
        low_(t_0),
        high_(t_1),
        f_low_(margin_0),
        f_high_(margin_1),
        t_(t_1) {}

  bool continues() const { return high_ - low_ > resolution_; }
  /// The next time at which the margin is wanted.
  double next() {
    const double guess = low_ + (high_ - low_) * (f_low_ / (f_low_ - f_high_));
    t_ = ++tries_ % 4 == 0 ? low_ + (high_ - low_) / 2
                           : std::clamp(guess, low_ + 0.5 * resolution_, high_ - 0.5 * resolution_);
    return t_;
  }
  /// Takes the margin at the time next(). Returns whether it is negative.
  bool take(double margin) {
    const bool after = margin < 0;
    (after ? high_ : low_) = t_;
    (after ? f_high_ : f_low_) = margin;
    (after ? f_low_ : f_high_) *= 0.5;
    return after;
  }
  /// The time just after the change of sign.
  double found() const { return high_; }
  /// Whether found() was the last time that next() returned, or t_1 before its first call.
  bool found_last() const { return t_ == high_; }

 private:
  double resolution_, low_, high_, f_low_, f_high_, t_;
  int tries_ = 0;
};

/// A motion ends after most_short_steps consecutive steps that end early and are shorter than short_part of
/// what was attempted: friction, drives or plays then change too fast to be followed.
inline constexpr int most_short_steps = 1000;
inline constexpr double short_part = 1e-9;

}  // namespace axode
