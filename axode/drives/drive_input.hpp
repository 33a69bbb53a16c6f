#pragma once
#include <functional>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The input of a drive as a function of time, which may jump. At a jump it has the value of the interval in
/// which begin() was called last, so that a step which ends at a jump does not see the value after it.
class DriveSignal {
 public:
  /// The input 0.
  DriveSignal() : values_{0} {}
  /// The function or the steps of a description without faults. Samples keep their first value before and
  /// their last value after them.
  explicit DriveSignal(const DriveInput& description);
  /// A continuous function.
  explicit DriveSignal(std::function<double(double t)> function) : function_(std::move(function)) {}

  void begin(double t);
  double operator()(double t) const { return function_ ? function_(t) : values_[interval_]; }
  /// The first time after t at which a step of an integration should end; infinite if there is none.
  double next_jump(double t) const;

 private:
  std::function<double(double t)> function_;
  std::vector<double> times_, values_;
  std::size_t interval_ = 0;
};

}  // namespace axode
