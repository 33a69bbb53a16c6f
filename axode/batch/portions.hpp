#pragma once
#include <chrono>
#include <cstddef>
#include <functional>

#include "axode/batch.hpp"

/// Work on many states that is spread over cores, told about and ended early.
namespace axode::batch {

/// Tells a monitor how far a call is, now and then, and learns whether to go on. For the thread of the call.
class MonitorThrottle {
 public:
  MonitorThrottle(const Monitor& monitor, std::size_t of) : monitor_(monitor), of_(of) {}
  bool should_continue(std::size_t done);

 private:
  using Clock = std::chrono::steady_clock;
  const Monitor& monitor_;
  std::size_t of_;
  int calls_ = 0, calls_between_checks_ = 1;  ///< at the clock, which costs more than some states
  Clock::time_point last_check_ = Clock::now(), last_call_ = last_check_;
};

/// Work on a group of states: the first of them, and how many.
using Work = std::function<void(std::size_t first, std::size_t count)>;

/// Does work on every group of `group` out of N states, the last group with fewer states. As many tasks as
/// there are cores to use, each with work of its own, take the groups in portions. They run wherever the
/// caller's tasks would, where the threads are awake. Ends early, after the groups at hand, where the monitor
/// says so. Returns how many states are done, from the first on; of those behind them some may be done as
/// well.
std::size_t in_portions(std::size_t N, std::size_t group, int threads, const Monitor& monitor,
                        const std::function<Work()>& make_work);

}  // namespace axode::batch
