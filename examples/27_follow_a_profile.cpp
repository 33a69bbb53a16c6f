// Motions to follow: an arm goes from one configuration to another within limits of velocity and
// acceleration, and then along a path that is known at a few times. A controller keeps it near these motions.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

int main() {
  const Model model = load(AXODE_ROBOTS_DIR "/arm7.toml");
  const std::vector<double> rest(7), goal{0.3, 0.9, -0.2, -1.2, 0.1, 0.7, 0.0}, kp{900}, kd{60};

  const auto follow = [&](const char* name, const Trajectory& reference) {
    SimulationOptions options;
    options.drive = ComputedTorque(model, {kp, kd}, {model, reference});
    const double end = reference.t().back();
    const Trajectory motion = simulate(model, reference.q(0), reference.v(0), end, {}, options);
    std::vector<double> q(7), v(7), q_d(7), v_d(7);
    double error = 0;
    for (int k = 0; k <= 100; ++k) {
      const double t = k < 100 ? end * k / 100 : end;
      motion.at(t, q, v);
      reference.at(t, q_d, v_d);
      for (std::size_t c = 0; c < 7; ++c) error = std::max(error, std::abs(q[c] - q_d[c]));
    }
    std::printf("%-12s %.3f s, %2zu states, off by %.0e rad\n", name, end, reference.size(), error);
  };

  const std::vector<double> acceleration{6};  // rad/s², for every joint; velocity limits are those of the arm
  const ProfileLimits limits{.acceleration = acceleration};
  follow("quintic", quintic_profile(model, rest, goal, limits));
  follow("trapezoidal", trapezoidal_profile(model, rest, goal, limits));

  std::vector<double> times, samples;
  for (int k = 0; k <= 20; ++k) {
    const double t = 0.1 * k, s = std::sin(t) * std::sin(t);
    times.push_back(t);
    for (const double q : goal) samples.push_back(s * q);
  }
  follow("samples", trajectory_from_samples(model, times, samples));

  const MotionFunction nod(MotionDescription{
      .of = {}, .kind = MotionDescription::Kind::harmonic, .offset = 0, .amplitude = 0.5, .frequency = 0.5});
  const std::vector<PrescribedMotion> motions{{"A2", nod}};
  follow("function", trajectory_from_functions(model, times, motions));
}
