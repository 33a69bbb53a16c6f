#pragma once
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The value s of a prescribed motion and its time derivatives s', s'' and s''', in rad or m, and in these
/// units per s, s² and s³.
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
  /// Makes a motion from a function that returns the value with its exact derivatives. `jumps` are the times
  /// at which its third, fourth or fifth derivative jumps; the first two derivatives must be continuous.
  explicit MotionFunction(Function function, std::vector<double> jumps = {})
      : function_(std::move(function)), jumps_(std::move(jumps)) {}

  MotionValue operator()(double t) const { return function_(t); }
  /// The times at which steps of an integration should end, because a derivative of the function jumps.
  std::span<const double> jumps() const { return jumps_; }
  /// begin() and end() are the first and the last time at which the function is known; -infinity and infinity
  /// if it is known at all times.
  double begin() const { return begin_; }
  double end() const { return end_; }

 private:
  Function function_;
  std::vector<double> jumps_;
  double begin_ = -std::numeric_limits<double>::infinity(), end_ = std::numeric_limits<double>::infinity();
};

}  // namespace axode
