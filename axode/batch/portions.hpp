#pragma once
#include <chrono>
#include <cstddef>
#include <functional>

#include "axode/batch.hpp"

/// Spreads work on many states over cores, and reports progress to a monitor that may end it early.
namespace axode::batch {

/// Calls a monitor at most every 20 ms. Only the calling thread may use it.
class MonitorThrottle {
 public:
  MonitorThrottle(const Monitor& monitor, std::size_t of) : monitor_(monitor), of_(of) {}
  bool should_continue(std::size_t done);

 private:
  using Clock = std::chrono::steady_clock;
  const Monitor& monitor_;
  std::size_t of_;
  int calls_ = 0, calls_between_checks_ = 1;  ///< calls since the last check of the clock, and calls between
                                              ///< two checks; a check costs more than some states
  Clock::time_point last_check_ = Clock::now(), last_call_ = last_check_;
};

/// A function that processes `count` states, beginning with state `first`.
using Work = std::function<void(std::size_t first, std::size_t count)>;

/// Processes N states on several cores, in groups of `group` consecutive states; the last group may be
/// smaller. At most `threads` tasks run in parallel. Each task calls make_work() once for a function of its
/// own, and calls this function for one group after the other. The monitor is called in the calling thread
/// with the approximate number of states that are done and N. If it returns false, groups that have not begun
/// are left out. Returns a number n such that the first n states are done; later states may or may not be
/// done.
std::size_t in_portions(std::size_t N, std::size_t group, int threads, const Monitor& monitor,
                        const std::function<Work()>& make_work);

}  // namespace axode::batch
