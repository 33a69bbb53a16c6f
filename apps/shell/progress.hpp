#pragma once
#include <chrono>

namespace axode::command {

/// Catches Ctrl-C, which does not end the program while the object exists.
class Interruptible {
 public:
  Interruptible();
  ~Interruptible();
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  /// Whether Ctrl-C was pressed while an Interruptible existed.
  bool interrupted() const;

 private:
  void (*before_)(int);
};

/// A progress bar on a terminal with the remaining time. It appears after one second.
class Progress {
 public:
  explicit Progress(double until) : until_(until) {}
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows the simulated time t (s) that has been reached.
  void show(double t);

 private:
  using Clock = std::chrono::steady_clock;
  double until_;
  Clock::time_point start_ = Clock::now(), last_shown_ = start_;
  bool shown_ = false;
};

}  // namespace axode::command
