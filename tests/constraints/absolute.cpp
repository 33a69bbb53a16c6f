#include "axode/constraints/absolute/absolute_system.hpp"

#include "axode/constraints/absolute/joint_state.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/kinematics.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Mechanisms in absolute coordinates: bodies that move freely, with constraints in place of their joints.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

struct FreeBodies {
  FreeBodies(Model of, Numbers q_of, Numbers v_of, BodyGroup kind)
      : model(std::move(of)),
        kind_(kind),
        q_joints(std::move(q_of)),
        v_joints(std::move(v_of)),
        bodies(model, kind) {
    bodies.from_joint_state(q_joints, v_joints, q, v);
  }

  Numbers moved(const Numbers& velocity, double t) const {
    const ConfigurationGroup<double> group(bodies.group());
    Numbers x(velocity), out(q.size());
    for (double& x_c : x) x_c *= t;
    group.move(q.data(), x.data(), out.data());
    return out;
  }
  BodyGroup kind() const { return kind_; }
  std::size_t rows() const { return static_cast<std::size_t>(bodies.rows(ConstraintLevel::velocity)); }

  Model model;
  BodyGroup kind_;
  Numbers q_joints, v_joints;
  AbsoluteSystem bodies;
  Numbers q, v;
};

/// Calls f(bodies, random) for random trees and for mechanisms with loops, with both kinds of body groups.
template <class F> void for_free_bodies(int seeds, const F& f) {
  for (const BodyGroup kind : {BodyGroup::SE3, BodyGroup::SO3xR3}) {
    for_seeds(seeds, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Model model =
          ModelBuilder(described(random_mechanism(random, {.most_bodies = 12}), random)).build();
      const State<double> state = random_state(model, random);
      FreeBodies free(model, state.q, state.v, kind);
      f(free, random);
    });
    for (const Description& mechanism : {four_bar(), bricard(), slider_crank(), gough()}) {
      SCOPED_TRACE(mechanism.name);
      const Model model = ModelBuilder(mechanism).build();
      Random<double> random(3);
      const AssemblyResult closed = assemble(model, neutral(model), random_numbers(random, model.nv()));
      FreeBodies free(model, closed.q, closed.v, kind);
      f(free, random);
    }
  }
}

double product_of(const Numbers& x, const Numbers& y) {
  double sum = 0;
  for (std::size_t k = 0; k < x.size(); ++k) sum += x[k] * y[k];
  return sum;
}

TEST(AbsoluteSystem, GoesThereAndBack) {
  for_free_bodies(60, [](FreeBodies& free, Random<double>&) {
    Numbers q, v;
    free.bodies.to_joint_state(free.q, free.v, q, v);
    const Numbers apart = difference(free.model, free.q_joints, q);
    EXPECT_LT(largest_of(apart), 1e-11);
    for (std::size_t c = 0; c < v.size(); ++c) EXPECT_NEAR(v[c], free.v_joints[c], 1e-11);
    for (std::size_t k = 0; k < q.size(); ++k)
      EXPECT_NEAR(q[k], free.q_joints[k], 1e-11) << "turns and signs";
  });
}

TEST(AbsoluteSystem, JointsAreClosedAndStaySo) {
  for_free_bodies(60, [](FreeBodies& free, Random<double>&) {
    Numbers gap, slip;
    free.bodies.position_residual(free.q, gap);
    EXPECT_LT(largest_of(gap), 1e-10);
    free.bodies.velocity_residual(free.q, free.v, slip);
    EXPECT_LT(largest_of(slip), 1e-9 * (1 + largest_of(free.v)));
  });
}

TEST(AbsoluteSystem, RowsAreTheRatesOfTheGaps) {
  for_free_bodies(40, [](FreeBodies& free, Random<double>& random) {
    const Numbers any = random_numbers(random, free.bodies.nv());
    Numbers slip, before, after, twice_before, twice_after;
    free.bodies.velocity_residual(free.q, any, slip);
    const double h = 1e-3;
    const auto gap = [&](double by, Numbers& out) {
      free.bodies.position_residual(free.moved(any, by), out, ConstraintLevel::velocity);
    };
    gap(-h, before), gap(h, after), gap(-2 * h, twice_before), gap(2 * h, twice_after);
    free.bodies.set_nonholonomic_rates(free.q, any, 0,
                                       slip);  // the constraints of rotors of joints with several velocities
                                               // exist for velocities only
    for (std::size_t k = 0; k < slip.size(); ++k)
      EXPECT_NEAR(slip[k], (8 * (after[k] - before[k]) - (twice_after[k] - twice_before[k])) / (12 * h),
                  1e-8 * (1 + largest_of(slip)))
          << "row " << k;
  });
}

TEST(AbsoluteSystem, ClosingWrenchesAreDualToRows) {
  for_free_bodies(40, [](FreeBodies& free, Random<double>& random) {
    const Numbers any = random_numbers(random, free.bodies.nv());
    Numbers slip, lambda = random_numbers(random, static_cast<int>(free.rows())), f(any.size());
    free.bodies.velocity_residual(free.q, any, slip);
    for (std::size_t k = 0; k < slip.size(); ++k)
      if (slip[k] == 0) lambda[k] = 0;  // directions in which joints can move
    free.bodies.add_constraint_forces(free.q, lambda, f);
    EXPECT_NEAR(product_of(f, any), product_of(lambda, slip),
                1e-11 * (1 + largest_of(slip)) * static_cast<double>(f.size()));
  });
}

