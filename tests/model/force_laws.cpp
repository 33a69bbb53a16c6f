#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/spring_laws.hpp"
#include "tests/lie/random_quantities.hpp"

/// Laws of the force laws of springs: energies and slopes belong to forces, tables are monotone, and
/// preloads are the tensions as drawn.
namespace axode::test {
namespace force_laws {
namespace {

ForceLaw law_of(ForceCurve curve, Acts acts = Acts::both_ways, double rest = 0.2) {
  SpringDescription spring{.rest = rest};
  spring.curve = std::move(curve);
  spring.acts = acts;
  return force_law(spring);
}
std::vector<ForceCurve> curves() {
  return {LinearCurve{40}, PolynomialCurve{{1, 3, -2, 5}}, TableCurve{{-1, 0, 0.3, 1, 2}, {-9, 0, 1, 20, 20}},
          GasCurve{1e-3, 2e5, 3e-3, 1.3, 1e5}, GasCurve{1e-3, 2e5, 3e-3, 1, 1e5}};
}

TEST(ForceLaws, ForcesAreTheSlopesOfEnergiesAndHaveTheirOwn) {
  for (const ForceCurve& curve : curves())
    for (const Acts acts : {Acts::both_ways, Acts::in_tension, Acts::in_compression}) {
      const ForceLaw law = law_of(curve, acts);
      for (double x = -1.73; x < 3; x += 0.1) {
        constexpr double h = 1e-5;
        const double dU = (stored_energy(law, x + h) - stored_energy(law, x - h)) / (2 * h),
                     dF = (tension(law, x + h, 0.0).f - tension(law, x - h, 0.0).f) / (2 * h);
        EXPECT_NEAR(tension(law, x, 0.0).f, dU, 2e-8 * (1 + std::abs(dU))) << curve.index() << " at " << x;
        EXPECT_NEAR(tension(law, x, 0.0).by_x, dF, 1e-7 * (1 + std::abs(dF))) << curve.index() << " at " << x;
      }
      EXPECT_EQ(stored_energy(law, law.rest), 0);
    }
}

TEST(ForceLaws, TablesPassTheirPointsMonotonously) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random<double> random(seed);
    TableCurve table{{0}, {0}};
    for (int k = 0; k < 6; ++k) {
      table.deflections.push_back(table.deflections.back() + random.number(0.01, 2));
      table.forces.push_back(table.forces.back() + (random.number(0, 1) < 0.3 ? 0 : random.number(0, 20)));
    }
    const ForceLaw law = law_of(table, Acts::both_ways, 0);
    for (std::size_t k = 0; k < table.forces.size(); ++k)
      EXPECT_NEAR(tension(law, table.deflections[k], 0.0).f, table.forces[k], 1e-13 * (1 + table.forces[k]));
    double before = tension(law, -1.0, 0.0).f;
    for (double x = -1; x < table.deflections.back() + 1; x += 0.01) {
      const double now = tension(law, x, 0.0).f;
      EXPECT_GE(now, before - 1e-12);
      before = now;
    }
  }
  const ForceLaw line = law_of(TableCurve{{0, 1, 2, 4}, {0, 3, 6, 12}}, Acts::both_ways, 0);
  for (const double x : {-2.0, 0.4, 1.7, 3.3, 9.0}) EXPECT_NEAR(tension(line, x, 0.0).f, 3 * x, 1e-14);
}

TEST(ForceLaws, AGasAtConstantTemperatureIsTheLimitOfOthers) {
  const ForceLaw isothermal = law_of(GasCurve{1e-3, 2e5, 3e-3, 1, 1e5}),
                 near = law_of(GasCurve{1e-3, 2e5, 3e-3, 1 + 1e-9, 1e5});
  for (const double x : {-1.0, 0.2, 2.0})
    EXPECT_NEAR(stored_energy(near, x), stored_energy(isothermal, x), 1e-6);
  EXPECT_TRUE(std::isnan(tension(isothermal, -2.9, 0.0).f)) << "without volume";
}

TEST(ForceLaws, OneSidedSpringsNeverPushOrPull) {
  SpringDescription cable{.stiffness = 10, .rest = 1, .damping = 3};
  cable.acts = Acts::in_tension;
  const ForceLaw law = force_law(cable);
  EXPECT_EQ(tension(law, 0.9, 5.0).f, 0);
  EXPECT_DOUBLE_EQ(tension(law, 1.2, 1.0).f, 5);
  EXPECT_EQ(tension(law, 1.2, -1.0).f, 0) << "a cable that shortens fast is slack";
  cable.acts = Acts::in_compression;
  EXPECT_DOUBLE_EQ(tension(force_law(cable), 0.9, -1.0).f, -4);
  EXPECT_EQ(tension(force_law(cable), 1.1, -9.0).f, 0);
}

/// The model of a hinge with a spring.
Model hinge_with(SpringDescription spring) {
  Description d{.name = "hinge"};
  d.bodies.push_back({.name = "leaf",
                      .joint = {.kind = JointKind::revolute, .point = {0.1, 0, 0}},
                      .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}});
  d.springs.push_back(std::move(spring));
  return ModelBuilder(std::move(d)).build();
}

