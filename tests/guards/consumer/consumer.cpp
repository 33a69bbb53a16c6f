// A pendulum of 2 kg, its centre of mass 0.5 m from a horizontal axis: held level, it takes m g l.
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "axode/axode.hpp"
#include "axode/io.hpp"

int main() {
  const axode::Model drawn =
      axode::ModelBuilder("pendulum")
          .add({.name = "rod",
                .joint = {.name = "pivot", .kind = axode::JointKind::revolute, .axis = {0, -1, 0}},
                .inertia =
                    axode::MassProperties{
                        .mass = 2, .com = {0.5, 0, 0}, .Theta = {0.01, 0.02, 0.02, 0, 0, 0}}})
          .build();
  std::ostringstream text;
  axode::write_drawing(drawn, text);
  const axode::Model model =
      axode::ModelBuilder(axode::read_drawing_text(text.str(), "pendulum.toml")).build();

  axode::Workspace<> workspace(model);
  const std::array<double, 1> zero{};
  std::array<double, 1> tau{};
  axode::inverse_dynamics(model, workspace, zero, zero, zero, tau);
  std::printf("a level pendulum takes %.3f N m\n", tau[0]);
  return std::abs(tau[0] - 2 * 9.81 * 0.5) < 1e-12 ? 0 : 1;
}
