#include "apps/study/drift.hpp"

#include <algorithm>
#include <limits>

#include "apps/files/state.hpp"
#include "axode/constraints/absolute/absolute_system.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode::command {
namespace {

using Vector = std::vector<double>;

/// Computes the accelerations dv of the bodies under gravity and the drive forces tau. Returns false, without
/// dv, if the equations of motion cannot be solved because the mass matrix is singular.
bool accelerate(AbsoluteSystem& bodies, const Vector& tau, std::span<const double> q,
                std::span<const double> v, std::span<double> dv) {
  const ConfigurationGroup<double> group(bodies.group());
  Vector f, p, rhs, x, lambda;
  bodies.forces(q, v, tau, {}, f);
  if (!bodies.factorize(q).ok()) return false;
  bodies.momentum(v, p);
  group.ad_transpose(v, p, p);
  for (std::size_t c = 0; c < f.size(); ++c) f[c] += p[c];
  bodies.bias(v, rhs);
  bodies.solve(f, rhs, x, lambda);
  std::ranges::copy(x, dv.begin());
  return true;
}

Drift::Of drift_of(const Model& model, const State& state, BodyGroup kind, int steps) {
  AbsoluteSystem bodies(model, kind);
  const ConfigurationGroup<double> group(bodies.group());
  MuntheKaas<double> scheme(bodies.group(), runge_kutta(4));
  Vector q, v, residual;
  bodies.from_joint_state(state.q, state.v, q, v);
  Vector dv(v.size());
  const Vector tau(static_cast<std::size_t>(model.nv()));
  for (int k = 0; k < steps; ++k) {
    const auto rates = [&](double, std::span<const double> q_i, std::span<const double> v_i,
                           std::span<double> dv_i) { return accelerate(bodies, tau, q_i, v_i, dv_i); };
    if (!accelerate(bodies, tau, q, v, dv) ||
        !scheme.run(0, q.data(), v.data(), dv.data(), 1.0 / steps, rates))
      return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    group.move(q, scheme.theta, q);
    v = scheme.y;
  }
  bodies.position_residual(q, residual);
  double on_ground = 0;
  each_root(model.topology(), [&](int i) {
    on_ground =
        std::max(on_ground, largest_of(std::span(residual).subspan(6 * static_cast<std::size_t>(i - 1), 6)));
  });
  return {on_ground, largest_of(residual)};
}

}  // namespace

std::vector<Drift> drifts(const Model& model) {
  const State state = random_state(model);
  std::vector<Drift> out;
  for (const int steps : {64, 128, 256, 512, 1024})
    out.push_back({.step = 1.0 / steps,
                   .SE3 = drift_of(model, state, BodyGroup::SE3, steps),
                   .SO3xR3 = drift_of(model, state, BodyGroup::SO3xR3, steps),
                   .by_joint = drift_of(model, state, BodyGroup::by_joint, steps)});
  return out;
}

}  // namespace axode::command
