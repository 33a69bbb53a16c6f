#pragma once
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "axode/eigen.hpp"
#include "axode/fmi.hpp"
#include "axode/integration/trajectory.hpp"
#include "tests/fmi/instance_of.hpp"

namespace axode::test {

/// Integrates an instance for model exchange, which has been started at time 0, in equal steps of the
/// classical Runge-Kutta method. Steps end at events, which are located to rounding by bisection.
class EventMaster {
 public:
  using Vector = Eigen::VectorXd;

  explicit EventMaster(fmi::Instance& instance, double t = 0)
      : instance_(&instance), x_(static_cast<Eigen::Index>(instance.n_states())), t_(t) {
    take_event();
  }

  /// Takes steps of length h until a time; `events` counts the events.
  void integrate(double until, double h) {
    while (t_ < until - 1e-12) {
      double to = std::min(until, t_ + h);
      const bool due = next_ && *next_ <= to;
      if (due) to = *next_;
      Vector x = step(to);
      bool crossed = crosses(to, x);
      if (crossed) {
        double low = t_;
        while (to - low > 2e-15 * std::max(1.0, to)) {
          const double middle = low + (to - low) / 2;
          const Vector between = step(middle);
          if (crosses(middle, between)) {
            to = middle;
            x = between;
          } else {
            low = middle;
          }
        }
      }
      t_ = to;
      x_ = x;
      put(t_, x_);
      if (instance_->needs_event() || crossed || due)
        take_event();
      else
        z_ = indicators();
    }
  }

  int events = -1;  ///< without the one at the start

 private:
  void put(double t, const Vector& x) {
    instance_->set_time(t);
    instance_->set_states(as_span(x));
  }
  Vector rates(double t, const Vector& x) {
    put(t, x);
    Vector dx(x.size());
    instance_->get_rates(as_span(dx));
    return dx;
  }
  Vector step(double to) {
    const double h = to - t_;
    const Vector k1 = rates(t_, x_), k2 = rates(t_ + h / 2, x_ + h / 2 * k1),
                 k3 = rates(t_ + h / 2, x_ + h / 2 * k2), k4 = rates(to, x_ + h * k3);
    return x_ + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  std::vector<double> indicators() {
    std::vector<double> z(instance_->n_indicators());
    instance_->get_indicators(z);
    return z;
  }
  bool crosses(double t, const Vector& x) {
    put(t, x);
    const std::vector<double> z = indicators();
    return !std::ranges::equal(z, z_, [](double a, double b) { return (a > 0) == (b > 0); });
  }
  void take_event() {
    next_ = instance_->update_discrete_states().next;
    instance_->get_states(as_span(x_));
    z_ = indicators();
    ++events;
  }

  fmi::Instance* instance_;
  Vector x_;
  double t_;
  std::vector<double> z_;
  std::optional<double> next_;
};

/// Expects that an instance is at the end of a motion, to within `off` in q and ten times that in v.
inline void expect_end_of(const Trajectory& motion, fmi::Instance& instance, const fmi::VariableTable& table,
                          double off) {
  const std::span<const double> q = motion.q(motion.size() - 1), v = motion.v(motion.size() - 1);
  const std::vector<double> q_end = values(instance, references(table, fmi::Role::coordinate)),
                            v_end = values(instance, references(table, fmi::Role::velocity));
  for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(q_end[k], q[k], off) << motion.model().name();
  for (std::size_t k = 0; k < v.size(); ++k) EXPECT_NEAR(v_end[k], v[k], 10 * off) << motion.model().name();
}

}  // namespace axode::test
