#include <gmock/gmock.h>

#include <Eigen/QR>
#include <limits>

#include "axode/constraints/assembly.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/mobility.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/kinematics.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"

/// Mechanisms with loops. Some have rows that are redundant because of the kinds of the loops, and one has a
/// row that is redundant because of its geometry.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

struct Mechanism_ {
  const char* name;
  Description (*drawn)();
  int rows, rank, freedom;
};
Description turned_four_bar() { return four_bar(); }
const Mechanism_ mechanisms[] = {{"FourBar", turned_four_bar, 5, 2, 1},
                                 {"Bricard", bricard, 5, 4, 1},
                                 {"SliderCrank", slider_crank, 5, 2, 1},
                                 {"Gough", gough, 18, 18, 6}};

/// A closed state of a mechanism, away from the configuration in which it was drawn.
struct ClosedState {
  ClosedState(const Model& model, std::uint64_t seed) : loops(model), workspace(model, cut_tree) {
    Random<double> random(seed);
    const Numbers away = random_numbers(random, model.nv(), 0.1);
    AssemblyResult found =
        assemble(model, integrate(model, neutral(model), away), random_numbers(random, model.nv()));
    EXPECT_EQ(found.status, AssemblyStatus::closed) << to_string(model, found);
    q = found.q, v = found.v, tau = random_numbers(random, model.nv(), 10);
  }
  LoopWorkspace<double> loops;
  Workspace<double> workspace;
  Numbers q, v, tau;
};

MatrixXd jacobian_of(const Model& model, ClosedState& at) {
  Numbers A(static_cast<std::size_t>(model.loops().rows * model.nv()));
  loop_jacobian(model, at.loops, at.q, A);
  return matrix(model.loops().rows, A);
}
VectorXd bias_of(const Model& model, ClosedState& at) {
  Numbers gamma(static_cast<std::size_t>(model.loops().rows));
  loop_bias(model, at.loops, at.q, at.v, gamma);
  return vector(gamma);
}
MatrixXd mass_of(const Model& model, ClosedState& at) {
  Numbers M(static_cast<std::size_t>(model.nv() * model.nv()));
  mass_matrix(model, at.workspace, at.q, M);
  return matrix(model.nv(), M);
}
VectorXd acceleration_of(const Model& model, ClosedState& at, const Numbers& tau, Numbers lambda = {}) {
  Numbers a(at.v.size());
  EXPECT_TRUE(forward_dynamics(model, at.loops, at.q, at.v, tau, a, lambda).ok());
  return vector(a);
}

class ClosedMechanisms : public testing::TestWithParam<Mechanism_> {
 protected:
  const Model model = ModelBuilder(GetParam().drawn()).build();
};

TEST_P(ClosedMechanisms, HaveTheirRankAndFreedom) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    const LoopMobility found = loop_mobility(model, at.q);
    EXPECT_EQ(model.loops().rows, GetParam().rows);
    EXPECT_EQ(found.rank, GetParam().rank);
    EXPECT_EQ(found.degrees_of_freedom, GetParam().freedom);
    EXPECT_EQ(static_cast<int>(found.redundant.size()), GetParam().rows - GetParam().rank);
    EXPECT_EQ(found.mobility, Mobility::regular);
    const MatrixXd A = jacobian_of(model, at);
    EXPECT_LT(largest_entry(product(A, found.kernel)), 1e-9);
    for (const RedundantRow& row : found.redundant) {
      EXPECT_LT((A.transpose() * row.dependency).norm(), 1e-8 * row.dependency.norm());
      EXPECT_EQ(row.dependency[row.row], 1);
    }
    const Numbers ajar = integrate(model, at.q, Numbers(at.v.size(), 1e-6));
    EXPECT_EQ(loop_mobility(model, ajar).rank, GetParam().rank) << "as far as the loops are closed";
  }
}

/// The mobility is also found at configurations where the loops are closed only approximately, and redundant
/// rows agree only approximately.
TEST_P(ClosedMechanisms, HaveThemWhereTheyAreNearlyClosed) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    Random<double> random(seed);
    const Numbers q = integrate(model, at.q, random_numbers(random, model.nv(), 1e-6));
    EXPECT_EQ(loop_mobility(model, q).degrees_of_freedom, GetParam().freedom);
  }
}

/// The reference is a least-squares solution of the whole dense system.
TEST_P(ClosedMechanisms, MoveAsTheDenseSystemSays) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    ClosedState at(model, seed);
    const Eigen::Index n = model.nv(), m = model.loops().rows;
    const MatrixXd A = jacobian_of(model, at), M = mass_of(model, at);
    Numbers h(at.v.size()), lambda(static_cast<std::size_t>(m));
    inverse_dynamics(model, at.workspace, at.q, at.v, Numbers(at.v.size()), h);
    MatrixXd K = MatrixXd::Zero(n + m, n + m);
    K.topLeftCorner(n, n) = M, K.topRightCorner(n, m) = -A.transpose(), K.bottomLeftCorner(m, n) = A;
    VectorXd right(n + m);
    right << vector(at.tau) - vector(h), -bias_of(model, at);
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(1e-9);
    const VectorXd expected = solver.compute(K).solve(right);
    Numbers a(at.v.size());
    ASSERT_TRUE(forward_dynamics(model, at.loops, at.q, at.v, at.tau, a, lambda).ok());
    const double size = 1 + expected.head(n).norm();
    EXPECT_LT((vector(a) - expected.head(n)).norm(), 1e-9 * size);
    const VectorXd forces = product(MatrixXd(A.transpose()), vector(lambda));
    EXPECT_LT((forces - A.transpose() * expected.tail(m)).norm(), 1e-8 * (1 + forces.norm()));
    EXPECT_LT((A * vector(a) + bias_of(model, at)).norm(), 1e-9 * size);
  }
}

