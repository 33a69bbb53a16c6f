#include "axode/drives/drive_input.hpp"

#include <algorithm>
#include <limits>

#include "axode/constraints/prescribed/motion_function.hpp"

namespace axode {

DriveSignal::DriveSignal(const DriveInput& description)
    : times_(description.times), values_(description.values) {
  if (values_.size() == 1) times_.clear();
  if (values_.empty()) values_ = {0};
  if (!description.function) return;
  const MotionFunction function(*description.function);
  times_.assign(function.jumps().begin(), function.jumps().end());
  for (const double end : {function.begin(), function.end()})
    if (std::abs(end) < std::numeric_limits<double>::infinity()) times_.push_back(end);
  std::ranges::sort(times_);
  function_ = [function](double t) { return function(std::clamp(t, function.begin(), function.end())).s; };
}

void DriveSignal::begin(double t) {
  if (function_ || times_.empty()) return;
  const auto after = std::ranges::upper_bound(times_, t) - times_.begin();
  interval_ = after == 0 ? 0 : static_cast<std::size_t>(after - 1);
}

double DriveSignal::next_jump(double t) const {
  const auto next = std::ranges::upper_bound(times_, t);
  return next == times_.end() ? std::numeric_limits<double>::infinity() : *next;
}

}  // namespace axode
