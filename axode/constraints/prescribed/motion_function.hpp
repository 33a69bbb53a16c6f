#pragma once
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The value of a prescribed motion and its first three time derivatives, in rad or m and per s, s² and s³.
struct MotionValue {
  double s = 0, ds = 0, dds = 0;
  double ddds = 0;  ///< s'''; used by kinematic_motion() alone
};

/// A function of time that a joint or the length of a rod follows.
class MotionFunction {
 public:
  using Function = std::function<MotionValue(double t)>;

  /// Makes the function of a description that has been checked, see MotionDescription.
  explicit MotionFunction(const MotionDescription& description);
  /// Makes a motion from a function that returns the value with its exact derivatives, the first two of which
  /// must be continuous. `jumps` are the times at which the third, fourth or fifth derivative jumps.
  explicit MotionFunction(Function function, std::vector<double> jumps = {})
      : function_(std::move(function)), jumps_(std::move(jumps)) {}

  MotionValue operator()(double t) const { return function_(t); }
  /// The times at which steps of an integration should end, because a derivative of the function jumps.
  std::span<const double> jumps() const { return jumps_; }
  /// The first and the last time at which the function is known, which may be -infinity and infinity.
  double begin() const { return begin_; }
  double end() const { return end_; }

 private:
  Function function_;
  std::vector<double> jumps_;
  double begin_ = -std::numeric_limits<double>::infinity(), end_ = std::numeric_limits<double>::infinity();
};

}  // namespace axode