TEST_P(ClosedMechanisms, MoveTheSameWithALoopTwice) {
  Description twice = model.description();
  twice.loops.push_back(twice.loops[0]);
  twice.loops.back().name = "again";
  const Model doubled = ModelBuilder(twice).build();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed), there(doubled, seed);
    there.q = at.q, there.v = at.v;
    const VectorXd a = acceleration_of(model, at, at.tau);
    EXPECT_LT((acceleration_of(doubled, there, at.tau) - a).norm(), 1e-10 * (1 + a.norm()));
    EXPECT_EQ(loop_mobility(doubled, at.q).degrees_of_freedom, GetParam().freedom);
  }
}

/// A second copy of the mechanism with bodies that are 1e9 times as light changes nothing, because the size
/// of each row is judged relative to the masses that it moves.
TEST_P(ClosedMechanisms, MoveTheSameBesideOnesOfAnotherScale) {
  Description both = model.description();
  const Description light = model.description();
  for (BodyDescription body : light.bodies) {
    body.name += " light";
    if (body.predecessor != "ground") body.predecessor += " light";
    body.inertia->mass *= 1e-9, body.inertia->Theta = 1e-9 * body.inertia->Theta;
    both.bodies.push_back(std::move(body));
  }
  for (LoopDescription loop : light.loops) {
    loop.name += " light";
    for (std::string& name : loop.between)
      if (name != "ground") name += " light";
    both.loops.push_back(std::move(loop));
  }
  for (std::size_t k = 0; k < light.loops.size(); ++k)
    both.loops[k].name = "loop of one, " + std::to_string(k);
  for (std::size_t k = light.loops.size(); k < both.loops.size(); ++k)
    both.loops[k].name = "loop of two, " + std::to_string(k);
  const Model two = ModelBuilder(both).build();
  ClosedState at(model, 1);
  LoopWorkspace<double> workspace(two);
  const auto twice = [](const Numbers& x, double scale = 1) {
    Numbers out(x);
    for (const double x_k : x) out.push_back(scale * x_k);
    return out;
  };
  Numbers a(2 * at.v.size());
  ASSERT_TRUE(forward_dynamics(two, workspace, twice(at.q), twice(at.v), twice(at.tau, 1e-9), a).ok());
  const VectorXd one = acceleration_of(model, at, at.tau);
  const auto n = static_cast<Eigen::Index>(at.v.size());
  EXPECT_LT((vector(a).head(n) - one).norm(), 1e-9 * (1 + one.norm()));
  EXPECT_LT((vector(a).tail(n) - one).norm(), 1e-8 * (1 + one.norm()));
}

/// A coupled pair of joints beside the mechanism makes the library use other recursions; these must give the
/// same motion.
TEST_P(ClosedMechanisms, MoveTheSameBesideCoupledJoints) {
  Description both = model.description();
  for (const char* name : {"leader", "follower"})
    both.bodies.push_back({.name = name,
                           .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}},
                           .inertia = MassProperties{.mass = 1, .com = {1, 0, 0}, .Theta = {1, 1, 1}}});
  both.bodies.back().joint.coupling = Coupling{"leader_joint", 2};
  const Model coupled = ModelBuilder(both).build();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    Random<double> random(seed);
    std::vector<AppliedWrench<>> wrenches;
    for (const Representation in : representations)
      wrenches.emplace_back(1, in, random.vector(), random.vector());
    const Loads<> loads{wrenches, true};
    const auto beside = [&](Numbers x) {
      x.push_back(0);
      return x;
    };
    LoopWorkspace<double> workspace(coupled);
    Numbers a(at.v.size()), a_both(a.size() + 1), lambda(static_cast<std::size_t>(model.loops().rows)),
        lambda_both(lambda.size());
    ASSERT_TRUE(forward_dynamics(model, at.loops, at.q, at.v, at.tau, a, lambda, loads).ok());
    ASSERT_TRUE(forward_dynamics(coupled, workspace, beside(at.q), beside(at.v), beside(at.tau), a_both,
                                 lambda_both, loads)
                    .ok());
    a_both.pop_back();
    EXPECT_LT((vector(a_both) - vector(a)).norm(), 1e-10 * (1 + vector(a).norm()));
    const MatrixXd A = jacobian_of(model, at);
    const VectorXd forces = A.transpose() * vector(lambda);
    EXPECT_LT((A.transpose() * vector(lambda_both) - forces).norm(), 1e-9 * (1 + forces.norm()));
  }
}

