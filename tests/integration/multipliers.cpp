#include "axode/constraints/assembly.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/integration/runs/absolute_simulation_run.hpp"
#include "axode/integration/schemes/constrained_alpha.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/integration/motions.hpp"

/// The multipliers of generalised-alpha after one second: the forces that a joint exerts, or the ground on a
/// rolling body.
namespace axode::test {
namespace {

Model fast_top() {
  Description d{.name = "heavy top", .bodies = {}, .frames = {}};
  d.bodies.push_back({.name = "top",
                      .joint = {.kind = JointKind::spherical, .point = {0, 0, 0}},
                      .inertia = MassProperties{.mass = 15,
                                                .com = {0, 1, 0},
                                                .Theta = {0.234375, 0.46875, 0.234375, 0, 0, 0},
                                                .in = GivenIn::construction_frame}});
  return ModelBuilder(d).build();
}

/// The force of the joint on the body, from the acceleration c̈ of its centre of mass in the motion: m (c̈ -
/// g), N, in inertial axes.
Vec3<> force_of(const Model& model, const Trajectory& motion) {
  const Span q = last_q(motion), w = last_v(motion), dw = motion.a(motion.size() - 1);
  const SO3<> R = rotation(Quaternion<>{q[0], q[1], q[2], q[3]});
  const Vec3<> omega{w[0], w[1], w[2]}, alpha{dw[0], dw[1], dw[2]}, c{0, 1, 0};
  return 15.0 * (R * (cross(alpha, c) + cross(omega, cross(omega, c))) - model.gravity());
}

/// The relative error of the scheme's own multipliers after 1 s.
double multiplier_error(const Model& model, Coordinates kind, bool stabilized, int steps,
                        const Vec3<>& exact) {
  SimulationOptions options;
  options.coordinates = kind;
  const Numbers q{0, 0, 0, 1}, v{0, 150, -4.61538};
  AbsoluteSimulationRun run(model, q, v, 1, options);
  ConstrainedAlpha<AbsoluteSimulationRun> scheme(run, 0.9, stabilized, run.q, run.v, run.a, run.lambda);
  for (int k = 0; k < steps; ++k) EXPECT_EQ(scheme.run(k / double(steps), 1.0 / steps).why, "");
  const SO3<> R = rotation(Quaternion<>{scheme.q[0], scheme.q[1], scheme.q[2], scheme.q[3]});
  const Vec3<> error = R * Vec3<>{scheme.lambda[3], scheme.lambda[4], scheme.lambda[5]} - exact;
  return norm(error) / norm(exact);
}

TEST(Multipliers, OfGeneralizedAlphaAreOfOrderTwoButForTheTransientOfIndexThree) {
  const Model model = fast_top();
  const Numbers q{0, 0, 0, 1}, v{0, 150, -4.61538};
  const Vec3<> exact = force_of(model, simulate_symplectic(model, q, v, 1, 1.0 / 4096, 6));
  for (const auto& [kind, stabilized, order] : {std::tuple{Coordinates::absolute, false, 2.0},
                                                {Coordinates::absolute, true, 2.0},
                                                {Coordinates::absolute_SO3xR3, true, 2.0}}) {
    const double coarse = multiplier_error(model, kind, stabilized, 1024, exact),
                 fine = multiplier_error(model, kind, stabilized, 2048, exact);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.15) << coarse << " " << fine;
  }
  // On SO(3) × R³ the start causes an error of the first order. It decays with the spectral radius: in each
  // step 0.9 of it remain.
  const double coarse = multiplier_error(model, Coordinates::absolute_SO3xR3, false, 1024, exact),
               fine = multiplier_error(model, Coordinates::absolute_SO3xR3, false, 2048, exact);
  EXPECT_GT(std::log2(coarse / fine), 0.8) << coarse << " " << fine;
}

/// Compares the force that carries a disc and keeps it from slipping with that of the exact motion.
TEST(Multipliers, OfWhatRollsAreOfOrderTwo) {
  const Model model = ModelBuilder(wheel(false)).build();
  const AssemblyResult at = assemble(model, neutral(model), Numbers{0.4, 6, 0.7, 0, 0, 0});
  const Trajectory exact = simulate(model, at.q, at.v, 1, {1e-12, 1e-13});
  LoopWorkspace<double> workspace(model);
  Numbers a(6), lambda(3);
  ASSERT_TRUE(
      forward_dynamics<double>(model, workspace, last_q(exact), last_v(exact), Numbers(6), a, lambda).ok());
  for (const Coordinates kind : {Coordinates::absolute, Coordinates::absolute_SO3xR3})
    for (const bool stabilized : {true, false}) {
      const auto error = [&](int steps) {
        SimulationOptions options;
        options.coordinates = kind;
        AbsoluteSimulationRun run(model, at.q, at.v, 1, options);
        ConstrainedAlpha<AbsoluteSimulationRun> scheme(run, 0.8, stabilized, run.q, run.v, run.a, run.lambda);
        for (int k = 0; k < steps; ++k) EXPECT_EQ(scheme.run(k / double(steps), 1.0 / steps).why, "");
        const auto contact = std::span(scheme.lambda).last<3>();
        return norm(Vec3<>{contact[0] - lambda[0], contact[1] - lambda[1], contact[2] - lambda[2]});
      };
      const double coarse = error(200), fine = error(400);
      EXPECT_NEAR(std::log2(coarse / fine), 2, 0.1) << coarse << " " << fine;
    }
}

}  // namespace
}  // namespace axode::test