TEST(ForceLaws, PreloadsAreTheTensionsAsDrawn) {
  for (const ForceCurve& curve : curves()) {
    if (std::holds_alternative<GasCurve>(curve)) continue;
    for (const double F : {-0.5, 0.0, 7.5}) {
      SpringDescription line{.between = {"ground", "leaf"},
                             .points = {Vec3<>{0, 2, 0}, Vec3<>{0.5, 0, 0}},
                             .in = GivenIn::construction_frame};
      line.curve = curve;
      line.preload = F;
      const ForceLaw law = hinge_with(line).springs().elements[0].law;
      EXPECT_NEAR(tension(law, std::hypot(2, 0.5), 0.0).f, F, 1e-12 * (1 + F)) << curve.index();
      SpringDescription turn{.kind = SpringKind::joints};
      turn.terms = {{"leaf_joint", 2.0}};
      turn.curve = curve;
      turn.preload = F;
      EXPECT_NEAR(tension(hinge_with(turn).springs().elements[0].law, 0.0, 0.0).f, F, 1e-12 * (1 + F));
    }
  }
}

TEST(ForceLaws, PreloadsOfOneSidedSpringsAreOnTheirSide) {
  for (const Acts acts : {Acts::in_tension, Acts::in_compression}) {
    const double sign = acts == Acts::in_tension ? 1 : -1;
    SpringDescription line{.between = {"ground", "leaf"},
                           .points = {Vec3<>{0, 2, 0}, Vec3<>{0.5, 0, 0}},
                           .in = GivenIn::construction_frame};
    line.acts = acts;
    line.preload = 4 * sign;
    line.curve = PolynomialCurve{{0, 0, sign}};  // it has this force on both sides
    EXPECT_NEAR(tension(hinge_with(line).springs().elements[0].law, std::hypot(2, 0.5), 0.0).f, 4 * sign,
                1e-12);
    line.curve = PolynomialCurve{{0, -1}};  // it has this force on the other side alone
    EXPECT_THROW(hinge_with(line), ModelError);
  }
  SpringDescription feeble{.between = {"ground", "leaf"}, .stiffness = 5e-324};
  feeble.preload = 1;
  EXPECT_THROW(hinge_with(feeble), ModelError) << "its rest would be infinite";
}

TEST(ForceLaws, WarnOfForcesThatJump) {
  SpringDescription bumper{.between = {"ground", "leaf"}, .rest = 0.3};
  bumper.curve = PolynomialCurve{{5, 100}};
  bumper.acts = Acts::in_tension;
  const Model model = hinge_with(bumper);
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_THAT(model.warnings()[0].message, testing::HasSubstr("its force jumps to 5 where it begins to act"));
  bumper.curve = PolynomialCurve{{0, 100}};
  EXPECT_TRUE(hinge_with(bumper).warnings().empty());
}

}  // namespace
}  // namespace force_laws
}  // namespace axode::test