TEST_P(ClosedMechanisms, AreDrivenAsTheyMove) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    for (std::size_t c = 0; c < at.tau.size(); ++c)
      if (!model.loops().driven[c]) at.tau[c] = 0;
    const VectorXd a = acceleration_of(model, at, at.tau);
    Numbers tau(at.v.size()), lambda(static_cast<std::size_t>(model.loops().rows));
    EXPECT_LT(inverse_dynamics(model, at.loops, at.q, at.v, numbers(a), tau, lambda), 1e-9);
    EXPECT_LT((acceleration_of(model, at, tau) - a).norm(), 1e-7 * (1 + a.norm()));
    EXPECT_LE(vector(tau).norm(), vector(at.tau).norm() * (1 + 1e-9)) << "the least forces that do it";

    std::vector<int> drives;  // as many as there are degrees of freedom
    for (int c = 0; c < GetParam().freedom; ++c) drives.push_back(c);
    EXPECT_LT(inverse_dynamics(model, at.loops, at.q, at.v, numbers(a), tau, {}, drives), 1e-8);
    for (std::size_t c = drives.size(); c < tau.size(); ++c) EXPECT_EQ(tau[c], 0);
    EXPECT_LT((acceleration_of(model, at, tau) - a).norm(), 1e-6 * (1 + a.norm()));
  }
}

TEST_P(ClosedMechanisms, AreDrivenAgainstForcesThatActBesides) {
  ClosedState at(model, 2);
  Random<double> random(7);
  const Numbers besides = random_numbers(random, model.nv(), 10);
  const VectorXd a = acceleration_of(model, at, at.tau);
  Numbers tau(at.v.size());
  EXPECT_LT(inverse_dynamics(model, at.loops, at.q, at.v, numbers(a), tau, {}, {}, {}, besides), 1e-9);
  EXPECT_LT((acceleration_of(model, at, numbers(vector(tau) + vector(besides))) - a).norm(),
            1e-7 * (1 + a.norm()));
  EXPECT_GT((acceleration_of(model, at, tau) - a).norm(), 1e-3);
}

TEST_P(ClosedMechanisms, AreNotDrivenWhereLoopsTear) {
  ClosedState at(model, 2);
  const VectorXd a = acceleration_of(model, at, at.tau);
  const MatrixXd A = jacobian_of(model, at);
  const VectorXd apart = A.transpose() * (A * VectorXd::Ones(model.nv()));
  Numbers tau(at.v.size());
  const auto refusal = [&](const VectorXd& of) -> std::string {
    try {
      static_cast<void>(inverse_dynamics(model, at.loops, at.q, at.v, numbers(of), tau));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(a), "");
  const double size = 1 + a.norm() + vector(at.v).squaredNorm();
  EXPECT_EQ(refusal(a + 1e-4 * size / (A * apart).norm() * apart), "") << "accelerations that were measured";
  EXPECT_THAT(refusal(a + 1e-2 * size / (A * apart).norm() * apart),
              testing::StartsWith("a does not keep loop \""));
  EXPECT_THAT(refusal(a + apart), testing::StartsWith("a does not keep loop \""));
  at.q = integrate(model, at.q, numbers(apart));
  EXPECT_THAT(refusal(a), testing::StartsWith("q leaves loop \"")) << "which is why";
}

/// Squares of velocities and accelerations above 1e154 are not representable.
TEST_P(ClosedMechanisms, RefuseMotionsThatOpenLoopsHoweverFastTheyAre) {
  ClosedState at(model, 2);
  LoopSystem<double>& system = at.loops.system(model);
  const MatrixXd A = jacobian_of(model, at);
  const VectorXd apart = (A.transpose() * (A * VectorXd::Ones(model.nv()))).normalized(),
                 a = acceleration_of(model, at, at.tau);
  Numbers tau(at.v.size());
  const auto at_velocity = [&](const VectorXd& v) { check_closed(system, at.q, numbers(v)); };
  const auto at_acceleration = [&](const VectorXd& a_apart) {
    static_cast<void>(inverse_dynamics(model, at.loops, at.q, at.v, numbers(a_apart), tau));
  };
  const auto refuses = [](const char* what) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith(what));
  };
  for (const double size : {1e-310, 1e-160, 1.0, 1e160, 1e300})
    EXPECT_NO_THROW(at_velocity(size * vector(at.v))) << size;
  for (const double size : {1.0, 1e160, 1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT([&] { at_velocity(size * apart); }, refuses("v does not keep loop \"")) << size;
    EXPECT_THAT([&] { at_acceleration(a + size * apart); }, refuses("a does not keep loop \"")) << size;
  }
}

TEST(Drives, AreTooFewHoweverLargeTheForcesAre) {
  const Model model = ModelBuilder(gough()).build();
  LoopWorkspace<double> loops(model);
  const auto nv = static_cast<std::size_t>(model.nv());
  const Numbers q = assemble(model, neutral(model)).q, rest(nv);
  const auto first = std::ranges::find_if(model.loops().driven, [](char is) { return is != 0; });
  const std::vector<int> one{static_cast<int>(first - model.loops().driven.begin())};
  for (const double k : {1e3, 1e200}) {
    Numbers tau(nv), a(nv);
    for (std::size_t c = 0; c < nv; ++c) tau[c] = model.loops().driven[c] ? k : 0;
    ASSERT_TRUE(forward_dynamics(model, loops, q, rest, tau, a).ok());
    EXPECT_GT(inverse_dynamics(model, loops, q, rest, a, tau, {}, one), 0.1) << k;
  }
}

