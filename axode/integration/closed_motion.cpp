#include "axode/integration/closed_motion.hpp"

#include <algorithm>
#include <cmath>

#include "axode/constraints/check_loops.hpp"

namespace axode {
namespace {

constexpr double closed = 1e-13;

double norm(std::span<const double> x) {
  double sum = 0;
  for (const double x_k : x) sum += x_k * x_k;
  return std::sqrt(sum);
}

}  // namespace

ClosedMotion::ClosedMotion(const Model& model)
    : model_(model),
      workspace_(model),
      group_(model_.tree<double>()),
      lambda_(static_cast<std::size_t>(model.loops().rows)),
      r_(lambda_.size()),
      x_(static_cast<std::size_t>(model.nv())) {}

void ClosedMotion::check(Span q, Span v) {
  LoopSystem<double>& system = workspace_.system(model_);
  check_closed(system, q, v);
  static_cast<void>(system.hold(q.data()));
}

Solvability ClosedMotion::accelerate(Span q, Span v, Span tau, const Loads<double>& loads,
                                     std::span<double> a) {
  return workspace_.system(model_).accelerate(q.data(), v.data(), tau.data(), loads, a.data(),
                                              lambda_.data());
}

void ClosedMotion::differentiate(Span q, Span v, Span tau, const Loads<double>& loads,
                                 const ClosedDynamicsDerivatives<double>& d) {
  static_cast<void>(forward_dynamics_derivatives(model_, workspace_, q, v, tau, d, loads));
}

void ClosedMotion::hold(Span q) { static_cast<void>(workspace_.system(model_).hold(q.data())); }

bool ClosedMotion::close(std::vector<double>& q, std::vector<double>& v) {
  LoopSystem<double>& system = workspace_.system(model_);
  const auto open = [&] {
    system.place(q.data());
    system.residual(q.data(), r_.data());
    return norm(Span(r_).first(static_cast<std::size_t>(model_.loops().residuals)));
  };
  double before = open();
  for (int n = 0; n < 5 && before > closed; ++n) {
    if (!system.approach(q.data(), x_.data()).ok()) return false;
    group_.move(q.data(), x_.data(), q.data());
    const double now = open();
    if (!(now < 0.5 * before)) {  // as far as rounding lets it come, or not at all
      before = now;
      break;
    }
    before = now;
  }
  const bool held = system.hold(q.data()).ok();
  return before <= closed_enough && held && system.collide(v.data(), 0, v.data(), lambda_.data()).ok();
}

}  // namespace axode
