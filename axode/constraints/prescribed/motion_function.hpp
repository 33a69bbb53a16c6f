#pragma once
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The value of a motion and its time derivatives: rad or m, and these per s, s² and s³.
struct MotionValue {
  double s = 0, ds = 0, dds = 0;
  double ddds = 0;  ///< used by kinematic_motion() alone
};

/// A function of time that a joint or the length of a rod follows.
class MotionFunction {
 public:
  using Function = std::function<MotionValue(double t)>;

  /// The function of a description without faults, see MotionDescription.
  explicit MotionFunction(const MotionDescription& description);
  /// A function with its exact derivatives. `jumps` are the times at which its third, fourth or fifth
  /// derivative jumps; the first two must be continuous.
  explicit MotionFunction(Function function, std::vector<double> jumps = {})
      : function_(std::move(function)), jumps_(std::move(jumps)) {}

  MotionValue operator()(double t) const { return function_(t); }
  /// Times at which steps of an integration should end.
  std::span<const double> jumps() const { return jumps_; }
  /// The first and the last time at which the function is known.
  double begin() const { return begin_; }
  double end() const { return end_; }

 private:
  Function function_;
  std::vector<double> jumps_;
  double begin_ = -std::numeric_limits<double>::infinity(), end_ = std::numeric_limits<double>::infinity();
};

}  // namespace axode
