#include "axode/batch/portions.hpp"

#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace axode::batch {

bool MonitorThrottle::should_continue(std::size_t done) {
  if (!monitor_ || ++calls_ < calls_between_checks_) return true;
  const Clock::time_point now = Clock::now();
  const bool soon = now - last_check_ < std::chrono::milliseconds(2);
  calls_between_checks_ =
      soon ? std::min(2 * calls_between_checks_, 1024) : std::max(calls_between_checks_ / 4, 1);
  calls_ = 0;
  last_check_ = now;
  if (now - last_call_ < std::chrono::milliseconds(20)) return true;
  last_call_ = now;
  return monitor_(done, of_);
}

std::size_t in_portions(std::size_t N, std::size_t group, int threads, const Monitor& monitor,
                        const std::function<Work()>& make_work) {
  constexpr std::size_t largest_portion = 256;  // groups; below a millisecond for most mechanisms
  const std::size_t groups = (N + group - 1) / group;
  const std::size_t tasks =
      std::min(groups, static_cast<std::size_t>(std::min(threads, tbb::info::default_concurrency())));
  const std::thread::id caller = std::this_thread::get_id();
  MonitorThrottle throttle(monitor, N);
  std::atomic<std::size_t> next, first_left = groups, finished = 0;
  std::atomic<bool> stopped = false;
  const auto run = [&] {
    const Work work = make_work();
    const bool is_caller = std::this_thread::get_id() == caller;
    for (std::size_t begin = next; begin < groups; begin = next) {
      const std::size_t end =
          begin + std::clamp<std::size_t>((groups - begin) / (8 * tasks), 1, largest_portion);
      if (!next.compare_exchange_weak(begin, end)) continue;
      for (std::size_t g = begin; g < end; ++g) {
        if (stopped) {
          std::size_t left = first_left;
          while (g < left)
            if (first_left.compare_exchange_weak(left, g)) break;
          return;
        }
        work(g * group, std::min(group, N - g * group));
        if (is_caller && !throttle.should_continue(g * group)) stopped = true;
      }
    }
  };
  next.store(0);
  if (tasks < 2) {
    run();
  } else {
    // The tasks synchronise by the atomics `next` and `finished`. ThreadSanitizer would report a race,
    // because it does not see the locks inside the thread library.
    const auto task = [&](std::size_t) __attribute__((no_sanitize("thread"))) {
      if (next.load() < groups) run();
      ++finished;
    };
    tbb::parallel_for(std::size_t{0}, tasks, task, tbb::simple_partitioner());
    finished.load();
  }
  return std::min(first_left * group, N);
}

}  // namespace axode::batch
