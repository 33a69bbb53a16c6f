// Motion in time: a humanoid tumbles without weight. Its energy and its momentum show how exact each method
// is, an event says when its base has come up, and states between the steps are as exact as those at their
// ends.
#include <cmath>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model model = with_gravity(load(AXODE_ROBOTS_DIR "/humanoid.urdf", Base::free), {});
  Workspace<> workspace(model);
  const std::vector<double> q = neutral(model);
  std::vector<double> v(model.nv(), 0.3);

  const auto drift = [&](const Trajectory& motion) {
    const auto energy = [&](std::size_t k) {
      return kinetic_energy(model, workspace, motion.q(k), motion.v(k));
    };
    const auto momentum = [&](std::size_t k) {
      return spatial_momentum(model, workspace, motion.q(k), motion.v(k));
    };
    const std::size_t last = motion.size() - 1;
    const Momentum<Spatial> change = momentum(last) - momentum(0);
    std::printf("%6zu steps, %6zu evaluations: energy off by %.0e of %.1f J, momentum by %.0e N m s\n",
                motion.steps, motion.evaluations, std::abs(energy(last) - energy(0)), energy(0),
                norm(change.l));
  };
  drift(simulate_fixed(model, q, v, 1.0, 1e-3, runge_kutta(1)));
  drift(simulate_fixed(model, q, v, 1.0, 1e-3));
  drift(simulate_stiff(model, q, v, 1.0, 1e-3));
  drift(simulate(model, q, v, 1.0));

  SimulationOptions options;
  options.events.push_back({.value = [](double, std::span<const double> q_t, auto) { return q_t[6] - 0.2; }});
  const Trajectory motion = simulate(model, q, v, 1.0, {}, options);
  for (const Trajectory::EventOccurrence& met : motion.events)
    std::printf("at %.4f s its base is 0.2 m up\n", met.t);

  std::vector<double> q_half(q.size()), v_half(v.size());
  motion.at(0.5, q_half, v_half);
  std::printf("half-way it is at (%.3f, %.3f, %.3f) m\n", q_half[4], q_half[5], q_half[6]);
}
