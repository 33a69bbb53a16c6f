// A function of each library, by all public headers: a linkage falls and
// is shown, a pendulum is held in two states at once and written as C.
#include <cmath>
#include <cstdio>
#include <sstream>
#include <vector>

#include "axode/axode.hpp"
#include "axode/batch.hpp"
#include "axode/catalog.hpp"
#include "axode/codegen.hpp"
#include "axode/constraints.hpp"
#include "axode/dense.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/fmi.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/kinematics.hpp"
#include "axode/lie.hpp"
#include "axode/model.hpp"
#include "axode/view.hpp"

using namespace axode;

BodyDescription bar(const char* name, const char* on, const Vec3<>& pivot, const Vec3<>& com) {
  return {.name = name,
          .predecessor = on,
          .joint = {.kind = JointKind::revolute, .axis = {0, -1, 0}, .point = pivot},
          .inertia = MassProperties{.mass = 2, .com = com, .Theta = {0.01, 0.02, 0.02, 0, 0, 0}}};
}

int main() {
  const Model linkage =
      ModelBuilder("parallelogram")
          .add(bar("crank", "ground", {0, 0, 0}, {0.5, 0, 0}))
          .add(bar("coupler", "crank", {1, 0, 0}, {1, 0, 1}))
          .add(bar("rocker", "ground", {0, 0, 2}, {0.5, 0, 2}))
          .add(LoopDescription{.between = {"coupler", "rocker"}, .axis = {0, 1, 0}, .point = {1, 0, 2}})
          .build();
  const std::vector<double> level(3), still(3);
  const Trajectory fall = simulate(linkage, level, still, 0.5);
  Workspace<> workspace(linkage);
  const auto energy = [&](std::size_t k) {
    return kinetic_energy(linkage, workspace, fall.q(k), fall.v(k)) +
           potential_energy(linkage, workspace, fall.q(k));
  };
  const double drift = std::abs(energy(fall.size() - 1) - energy(0));
  std::ostringstream scene;
  write_scene(linkage, level, scene);

  const Model pendulum = ModelBuilder("pendulum").add(bar("rod", "ground", {0, 0, 0}, {0.5, 0, 0})).build();
  const std::vector<double> zero(2);
  std::vector<double> tau(2);
  static_cast<void>(batch::run(pendulum, "inverse_dynamics", {.q = zero, .v = zero, .a = zero}, tau));
  const codegen::Source source = codegen::c_source(
      pendulum, std::vector<codegen::Function>{{catalog::Id("inverse_dynamics")}}, {.prefix = "pendulum"});

  std::printf("a linkage falls by %.3f rad, its energy drifts by %.0e J; a level pendulum takes %.3f N m\n",
              fall.q(fall.size() - 1)[0], drift, tau[1]);
  const bool held = std::abs(tau[1] - 2 * 9.81 * 0.5) < 1e-12, falls = fall.q(fall.size() - 1)[0] < -0.5;
  const bool written =
      !source.text.empty() && !scene.str().empty() && !fmi::fmu_files(linkage, {}, "").empty();
  return held && falls && drift < 1e-6 && written ? 0 : 1;
}
