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

/// Processes N states in groups of `group` states; the last group may be smaller. Each core that is used runs
/// one task. A task has a Work of its own, made by make_work(), and takes portions of the groups, one after
/// the other. If the monitor, the caller's function that can end a long call, returns false, the call ends
/// after the current groups. Returns a number n such that the first n states are done; some later states may
/// be done as well.
std::size_t in_portions(std::size_t N, std::size_t group, int threads, const Monitor& monitor,
                        const std::function<Work()>& make_work);

}  // namespace axode::batch
