#pragma once
#include <algorithm>
#include <chrono>
#include <functional>
#include <vector>

namespace axode::command {

/// Measures the time of a call: the median over batches of calls that are long enough for the clock.
class CallTimer {
 public:
  /// run(n) must call the function n times.
  explicit CallTimer(std::function<void(int)> run) : run_(std::move(run)) {
    run_(1);
    calls_ = std::clamp(static_cast<int>(50e-6 / std::max(seconds(10), 1e-9)), 1, 100000);
  }
  void sample(int batches) {
    for (int k = 0; k < batches; ++k) times_.push_back(seconds(calls_));
  }
  /// The median of all samples so far: the time of one call in seconds.
  double median() {
    const auto middle = times_.begin() + std::ssize(times_) / 2;
    std::nth_element(times_.begin(), middle, times_.end());
    return *middle;
  }

 private:
  double seconds(int calls) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    run_(calls);
    return std::chrono::duration<double>(Clock::now() - start).count() / calls;
  }

  std::function<void(int)> run_;
  int calls_ = 1;
  std::vector<double> times_;
};

}  // namespace axode::command
