// Contact with friction: a box slides down an incline by Coulomb's law. The certificate of each step says how
// exactly the law of contact holds, and the trajectory has the contact forces.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "axode/axode.hpp"
#include "axode/io.hpp"

using namespace axode;

constexpr const char* drawing = R"(format = "axode drawing 1"
name = "box on an incline"

[contact]
friction = 0.3

[[shape]]
name = "floor"
kind = "plane"
role = "collision"
rpy = [0, 0.35, 0]

[[body]]
name = "box"
joint = { kind = "free" }
mass = 2
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]

[[body.shape]]
kind = "box"
size = [0.2, 0.2, 0.2]
role = "collision"
)";

int main() {
  const Model model = ModelBuilder(read_drawing_text(drawing, "example")).build();
  const double angle = 0.35, half = 0.1, until = 1;
  std::vector<double> q{0, std::sin(angle / 2),   0, std::cos(angle / 2), half * std::sin(angle),
                        0, half * std::cos(angle)};
  const Trajectory motion = simulate_contact(model, q, std::vector<double>(6), until, 0.01);
  const std::span<const double> end = motion.q(motion.size() - 1);
  const double way = end[4] * std::cos(angle) - end[6] * std::sin(angle);
  const double by_law = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle)) * until * until / 2;
  std::printf("the box slides %.6f m, by the law %.6f m; largest certificate %.0e\n", way, by_law,
              std::ranges::max(motion.certificates));
  double pressure = 0;
  for (const ContactForce& contact : motion.contacts(motion.size() - 1)) pressure += contact.normal_force();
  const double weight = 2 * 9.81 * std::cos(angle);
  std::printf("the incline presses with %.6f N, by the law %.6f N\n", pressure, weight);
  return std::abs(way - by_law) < 1e-9 && std::abs(pressure - weight) < 1e-9 ? 0 : 1;
}