TEST(AbsoluteSystem, SolvesItsEquations) {
  for_free_bodies(40, [](FreeBodies& free, Random<double>& random) {
    if (free.model.name() == "Bricard")
      return;  // its rows are redundant, so that some right sides have no
               // solution
    if (!free.bodies.factorize_with_rank(free.q).ok()) return;
    const Numbers r = random_numbers(random, free.bodies.nv()),
                  any = random_numbers(random, free.bodies.nv());
    Numbers want, x, lambda, Mx, got;
    free.bodies.velocity_residual(free.q, any, want);
    free.bodies.solve(r, want, x, lambda);
    free.bodies.velocity_residual(free.q, x, got);
    for (std::size_t k = 0; k < got.size(); ++k)
      EXPECT_NEAR(got[k], want[k], 1e-7 * (1 + largest_of(x))) << "row " << k;
    free.bodies.momentum(x, Mx);
    Numbers f = r;
    free.bodies.add_constraint_forces(free.q, lambda, f);
    for (std::size_t c = 0; c < f.size(); ++c)
      EXPECT_NEAR(Mx[c], f[c], 1e-9 * (1 + largest_of(lambda) + largest_of(Mx))) << "coordinate " << c;
  });
}

/// The accelerations of the joints equal those that follow from the accelerations of the free bodies.
TEST(AbsoluteSystem, AcceleratesAsTheTreeDoes) {
  int seen = 0, tried = 0;
  for_free_bodies(40, [&](FreeBodies& free, Random<double>& random) {
    ++tried;
    const Numbers tau = random_numbers(random, free.model.nv());
    Numbers a_joints(tau.size());
    LoopWorkspace<double> loops(free.model);
    Workspace<> workspace(free.model);
    const Solvability found =
        free.model.loops().empty()
            ? forward_dynamics(free.model, workspace, free.q_joints, free.v_joints, tau, a_joints)
            : forward_dynamics(free.model, loops, free.q_joints, free.v_joints, tau, a_joints);
    if (!found.ok() || largest_of(a_joints) > 1e4) return;
    ++seen;
    Numbers f, p, turning(free.v.size()), want, a, lambda;
    ASSERT_TRUE(free.bodies.factorize_with_rank(free.q).ok());
    free.bodies.forces(free.q, free.v, tau, {}, f);
    free.bodies.momentum(free.v, p);
    ConfigurationGroup<double>(free.bodies.group()).ad_transpose(free.v.data(), p.data(), turning.data());
    for (std::size_t c = 0; c < f.size(); ++c) f[c] += turning[c];
    free.bodies.bias(free.v, want);
    free.bodies.solve(f, want, a, lambda);
    const auto after = [&](double h) {
      Numbers x(tau.size()), v_h(free.v_joints), q_b, v_b;
      for (std::size_t c = 0; c < x.size(); ++c)
        x[c] = h * free.v_joints[c] + h * h / 2 * a_joints[c], v_h[c] += h * a_joints[c];
      AbsoluteSystem there(free.model, free.kind());
      there.from_joint_state(integrate(free.model, free.q_joints, x), v_h, q_b, v_b);
      return v_b;
    };
    const double h = 1e-4;
    const Numbers v_1 = after(h), v_0 = after(-h), v_2 = after(2 * h), v_3 = after(-2 * h);
    for (std::size_t c = 0; c < a.size(); ++c)
      EXPECT_NEAR(a[c], (8 * (v_1[c] - v_0[c]) - (v_2[c] - v_3[c])) / (12 * h), 2e-6 * (1 + largest_of(a)))
          << "coordinate " << c;
  });
  EXPECT_GT(2 * seen, tried);
}

TEST(JointState, IsTheWayBackFromPosesAndTwists) {
  for_seeds(60, [](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model =
        ModelBuilder(described(random_mechanism(random, {.most_bodies = 12}), random)).build();
    const State<double> state = random_state(model, random);
    Workspace<> workspace(model);
    std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
    std::vector<Twist<BodyFixed>> V(C.size());
    poses<double>(model, workspace, state.q, C);
    twists<BodyFixed, double>(model, workspace, state.q, state.v, V);
    const auto bodies = static_cast<std::size_t>(model.n_bodies()) + 1;
    C.resize(bodies), V.resize(bodies);
    const JointState found = joint_state(model, C, V, state.q);
    for (std::size_t k = 0; k < found.q.size(); ++k) EXPECT_NEAR(found.q[k], state.q[k], 1e-10);
    for (std::size_t k = 0; k < found.v.size(); ++k) EXPECT_NEAR(found.v[k], state.v[k], 1e-9);
    EXPECT_LT(found.position_residual, 1e-10);
    EXPECT_LT(found.velocity_residual, 1e-8);
    const std::array<bool, 6> free = free_directions(model.joint(model.n_bodies()).kind);
    if (free[3] && free[4] && free[5]) return;  // the joint allows the translation below
    C.back().r.x += 0.1, C.back().r.y += 0.2, C.back().r.z += 0.3, V.back().v.x += 1, V.back().v.y += 2,
        V.back().v.z += 1;
    const JointState apart = joint_state(model, C, V);
    EXPECT_GT(apart.position_residual, 0.01);
    EXPECT_GT(apart.velocity_residual, 0.01);
    V.back().v.x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(joint_state(model, C, V).velocity_residual));
  });
}

}  // namespace
}  // namespace axode::test
