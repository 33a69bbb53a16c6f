#pragma once
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "axode/drives/drive_system.hpp"
#include "axode/integration/runs/switch_search.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// A motion of (q, v) and of the states x of drives by an explicit method. Its steps end where an input
/// jumps, and where a status of a drive, the number that says which form of its law holds, must change. After
/// the constructor no memory is allocated.
class DriveSteps {
 public:
  using Vector = std::vector<double>;
  using Span = std::span<const double>;

  /// Why advance() has ended: a stage failed, the loops stayed open, or statuses change too fast.
  enum class End { none, failed, loops_open, too_many_changes };

  DriveSteps(const Model& model, const Tableau& method, DriveSystem drives)
      : q(static_cast<std::size_t>(model.nq())),
        v(static_cast<std::size_t>(model.nv())),
        x(drives.nx()),
        drives_(std::move(drives)),
        scheme_(model.tree<double>(), method, LocalCoordinates::exponential, x.size()),
        group_(model.tree<double>()),
        end_{q, Vector(v.size() + x.size())},
        after_(end_),
        y_0_(end_.y),
        dy_0_(end_.y) {}

  Vector q, v, x;  ///< present state

  DriveSystem& drives() { return drives_; }
  /// Begins a motion at time t and state (q, v). If x_0 is empty, the drives choose their states.
  void begin(double t, Span q_0, Span v_0, Span x_0) {
    t_ = t;
    short_steps_ = 0;
    std::ranges::copy(q_0, q.begin());
    std::ranges::copy(v_0, v.begin());
    std::ranges::copy(x_0, x.begin());
    if (x_0.empty())
      drives_.start(t, q, v, x);
    else
      drives_.set_state(t, q, v, x);
  }

  /// Advances the motion to the time t_1. It takes several steps if inputs of drives jump, or drives change
  /// the form of their laws, before t_1. rates(t, q, v, x, a, dx) must write the accelerations a and the
  /// rates dx of the states x of the drives at time t and state (q, v, x), and return whether it succeeded.
  /// close(q, v) must close the loops at the end of a step and return whether they are closed.
  template <class Rates, class Close> End advance(double t_1, const Rates& rates, const Close& close) {
    while (t_ < t_1) {
      if (const End end = take_step(t_1, rates, close); end != End::none) return end;
      switch_now();
    }
    return End::none;
  }

  /// The time of the present state.
  double t() const { return t_; }
  /// Takes one step to the time t_1, or to an earlier time. If an input of a drive jumps before t_1, the step
  /// ends at the jump. If a drive must change the form of its law before, for example because a current
  /// reaches its limit, the step ends just after this time. The whole step is computed with the old inputs
  /// and laws; switch_now() then changes them. rates(t, q, v, x, a, dx) must write the accelerations a and
  /// the rates dx of the states x of the drives at time t and state (q, v, x), and return whether it
  /// succeeded. close(q, v) must close the loops at the end of the step and return whether they are closed.
  template <class Rates, class Close> End take_step(double t_1, const Rates& rates, const Close& close) {
    const std::size_t nv = v.size();
    const auto rates_of = [&](double t, Span q_t, Span y_t, std::span<double> dy) {
      return rates(t, q_t, y_t.first(nv), y_t.subspan(nv), dy.first(nv), dy.subspan(nv));
    };
    std::ranges::copy(v, y_0_.begin());
    std::ranges::copy(x, y_0_.begin() + static_cast<std::ptrdiff_t>(nv));
    if (!rates_of(t_, q, y_0_, dy_0_)) return End::failed;
    const auto attempt = [&](double t, State& end) {
      if (!scheme_.run(t_, q.data(), y_0_.data(), dy_0_.data(), t - t_, rates_of)) return false;
      group_.move(q.data(), scheme_.theta.data(), end.q.data());
      std::ranges::copy(scheme_.y, end.y.begin());
      return true;
    };
    double t = std::min(t_1, drives_.next_jump(t_));
    if (!attempt(t, after_)) return End::failed;
    if (const End end = end_at_switch(t, attempt); end != End::none) return end;
    t_ = t;
    q.swap(after_.q);
    std::copy_n(after_.y.begin(), nv, v.begin());
    std::copy_n(after_.y.begin() + static_cast<std::ptrdiff_t>(nv), x.size(), x.begin());
    return close(std::span(q), std::span(v)) ? End::none : End::loops_open;
  }
  /// Changes the inputs of drives that jump at the present time, and the statuses (numbers that say which
  /// form of a drive's law holds) that must change. Returns whether it has changed one.
  bool switch_now() { return drives_.switch_at(t_, q, v, x); }

 private:
  struct State {
    Vector q, y;  ///< y = (v, x)
  };

  double margin(double t, const State& at) {
    const Span y(at.y);
    return drives_.least_margin(t, at.q, y.first(v.size()), y.subspan(v.size()));
  }
  /// Shortens the step to t, at whose end the state is after_, if a drive must change the form of its law
  /// before: t and after_ are then the time and the state just after the change.
  template <class Attempt> End end_at_switch(double& t, const Attempt& attempt) {
    const double margin_1 = margin(t, after_);
    if (!(margin_1 < 0)) return End::none;
    SwitchSearch search(t_, t, std::max(0.0, drives_.least_margin(t_, q, v, x)), margin_1);
    while (search.continues()) {
      const double t_i = search.next();
      if (!attempt(t_i, end_)) return End::failed;
      if (search.take(margin(t_i, end_))) std::swap(after_, end_);
    }
    short_steps_ = search.found() - t_ < short_part * (t - t_) ? short_steps_ + 1 : 0;
    t = search.found();
    return short_steps_ > most_short_steps ? End::too_many_changes : End::none;
  }

  DriveSystem drives_;
  MuntheKaas<> scheme_;
  ConfigurationGroup<double> group_;
  State end_, after_;  ///< ends of attempts at a step; after_ is the one that will be accepted
  Vector y_0_, dy_0_;
  double t_ = 0;
  int short_steps_ = 0;
};

}  // namespace axode
