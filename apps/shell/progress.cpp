#include "apps/shell/progress.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "apps/shell/table.hpp"
#include "apps/shell/terminal.hpp"

namespace axode::command {
namespace {

volatile std::sig_atomic_t caught = 0;
void catch_interrupt(int) { caught = 1; }

}  // namespace

Interruptible::Interruptible() : before_(std::signal(SIGINT, catch_interrupt)) {}
Interruptible::~Interruptible() { std::signal(SIGINT, before_); }
bool Interruptible::interrupted() const { return caught != 0; }

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r{:60}\r", "");
}

void Progress::show(double t) {
  const auto now = Clock::now();
  if (!is_terminal(stderr) || now - last_shown_ < std::chrono::milliseconds(100)) return;
  last_shown_ = now;
  const double gone = std::chrono::duration<double>(now - start_).count();
  if (gone < 1 || t <= 0) return;
  shown_ = true;
  const int done = static_cast<int>(30 * t / until_);
  const double left = gone * (until_ - t) / t;
  fmt::print(stderr, "\r[{:#<{}}{:{}}] {} of {} s, {:.0f} s left ", "", done, "", 30 - done,
             significant(t, 4), significant(until_, 4), left);
  std::fflush(stderr);
}

}  // namespace axode::command
