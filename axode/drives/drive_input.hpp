#pragma once
#include <functional>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The input u of a drive as a function of time t (s): a continuous function, or steps, which are constant
/// from one given time to the next. In the case of steps, operator() returns the value in the interval that
/// contains the time of the last begin(), for any t. A step of an integration that ends where the input jumps
/// therefore does not see the value after the jump.
class DriveSignal {
 public:
  /// Constructs the input that is always 0.
  DriveSignal() : values_{0} {}
  /// Constructs the input from a description, which must have been checked and contains a function of time or
  /// steps. Before the first and after the last time of the description, the input has its value at that
  /// time.
  explicit DriveSignal(const DriveInput& description);
  /// Constructs the input from a continuous function of the time t (s).
  explicit DriveSignal(std::function<double(double t)> function) : function_(std::move(function)) {}

  void begin(double t);
  double operator()(double t) const { return function_ ? function_(t) : values_[interval_]; }
  /// The first time after t at which the input or one of its derivatives jumps, so that a step of an
  /// integration should end there; infinite if there is none.
  double next_jump(double t) const;

 private:
  std::function<double(double t)> function_;
  std::vector<double> times_, values_;
  std::size_t interval_ = 0;
};

}  // namespace axode
