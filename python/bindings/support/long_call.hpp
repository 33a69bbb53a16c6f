#pragma once
#include <nanobind/nanobind.h>

#include <utility>

#include "axode/batch/portions.hpp"

namespace axode::python {

/// A call that may take long: other Python threads run meanwhile, and Ctrl-C is heard through the monitor.
class LongCall {
 public:
  /// Calls that take no longer than the lock itself keep it.
  explicit LongCall(bool release) : released_(release ? PyEval_SaveThread() : nullptr) {}
  ~LongCall() { take_lock(); }
  LongCall(const LongCall&) = delete;
  LongCall& operator=(const LongCall&) = delete;

  batch::Monitor monitor() {
    return [this](std::size_t, std::size_t) {
      const nanobind::gil_scoped_acquire acquired;
      interrupted_ = interrupted_ || PyErr_CheckSignals() != 0;
      return !interrupted_;
    };
  }
  /// To be called when the work is done or was ended. Throws nb::python_error, KeyboardInterrupt for one, where it was.
  void end() {
    take_lock();
    if (interrupted_) throw nanobind::python_error();
  }

 private:
  void take_lock() {
    if (released_ != nullptr) PyEval_RestoreThread(std::exchange(released_, nullptr));
  }

  PyThreadState* released_;
  bool interrupted_ = false;
};

}  // namespace axode::python
