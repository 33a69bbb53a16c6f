#pragma once
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace axode {

/// Finds the time in a step from t_0 to t_1 at which the law of a drive must change its form, for example at
/// a limit. This is the time at which the least margin of the drives becomes negative, a number that each
/// drive computes; it is margin_0 ≥ 0 at t_0 and margin_1 < 0 at t_1. The search is by regula falsi
/// (Illinois) and bisection.
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

/// Finds the time in a step from t_0 to t_1 just after which one of several numbers first becomes negative,
/// by regula falsi (Illinois) and bisection. At least one of the numbers is negative at t_1. There may be
/// more numbers at t_1 than at t_0; numbers that exist only later are infinite or missing at t_0.
class ChangeSearch {
 public:
  using Numbers = std::vector<double>;

  ChangeSearch(double t_0, double t_1, double resolution, Numbers at_0, Numbers at_1)
      : resolution_(resolution), low_(t_0), high_(t_1), at_low_(std::move(at_0)), at_high_(std::move(at_1)) {}

  static bool changed(const Numbers& x) {
    return std::ranges::any_of(x, [](double number) { return number < 0; });
  }
  /// Whether another time is wanted, which is then t().
  bool continues() {
    if (!(high_ - low_ > resolution_)) return false;
    const auto first = static_cast<std::size_t>(std::ranges::min_element(at_high_) - at_high_.begin());
    const bool known = first < at_low_.size() && std::isfinite(at_low_[first]);
    const double f_low = known ? weight_low_ * std::max(at_low_[first], 0.0) : 0,
                 f_high = weight_high_ * at_high_[first];
    t_ = low_ + (high_ - low_) * (f_low > 0 ? f_low / (f_low - f_high) : 0.5);
    if (tries_++ % 8 == 7 || !(t_ > low_ && t_ < high_)) t_ = low_ + (high_ - low_) / 2;
    t_ = std::clamp(t_, low_ + 0.4 * resolution_, high_ - 0.4 * resolution_);
    return t_ > low_ && t_ < high_;  // otherwise no number lies in between
  }
  double t() const { return t_; }
  /// Takes the numbers at t(). Returns whether one of them is negative.
  bool take(const Numbers& found) {
    const bool after = changed(found);
    // Illinois: the end that stays counts half, so that both ends approach the change.
    (after ? high_ : low_) = t_;
    (after ? at_high_ : at_low_) = found;
    (after ? weight_high_ : weight_low_) = 1;
    (after ? weight_low_ : weight_high_) *= 0.5;
    return after;
  }
  /// The time just after the change, and the numbers there.
  double found() const { return high_; }
  const Numbers& numbers() const { return at_high_; }

 private:
  double resolution_, low_, high_, t_ = 0;
  Numbers at_low_, at_high_;
  double weight_low_ = 1, weight_high_ = 1;
  int tries_ = 0;
};

/// Limits for motions in which friction, drives or couplings with play (backlash) change too fast to be
/// followed. A step is short if it ended early and is shorter than short_part of the step that was attempted.
/// A motion ends after most_short_steps short steps in a row.
inline constexpr int most_short_steps = 1000;
inline constexpr double short_part = 1e-9;

}  // namespace axode