TEST(Couplings, AreNotDrivenApart) {
  Description two;
  for (const char* name : {"one", "other"})
    two.bodies.push_back(
        {.name = name,
         .joint = {.name = std::string(name) + "_joint", .kind = JointKind::revolute},
         .inertia = MassProperties{.mass = 1, .com = {1, 0, 0}, .Theta = {1, 1, 1, 0, 0, 0}}});
  two.couplings.push_back({.name = "gears", .terms = {{"one_joint", 1.0}, {"other_joint", 2.0}}});
  const Model model = ModelBuilder(two).build();
  LoopWorkspace<double> workspace(model);
  const Numbers rest(2);
  Numbers tau(2);
  EXPECT_LT(inverse_dynamics(model, workspace, rest, rest, Numbers{2, -1}, tau), 1e-9);
  EXPECT_THAT(
      [&] {
        static_cast<void>(inverse_dynamics(model, workspace, rest, rest, Numbers{2, 0}, tau));
      },
      testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith(
          "a does not keep loop \"gears\" closed: A a + gamma is 2 (rad/s^2 and m/s^2)")));
  EXPECT_THAT(
      [&] {
        check_closed(workspace.system(model), Numbers{1e300, 0}, rest);
      },
      testing::ThrowsMessage<std::invalid_argument>(
          testing::StartsWith("q leaves loop \"gears\" open by 1e+300 (rad and m); ")));
}

TEST_P(ClosedMechanisms, LoseTheEnergyOfAnImpact) {
  for (const double e : {0.0, 0.4, 1.0}) {
    ClosedState at(model, 3);
    Random<double> random(4);
    at.v = random_numbers(random, model.nv());  // velocities with which the loops do not stay closed
    const MatrixXd A = jacobian_of(model, at), M = mass_of(model, at);
    Numbers after(at.v.size());
    ASSERT_TRUE(impact(model, at.loops, at.q, at.v, e, after).ok());
    EXPECT_LT((A * (vector(after) + e * vector(at.v))).norm(), 1e-9);
    const VectorXd change = vector(after) - vector(at.v), mean = 0.5 * (vector(after) + vector(at.v));
    const double lost = -change.dot(M * mean);
    EXPECT_GE(lost, -1e-9);
    if (e == 1) {
      EXPECT_NEAR(lost, 0, 1e-9 * (1 + vector(at.v).dot(M * vector(at.v))));
    }
  }
}

/// ṙ = R v and d/dt (A v) = A a + γ, at closed configurations and at others.
TEST_P(ClosedMechanisms, HaveTheRatesOfDifferences) {
  for_seeds(10, [&](std::uint64_t seed) {
    ClosedState at(model, seed);
    Random<double> random(seed + 7);
    const Numbers q = integrate(model, at.q, random_numbers(random, model.nv(), 0.05));
    const Numbers v = random_numbers(random, model.nv());
    const double h = 1e-3;
    const auto moved = [&](double t) {
      return integrate(model, q, numbers(t * vector(v)));  // v is constant, so that a = 0
    };
    const auto difference = [&](const auto& f) -> VectorXd {
      return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
    };
    Numbers r(static_cast<std::size_t>(model.loops().residuals)), R(r.size() * v.size());
    loop_residual_jacobian(model, at.loops, q, R);
    const VectorXd rate = difference([&](double t) {
      loop_residual(model, at.loops, moved(t), r);
      return vector(r);
    });
    EXPECT_LT((matrix(static_cast<int>(r.size()), R) * vector(v) - rate).norm(), 1e-8);
    Numbers gamma(static_cast<std::size_t>(model.loops().rows)), A(gamma.size() * v.size());
    const VectorXd slip = difference([&](double t) {
      loop_jacobian(model, at.loops, moved(t), A);
      return VectorXd(matrix(static_cast<int>(gamma.size()), A) * vector(v));
    });
    loop_bias(model, at.loops, q, v, gamma);
    EXPECT_LT((vector(gamma) - slip).norm(), 1e-8 * (1 + slip.norm()));
  });
}

struct Derivatives {
  Derivatives(const Model& model, ClosedState& at, const Loads<>& loads = {})
      : n(static_cast<std::size_t>(model.nv())), m(static_cast<std::size_t>(model.loops().rows)) {
    for (Numbers* x : {&a_q, &a_v, &a_tau}) x->resize(n * n);
    for (Numbers* x : {&l_q, &l_v, &l_tau}) x->resize(m * n);
    EXPECT_TRUE(forward_dynamics_derivatives(model, at.loops, at.q, at.v, at.tau,
                                             {a_q, a_v, a_tau, l_q, l_v, l_tau}, loads)
                    .ok());
  }
  VectorXd times(const Numbers& D, const VectorXd& x) const {
    return matrix(static_cast<int>(D.size() / n), D) * x;
  }
  std::size_t n, m;
  Numbers a_q, a_v, a_tau, l_q, l_v, l_tau;
};

