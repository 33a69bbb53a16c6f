#pragma once
#include <functional>
#include <vector>

#include "axode/model/description.hpp"

namespace axode {

/// The input u of a drive as a function of time t (s), which is continuous or piecewise constant. begin() is
/// called at the start of a step. Until its next call, a piecewise constant input keeps the value just after
/// this time at all t, so that a step that ends at a jump does not see the value after the jump.
class DriveSignal {
 public:
  /// Constructs the input that is always 0.
  DriveSignal() : values_{0} {}
  /// Constructs the input from its checked description. Before the first and after the last time of the
  /// description, the input is constant.
  explicit DriveSignal(const DriveInput& description);
  /// Constructs the input from a continuous function of the time t (s).
  explicit DriveSignal(std::function<double(double t)> function) : function_(std::move(function)) {}

  void begin(double t);
  double operator()(double t) const { return function_ ? function_(t) : values_[interval_]; }
  /// The first time after t at which the input or one of its derivatives jumps; infinite if there is none.
  double next_jump(double t) const;
  /// The number of the present interval of a piecewise constant input.
  std::size_t interval() const { return interval_; }
  void set_interval(std::size_t interval) { interval_ = interval; }

 private:
  std::function<double(double t)> function_;
  std::vector<double> times_, values_;
  std::size_t interval_ = 0;
};

}  // namespace axode
