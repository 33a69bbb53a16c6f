#include "tests/support/units.hpp"

#include "tests/integration/motions.hpp"
#include "tests/support/random_loops.hpp"

/// Motions do not depend on units. In other units of length, mass and time every coordinate of every step is
/// multiplied by the factor of its unit. Schemes that compare numbers with an absolute threshold differ,
/// because their iterations end earlier or later.
namespace axode::test {
namespace {

struct SchemeInUnits {
  const char* method;
  const char* coordinates = "relative";
};
/// The entry of a table that has this name.
template <class Table> const auto& named(const Table& table, std::string_view name) {
  const auto found = std::ranges::find(table, name, [](const auto& row) { return row.first; });
  if (found == table.end()) throw std::logic_error("no row " + std::string(name));
  return found->second;
}
/// The motion from (q, v) with steps of one length. The drives have constant forces and damping.
Trajectory motion_of(const Model& model, const State<double>& at, const Numbers& tau, const Numbers& damping,
                     double step, const SchemeInUnits& scheme) {
  SimulationOptions options{.coordinates = named(coordinate_kinds, scheme.coordinates)};
  options.drive = [&](double, Span, Span v, std::span<double> out) {
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = tau[c] - damping[c] * v[c];
  };
  return named(methods, scheme.method).simulate({model, at.q, at.v, 20 * step, step, {}, 0.8, options});
}

/// Expects the same end of the motion after a change of units and back.
void expect_the_same_motion(const Units& units, const Description& description, const State<double>& at,
                            const Numbers& tau, double step, const SchemeInUnits& scheme,
                            Comparison& positions, Comparison& velocities) {
  SCOPED_TRACE(std::string(scheme.method) + " " + scheme.coordinates);
  const Model model = ModelBuilder(description).build(),
              other = ModelBuilder(in_units(units, description)).build();
  const Units back{.length = 1 / units.length, .mass = 1 / units.mass, .time = 1 / units.time};
  const Numbers other_tau = in_units(units, model, Ask{.tau = tau}).tau;
  Numbers damping(tau.size(), 0.01), other_damping(tau.size());
  const std::vector<Dimension> directions = direction_dimensions(model);
  for (std::size_t c = 0; c < tau.size(); ++c)
    other_damping[c] =
        damping[c] * units(dimension::energy * dimension::time / (directions[c] * directions[c]));
  const Trajectory one = motion_of(model, at, tau, damping, step, scheme),
                   two = motion_of(other, in_units(units, model, at), other_tau, other_damping,
                                   step * units.time, scheme);
  ASSERT_EQ(two.complete, one.complete) << one.stop_reason << two.stop_reason;
  EXPECT_EQ(two.steps, one.steps);
  EXPECT_EQ(two.evaluations, one.evaluations);
  const Ask end = in_units(back, model,
                           Ask{.q = Numbers(last_q(two).begin(), last_q(two).end()),
                               .v = Numbers(last_v(two).begin(), last_v(two).end())});
  positions.expect_equal(end.q, Numbers(last_q(one).begin(), last_q(one).end()));
  velocities.expect_equal(end.v, Numbers(last_v(one).begin(), last_v(one).end()));
}

TEST(UnitsOfMotions, OfTreesMultiplyEveryStep) {
  Comparison positions("q", 1e-11), velocities("v", 1e-10);
  for (const Units& units : {Units{.length = 0x1p-8, .mass = 0x1p-12, .time = 0x1p-4},
                             Units{.length = 0x1p10, .mass = 0x1p-10, .time = 0x1p12}})
    for_seeds(15, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Description drawn =
          described(random_mechanism(random, {.most_bodies = 5, .always_mass = true}), random);
      const Model model = ModelBuilder(drawn).build();
      State<double> at = random_state(model, random);
      const Numbers tau = random_numbers(random, model.nv());
      for (const SchemeInUnits& scheme :
           {SchemeInUnits{"rk4"}, SchemeInUnits{"generalized_alpha"}, SchemeInUnits{"midpoint"},
            SchemeInUnits{"kahan_li6"}, SchemeInUnits{"rk4", "absolute"}, SchemeInUnits{"rattle", "absolute"},
            SchemeInUnits{"generalized_alpha", "absolute_SO3xR3"}})
        expect_the_same_motion(units, drawn, at, tau, 1e-3, scheme, positions, velocities);
    });
}

/// The rows of loops are couples or forces, and only the unit of length makes a difference between these.
TEST(UnitsOfMotions, OfMassAndTimeMultiplyStepsOfMechanismsWithLoops) {
  Comparison positions("q", 1e-10), velocities("v", 1e-9);
  for (const Units& units : {Units{.mass = 0x1p-20, .time = 0x1p12}, Units{.mass = 0x1p20, .time = 0x1p-10}})
    for_seeds(15, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const ClosedMechanism closed(closed_mechanism(random));
      bool smooth = true, rolls = false;
      for (const int i : closed.model.springs().joints)
        for (const Dof& dof : closed.model.joint(i).dof) smooth = smooth && dof.stop_stiffness == 0;
      for (const LoopRows& loop : closed.model.loops().all) rolls = rolls || loop.rows != loop.residuals;
      const auto expect = [&](const SchemeInUnits& scheme) {
        expect_the_same_motion(units, closed.description, closed.state, closed.tau, 1e-4, scheme, positions,
                               velocities);
      };
      for (const char* const method : {"rk4", "generalized_alpha"}) expect({method});
      for (const char* const method : {"half_explicit", "generalized_alpha_index3"})
        expect({method, "absolute_SO3xR3"});
      if (smooth && !rolls) expect({"midpoint"});
      if (smooth) expect({"rattle", "absolute"});
    });
}

/// If the sizes in an implicit step overflow, every change seems to be rounding, and the first guess would be
/// taken for the solution.
TEST(UnitsOfMotions, SquaresOfAccelerationsMayOverflow) {
  Description top{.name = "top", .gravity = {}};
  BodyDescription body{.name = "body", .predecessor = "ground"};
  body.joint = {.name = "ball", .kind = JointKind::spherical};
  body.inertia = MassProperties{.mass = 1, .Theta = {1, 2, 2.5}};
  top.bodies.push_back(std::move(body));
  const Model model = ModelBuilder(top).build();
  const double faster = 0x1p460;
  const Numbers none(3), v{1, 0.3, 0.1};
  Numbers high(v);
  for (double& v_c : high) v_c *= faster;
  for (const char* const method : {"generalized_alpha", "midpoint"}) {
    SCOPED_TRACE(method);
    const Trajectory slow = motion_of(model, {neutral(model), v, none}, none, none, 0.1, {method});
    const Trajectory fast =
        motion_of(model, {neutral(model), high, none}, none, none, 0.1 / faster, {method});
    ASSERT_TRUE(fast.complete) << fast.stop_reason;
    EXPECT_EQ(fast.evaluations, slow.evaluations);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(fast.v(fast.size() - 1)[c] / faster, slow.v(slow.size() - 1)[c], 1e-12);
  }
}

}  // namespace
}  // namespace axode::test