/// All mechanisms but Bricard's, whose rank changes when its loop opens; the derivatives along motions are
/// tested for it.
class OpenedMechanisms : public testing::TestWithParam<Mechanism_> {};

TEST_P(OpenedMechanisms, HaveDerivativesThatAreLimitsOfDifferences) {
  Description damped = GetParam().drawn();
  for (BodyDescription& body : damped.bodies)
    body.joint.dof.assign(static_cast<std::size_t>(traits(body.joint.kind).dof), {.damping = 0.7});
  const Model model = ModelBuilder(damped).build();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    Random<double> random(seed);
    const Numbers x = random_numbers(random, model.nv());
    State<double> pushed = random_state(model, random);
    const Loads<> loads{pushed.wrenches, seed % 2 == 1};
    const Derivatives d(model, at, loads);
    const auto difference = [&](const auto& move) -> VectorXd {
      const double h = 1e-4;
      const auto a = [&](double t) {
        Numbers q = at.q, v = at.v, tau = at.tau, found(v.size());
        move(q, v, tau, VectorXd(t * vector(x)));
        EXPECT_TRUE(forward_dynamics(model, at.loops, q, v, tau, found, {}, loads).ok());
        return vector(found);
      };
      return (8 * (a(h) - a(-h)) - (a(2 * h) - a(-2 * h))) / (12 * h);
    };
    const auto add = [](Numbers& to, const VectorXd& step) { to = numbers(vector(to) + step); };
    const VectorXd along_tau =
        difference([&](Numbers&, Numbers&, Numbers& tau, const VectorXd& s) { add(tau, s); });
    const VectorXd along_v =
        difference([&](Numbers&, Numbers& v, Numbers&, const VectorXd& s) { add(v, s); });
    const VectorXd along_q = difference(
        [&](Numbers& q, Numbers&, Numbers&, const VectorXd& s) { q = integrate(model, q, numbers(s)); });
    const double bound = 1e-6;
    EXPECT_LT((d.times(d.a_tau, vector(x)) - along_tau).norm(), bound * (1 + along_tau.norm()));
    EXPECT_LT((d.times(d.a_v, vector(x)) - along_v).norm(), bound * (1 + along_v.norm()));
    EXPECT_LT((d.times(d.a_q, vector(x)) - along_q).norm(), bound * (1 + along_q.norm()));
  }
}

/// The accelerations change as ∂a/∂q v + ∂a/∂v a along a motion, which keeps the loops closed.
TEST_P(ClosedMechanisms, HaveDerivativesAlongTheirMotions) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    ClosedState at(model, seed);
    const VectorXd a = acceleration_of(model, at, at.tau);
    const Derivatives d(model, at);
    const double h = 1e-3;
    SimulationOptions options;
    const auto later = [&](double t) -> VectorXd {  // for negative t, the same motion backwards
      Numbers v = numbers(t > 0 ? vector(at.v) : -vector(at.v));
      options.drive = [&](double, auto, auto, std::span<double> tau) {
        std::ranges::copy(at.tau, tau.begin());
      };
      const Trajectory motion =
          simulate_fixed(model, at.q, v, std::abs(t), std::abs(t) / 4, runge_kutta(4), options);
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      return vector({motion.a().end() - model.nv(), motion.a().end()});
    };
    const VectorXd rate = (8 * (later(h) - later(-h)) - (later(2 * h) - later(-2 * h))) / (12 * h);
    const VectorXd said = d.times(d.a_q, vector(at.v)) + d.times(d.a_v, a);
    EXPECT_LT((said - rate).norm(), 1e-5 * (1 + rate.norm()));
  }
}

INSTANTIATE_TEST_SUITE_P(, ClosedMechanisms, testing::ValuesIn(mechanisms),
                         [](const auto& info) { return std::string(info.param.name); });

INSTANTIATE_TEST_SUITE_P(, OpenedMechanisms, testing::Values(mechanisms[0], mechanisms[2], mechanisms[3]),
                         [](const auto& info) { return std::string(info.param.name); });

/// The redundant rows of a four-bar in space, named by the wrenches that they could carry without any load.
TEST(RedundantRows, AreNamedByTheirWrenches) {
  const Model model = ModelBuilder(four_bar(SO3<>{})).build();
  const LoopMobility found = loop_mobility(model, neutral(model));
  ASSERT_EQ(found.redundant.size(), 3U);
  EXPECT_EQ(found.redundant[0].wrench, "couple about (1, 0, 0)");
  EXPECT_EQ(found.redundant[1].wrench, "couple about (0, 1, 0)");
  EXPECT_EQ(found.redundant[2].wrench.substr(0, 21), "force along (0, 0, 1)");
}

