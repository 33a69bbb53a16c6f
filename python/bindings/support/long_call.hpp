#pragma once
#include <nanobind/nanobind.h>

#include <utility>

#include "axode/batch/portions.hpp"

namespace axode::python {

/// Use this in a call from Python that may take long. Other Python threads can run during the call. The
/// computation must call monitor() now and then, which notices Ctrl-C and returns false if the call must end.
class LongCall {
 public:
  /// `release`: whether other Python threads may run meanwhile, which does not pay off for short calls.
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
  /// Ends the call; to be called after the work. Throws nb::python_error if it was interrupted, as by Ctrl-C.
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
