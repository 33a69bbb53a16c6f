#pragma once
#include <nanobind/nanobind.h>

#include <utility>

#include "axode/batch/portions.hpp"

namespace axode::python {

/// A call from Python that may take long. Other Python threads may run meanwhile. The computation must call
/// monitor() now and then; it notices Ctrl-C and returns false if the call must end.
class LongCall {
 public:
  /// `release` says whether the interpreter's lock is released, so that other Python threads run. Short calls
  /// keep the lock, because releasing it would take as long as the call.
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
  /// Ends the call. It must be called when the work is done or was ended early. Throws nb::python_error, for
  /// example KeyboardInterrupt, if the call was interrupted.
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