/// The points of a drawing are rounded, so that a loop which repeats a hinge may lie beside its axis.
TEST(RedundantRows, LeaveARepeatedHingeFreeWhateverItsRounding) {
  const Vec3<> axis{0, 1, 0};
  const Numbers q{0.3}, v{2}, tau{0};
  for (const double length : {1e-3, 1.0, 1e3})
    for (const Vec3<>& place : {Vec3<>{}, Vec3<>{50, -70, 30}})
      for (const double beside : {0.0, 1e-17, 1e-16, 1e-15, 1e-14}) {
        SCOPED_TRACE(testing::Message() << beside << " at " << place.x << ", lengths x " << length);
        const Vec3<> p = length * place;
        Description d{.name = "hinge", .gravity = {0, 0, -9.81}, .bodies = {}, .frames = {}};
        d.bodies.push_back(bar("arm", "ground", JointKind::revolute, axis, p, p + length * Vec3<>{1, 0, 0}));
        const Model once = ModelBuilder(d).build();
        d.loops.push_back(
            {.between = {"ground", "arm"}, .axis = axis, .point = p + length * beside * Vec3<>{1, 0, 0}});
        const Model twice = ModelBuilder(d).build();
        Workspace<double> alone(once);
        LoopWorkspace<double> loops(twice);
        Numbers expected(1), a(1), lambda(5);
        ASSERT_TRUE(forward_dynamics(once, alone, q, v, tau, expected).ok());
        ASSERT_TRUE(forward_dynamics(twice, loops, q, v, tau, a, lambda).ok());
        EXPECT_NEAR(a[0], expected[0], 1e-12 * std::abs(expected[0]));
        EXPECT_EQ(largest(lambda), 0) << "no wrench acts at the loop";
      }
}

/// A nut on two parallel threads is constrained twice; the redundant wrench is a force along the threads with
/// a couple that depends on their pitch.
TEST(RedundantRows, AreNamedWithTheirPitch) {
  Description d{.name = "nut"};
  d.bodies.push_back({.name = "nut",
                      .joint = {.kind = JointKind::helical, .axis = {0, 0, 1}, .pitch = 0.125},
                      .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}});
  d.loops.push_back(
      {.between = {"ground", "nut"}, .kind = LoopKind::helical, .axis = {0, 0, 1}, .pitch = 0.125});
  const Model model = ModelBuilder(d).build();
  const LoopMobility found = loop_mobility(model, neutral(model));
  ASSERT_EQ(found.redundant.size(), 5U);
  std::string wrenches;
  for (const RedundantRow& row : found.redundant) wrenches += row.wrench + "; ";
  EXPECT_THAT(wrenches,
              testing::ContainsRegex("force along \\(0, 0, -?1\\) through [^;]* with pitch -0\\.125"));
  EXPECT_THAT(wrenches, testing::Not(testing::HasSubstr("pitch 0.125")));
}

TEST(SecondOrder, TellsBranchesFromShakes) {
  const Vec3<> z{0, 0, 1};
  const Model flat = ModelBuilder(ring({{0, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 0, 0}}, {z, z, z, z})).build();
  const double quarter = std::acos(0.0);
  const Numbers lying{-quarter, quarter, -quarter};
  Numbers r(5);
  LoopWorkspace<double> workspace(flat);
  loop_residual(flat, workspace, lying, r);
  EXPECT_LT(vector(r).norm(), 1e-12);
  const LoopMobility branching = loop_mobility(flat, lying);
  EXPECT_EQ(branching.degrees_of_freedom, 2);
  EXPECT_EQ(branching.mobility, Mobility::branches);

  for (const double way : {1.0, -1.0}) {  // the quadratic form of the dependency is definite, with either
                                          // sign of it
    const Model line = ModelBuilder(ring({{0, 0, 0}, {way, 0, 0}, {2 * way, 0, 0}}, {z, z, z})).build();
    const LoopMobility shaking = loop_mobility(line, neutral(line));
    EXPECT_EQ(shaking.degrees_of_freedom, 1);
    EXPECT_EQ(shaking.mobility, Mobility::shaky);
  }
}

TEST(Assembly, SaysThatHeldVelocitiesDoNotKeepLoopsClosed) {
  const Model model = ModelBuilder(four_bar()).build();
  const std::array<int, 2> two{0, 1};
  const std::array<int, 1> one{0};
  AssemblyOptions options;
  for (const double speed : {1.0, 1e160, 1e300}) {  // squares above 1e154 are not representable
    const Numbers v{speed, speed, 0};
    options.held = one;
    EXPECT_EQ(assemble(model, neutral(model), v, options).status, AssemblyStatus::closed) << speed;
    options.held = two;
    const AssemblyResult found = assemble(model, neutral(model), v, options);
    EXPECT_EQ(found.status, AssemblyStatus::held_velocities) << speed;
    EXPECT_EQ(to_string(model, found).find("the loops are closed, but no velocities with the held ones"), 0U);
  }
}

/// No form of two shaky loops in one model is definite, but their sum is.
TEST(SecondOrder, FindsAModelOfTwoShakyLoopsShaky) {
  const Vec3<> z{0, 0, 1};
  const Model one = ModelBuilder(ring({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {z, z, z})).build();
  const Model both = append(one, "ground", one, "other ");
  const LoopMobility found = loop_mobility(both, neutral(both));
  EXPECT_EQ(found.degrees_of_freedom, 2);
  EXPECT_EQ(found.mobility, Mobility::shaky);
}

TEST(Rolling, SphereDownASlopeHasFiveSeventhsOfTheAcceleration) {
  const double slope = 0.3;
  const Model model = ModelBuilder(wheel(true, {9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)})).build();
  LoopWorkspace<double> workspace(model);
  Numbers a(6), lambda(3);
  ASSERT_TRUE(forward_dynamics(model, workspace, neutral(model), Numbers(6), Numbers(6), a, lambda).ok());
  EXPECT_NEAR(a[3] + .3 * a[1], 5.0 / 7 * 9.81 * std::sin(slope), 1e-12);
  EXPECT_NEAR(lambda[0], 2 * 9.81 * std::cos(slope), 1e-10) << "the ground carries its weight";
}

TEST(Rolling, RowsHaveTheRatesOfDifferences) {
  for (const bool sphere : {true, false}) {
    const Model model = ModelBuilder(wheel(sphere)).build();
    LoopWorkspace<double> workspace(model);
    for_seeds(10, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Numbers q = integrate(model, neutral(model), random_numbers(random, 6, 0.4));
      const Numbers v = random_numbers(random, 6);
      const auto difference = [&](const auto& f) -> VectorXd {
        const double h = 1e-3;
        const auto at = [&](double t) { return f(integrate(model, q, numbers(t * vector(v)))); };
        return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
      };
      Numbers r(1), A(18), R(6), gamma(3);
      const VectorXd rate = difference([&](const Numbers& there) {
        loop_residual(model, workspace, there, r);
        return vector(r);
      });
      loop_residual_jacobian(model, workspace, q, R);
      EXPECT_NEAR((matrix(1, R) * vector(v))[0], rate[0], 1e-9);
      const VectorXd slip = difference([&](const Numbers& there) {
        loop_jacobian(model, workspace, there, A);
        return VectorXd(matrix(3, A) * vector(v));
      });
      loop_bias(model, workspace, q, v, gamma);
      EXPECT_LT((vector(gamma) - slip).norm(), 1e-8 * (1 + slip.norm()));
    });
  }
}

/// Mechanisms with a linear coupling of coordinates move like trees in which a joint follows another one.
TEST(LinearCouplings, MoveAsJointsThatFollow) {
  const auto tree = [](bool follows) {
    Description d =
        ring({{0, 0, 0}, {0, 1, 0}, {2, 2, 0}, {3, 0, 0}}, {{0, 0, 1}, {0, 0, 1}, {0, 1, 1}, {0, 0, 1}});
    d.loops.clear();
    if (follows) {
      d.bodies[2].joint.coupling = Coupling{"bar0_joint", -1.5, 0.25};
    } else {
      d.couplings.push_back({.terms = {{"bar2_joint", 1}, {"bar0_joint", 1.5}}, .offset = 0.25});
    }
    return ModelBuilder(d).build();
  };
  const Model following = tree(true), coupled = tree(false);
  Workspace<double> workspace(following);
  LoopWorkspace<double> loops(coupled);
  const Numbers q{0.3, -0.4}, v{1, 2}, tau{3, 4};
  const Numbers q_3{0.3, -0.4, -1.5 * 0.3 + 0.25}, v_3{1, 2, -1.5}, tau_3{3, 4, 0};
  Numbers a(2), a_3(3), r(1);
  ASSERT_TRUE(forward_dynamics(following, workspace, q, v, tau, a).ok());
  ASSERT_TRUE(forward_dynamics(coupled, loops, q_3, v_3, tau_3, a_3).ok());
  EXPECT_NEAR(a_3[0], a[0], 1e-11);
  EXPECT_NEAR(a_3[1], a[1], 1e-11);
  EXPECT_NEAR(a_3[2], -1.5 * a[0], 1e-11);
  loop_residual(coupled, loops, q_3, r);
  EXPECT_NEAR(r[0], 0, 1e-15);
}

Description displaced_by(const Vec3<>& D, Description d) {
  for (BodyDescription& body : d.bodies) {
    body.joint.point += D, body.inertia->com += D;
    if (body.joint.kind == JointKind::free) body.geometry = InConstructionFrame{{{}, D}};
  }
  for (LoopDescription& loop : d.loops) loop.point += D;
  return d;
}

TEST(FarLoops, LoseNothing) {
  const Model here = ModelBuilder(gough()).build(),
              there = ModelBuilder(displaced_by({12000, -5000, 300}, gough())).build();
  ClosedState at(here, 2);
  Numbers q = at.q;  // the pose of a free joint is relative to the pose in which its body was drawn
  LoopWorkspace<double> workspace(there);
  Numbers r(static_cast<std::size_t>(there.loops().residuals)), a(at.v.size());
  loop_residual(there, workspace, q, r);
  EXPECT_LT(vector(r).norm(), 2e-11) << "1e-12 m is what is left of a double at 12 km";
  ASSERT_TRUE(forward_dynamics(there, workspace, q, at.v, at.tau, a).ok());
  const VectorXd expected = acceleration_of(here, at, at.tau);
  EXPECT_LT((vector(a) - expected).norm(), 1e-8 * (1 + expected.norm()));
}

TEST(Assembly, ClosesFromGuesses) {
  for (const auto& [name, drawn, rows, rank, freedom] : mechanisms) {
    SCOPED_TRACE(name);
    const Model model = ModelBuilder(drawn()).build();
    int closed = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Random<double> random(seed);
      const Numbers guess = integrate(model, neutral(model), random_numbers(random, model.nv(), 0.7));
      const AssemblyResult found = assemble(model, guess);
      if (found.status != AssemblyStatus::closed) continue;
      ++closed;
      EXPECT_LT(found.residual, 1e-11);
    }
    EXPECT_GE(closed, std::string(name) == "Bricard" ? 14 : 19);
  }
}

TEST(Assembly, HoldsWhatIsHeld) {
  const Model model = ModelBuilder(four_bar()).build();
  const std::vector<int> held{0};
  const AssemblyResult found = assemble(model, Numbers{0.4, 0, 0}, Numbers{2, 0, 0}, {.held = held});
  ASSERT_EQ(found.status, AssemblyStatus::closed) << to_string(model, found);
  EXPECT_EQ(found.q[0], 0.4);
  EXPECT_EQ(found.v[0], 2);
  LoopWorkspace<double> workspace(model);
  Numbers A(15);
  loop_jacobian(model, workspace, found.q, A);
  EXPECT_LT((matrix(5, A) * vector(found.v)).norm(), 1e-10);
}

TEST(Assembly, DoesNotCallClosedWhatOverflows) {
  const Model model = ModelBuilder(gough()).build();
  Numbers guess = neutral(model);
  guess.back() = 1e300;
  const AssemblyResult found = assemble(model, guess);
  EXPECT_EQ(found.status, AssemblyStatus::open);
  EXPECT_THAT(to_string(model, found), testing::HasSubstr("loop \"loop 6\" stays open by"));
}

TEST(ClosedResults, NeedMemoryOfTheirOwn) {
  const Model model = ModelBuilder(four_bar()).build();
  LoopWorkspace<double> workspace(model);
  const Numbers q(3), tau(3);
  Numbers both(8);
  const std::span<double> a(both.data(), 3), lambda(both.data() + 2, 5);
  EXPECT_THROW(static_cast<void>(forward_dynamics(model, workspace, q, tau, tau, a, lambda)),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(inverse_dynamics(model, workspace, q, tau, tau, a, lambda)),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(impact(model, workspace, q, a, 0.0, a, lambda)), std::invalid_argument);
  Numbers in_place{1, 2, 3}, apart(3);
  const Numbers v = in_place;
  ASSERT_TRUE(impact(model, workspace, q, v, 0.0, apart).ok());
  ASSERT_TRUE(impact(model, workspace, q, in_place, 0.0, in_place).ok());
  EXPECT_EQ(in_place, apart);
}

/// Residuals are computed with the rounding errors of their terms, and the search must reach residuals of
/// that size.
TEST(Assembly, ClosesToTheRoundingOfItsTerms) {
  for (const Description& d : {slider_crank(), gough()}) {
    SCOPED_TRACE(d.name);
    const Model model = ModelBuilder(displaced_by({1e8, -4e7, 3e6}, d)).build();
    Random<double> random(1);
    for (int trial = 0; trial < 10; ++trial) {
      const Numbers guess = integrate(model, neutral(model), random_numbers(random, model.nv(), 0.1));
      const AssemblyResult found = assemble(model, guess);
      EXPECT_EQ(found.status, AssemblyStatus::closed) << to_string(model, found);
      EXPECT_LT(found.residual, 1e-6) << "1e-8 m is what is left of a double at 1e8 m";
      EXPECT_LT(found.iterations, 30);
    }
  }
}

TEST(Assembly, CallsAStretchedGuessSingular) {
  const Vec3<> z{0, 0, 1};
  Description d = ring({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {z, z, z});
  d.loops[0].frames = {SE3<>{{}, {2, 0, 0}}, SE3<>{{}, {1.9, 0, 0}}};
  const Model model = ModelBuilder(d).build();
  const AssemblyResult stretched = assemble(model, Numbers{0, 0});
  EXPECT_EQ(stretched.status, AssemblyStatus::singular_guess);
  EXPECT_THAT(to_string(model, stretched), testing::HasSubstr("the guess is singular, stretched or folded"));
  EXPECT_THAT(to_string(model, stretched), testing::HasSubstr("loop \"loop 1\" stays open by 0.1"));
  EXPECT_THAT(to_string(model, stretched), testing::HasSubstr("turn one of its joints a little"));
  EXPECT_EQ(assemble(model, Numbers{0.1, 0}).status, AssemblyStatus::closed);
}

TEST(Assembly, SaysWhichLoopStaysOpen) {
  Description d = slider_crank();
  d.loops[0].frames = {SE3<>{{}, {2, 0, 0}}, SE3<>{{}, {2, 9, 0}}};  // nine metres off the slider's axis
  const Model model = ModelBuilder(d).build();
  const AssemblyResult found = assemble(model, neutral(model));
  EXPECT_EQ(found.status, AssemblyStatus::open);
  EXPECT_GT(found.residual, 1);
  EXPECT_THAT(to_string(model, found),
              testing::HasSubstr("does not close from this guess: loop \"pin\" stays open by"));
}

}  // namespace
}  // namespace axode::test
