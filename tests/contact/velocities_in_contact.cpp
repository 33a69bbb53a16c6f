#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/contact/law/contact_dynamics.hpp"
#include "axode/dynamics/momentum/momentum.hpp"
#include "axode/kinematics/twists.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/support/random_loops.hpp"
#include "tests/support/refused_arguments.hpp"

/// Laws of velocities under contact, for random trees and loops with random contacts.
namespace axode::test {
namespace {

struct ContactTrial {
  ClosedMechanism mechanism;
  std::vector<Contact> contacts;
  double h = 1e-2;
};

/// A mechanism with loops and couplings, and contacts of any two bodies.
ContactTrial random_trial(std::uint64_t seed, int contacts = 4) {
  Random<double> random(seed);
  ContactTrial trial{closed_mechanism(random, {.most_bodies = 8, .friction = seed % 2 == 0}), {}};
  const Model& model = trial.mechanism.model;
  const auto body = [&] {
    const double x = (random_numbers(random, 1)[0] + 1) / 2;
    return std::min(static_cast<int>(x * (model.n_bodies() + 1)), model.n_bodies());
  };
  while (static_cast<int>(trial.contacts.size()) < contacts) {
    Contact contact{.a = body(), .b = body(), .point = random.vector()};
    const Vec3<> n = random.vector();
    if (contact.a == contact.b || norm(n) < 0.1) continue;
    contact.normal = (1 / norm(n)) * n;
    const std::vector<double> mu = random_numbers(random, 3);
    contact.surface = {.friction = std::abs(mu[0]) / 2,
                       .spin_friction = std::abs(mu[1]) / 20,
                       .rolling_friction = std::abs(mu[2]) / 20};
    trial.contacts.push_back(contact);
  }
  return trial;
}

ContactStatus solve(ContactDynamics& dynamics, const ContactTrial& trial) {
  const auto& [q, v, a, wrenches] = trial.mechanism.state;
  return dynamics.solve(q, v, trial.mechanism.tau, trial.contacts, {.h = trial.h});
}

/// f(trial, dynamics, status) for random mechanisms, solved.
template <class F> void each_trial(int rows, const F& f) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const ContactTrial trial = random_trial(seed);
    ContactDynamics dynamics(trial.mechanism.model, rows);
    const ContactStatus status = solve(dynamics, trial);
    ASSERT_TRUE(status.mass_matrix.ok());
    f(trial, dynamics, status);
  }
}

TEST(ContactLaws, RowsAreRelativeVelocitiesOfThePoint) {
  Comparison rows("J v", 1e-12);
  each_trial(6, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus&) {
    const Model& model = trial.mechanism.model;
    Workspace<> workspace(model, cut_tree);
    std::vector<Twist<Spatial>> V(static_cast<std::size_t>(model.n_frames()));
    const std::vector<double>&q = trial.mechanism.state.q, &v = trial.mechanism.state.v;
    twists<Spatial, double>(model, workspace, q, v, V);
    std::vector<double> u(static_cast<std::size_t>(dynamics.system().problem().rows())), expected;
    dynamics.system().times(v.data(), u.data());
    for (const Contact& c : trial.contacts) {
      const Twist<Spatial> X = V[static_cast<std::size_t>(c.b)] - V[static_cast<std::size_t>(c.a)];
      const Vec3<> at_point = X.v + cross(X.w, c.point);
      const auto& [n, t1, t2] = contact_frame(c.normal);
      for (const Vec3<>& e : {n, t1, t2}) expected.push_back(dot(e, at_point));
      for (const Vec3<>& e : {n, t1, t2}) expected.push_back(dot(e, X.w));
    }
    u.resize(expected.size());
    rows.expect_equal(u, expected, 1);
  });
}

TEST(ContactLaws, YIsTheResponseOfTheMassMatrix) {
  Comparison responses("J M^-1 p", 1e-8), velocities("velocity", 1e-8);
  each_trial(3, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus&) {
    const Model& model = trial.mechanism.model;
    Workspace<> workspace(model, cut_tree);
    const std::vector<double>& q = trial.mechanism.state.q;
    VelocityProblem& problem = dynamics.system().problem();
    const std::size_t m = problem.r.size(), nv = static_cast<std::size_t>(model.nv());
    const std::vector<double>& p = trial.mechanism.state.a;
    std::vector<double> v(nv), x(nv), direct(m), by_Y(m);
    ASSERT_TRUE(from_momenta<double>(model, workspace, q, p, v).ok());
    dynamics.system().times(v.data(), direct.data());
    dynamics.system().pull(p.data(), x.data());
    problem.add_transposed(x.data(), by_Y.data());
    for (std::size_t k = 0; k < m; ++k) direct[k] *= problem.c[k];
    responses.expect_equal(by_Y, direct);
    // v⁺ = free velocity + M⁻¹ Jᵀ λ
    ASSERT_TRUE(from_momenta<double>(model, workspace, q, dynamics.generalized_impulse(), v).ok());
    for (std::size_t c = 0; c < nv; ++c) v[c] += dynamics.free_velocity()[c];
    velocities.expect_equal(to_vector(dynamics.velocity()), v, 1);
  });
}

TEST(ContactLaws, HoldToTheCertificate) {
  for (const int rows : {3, 4, 6})
    each_trial(rows, [&](const ContactTrial&, ContactDynamics&, const ContactStatus& status) {
      EXPECT_LE(status.solution.certificate, 1e-9);
    });
}

TEST(ContactLaws, LoopsStayClosed) {
  Comparison rates("A v", 1e-9);
  each_trial(3, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus&) {
    const Model& model = trial.mechanism.model;
    LoopWorkspace<> loops(model);
    const std::size_t m = static_cast<std::size_t>(model.loops().rows),
                      nv = static_cast<std::size_t>(model.nv());
    std::vector<double> A(m * nv);
    loop_jacobian<double>(model, loops, trial.mechanism.state.q, A);
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> rows(
        A.data(), static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(nv));
    const Eigen::VectorXd u =
        rows * Eigen::Map<const Eigen::VectorXd>(dynamics.velocity().data(), static_cast<Eigen::Index>(nv));
    rates.expect_equal(u, Eigen::VectorXd(Eigen::VectorXd::Zero(u.size())), 1);
  });
}

/// Where nothing bounces, the impulses take energy from the free motion: λᵀ J v⁺ ≤ 0, and more than this is
/// lost.
TEST(ContactLaws, ImpulsesMakeNoEnergy) {
  each_trial(6, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus&) {
    const Model& model = trial.mechanism.model;
    Workspace<> workspace(model, cut_tree);
    const auto energy = [&](std::span<const double> v) {
      std::vector<double> p(v.size());
      momenta<double>(model, workspace, trial.mechanism.state.q, v, p);
      double sum = 0;
      for (std::size_t c = 0; c < v.size(); ++c) sum += p[c] * v[c] / 2;
      return sum;
    };
    const double before = energy(dynamics.free_velocity());
    EXPECT_LE(energy(dynamics.velocity()), before * (1 + 1e-9));
  });
}

TEST(ContactLaws, DoNotDependOnTheOrderOfContacts) {
  Comparison velocities("velocity", 1e-7);
  int compared = 0;
  each_trial(3, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus& status) {
    if (!status.holds(1e-12)) return;
    ContactTrial permuted = trial;
    std::ranges::reverse(permuted.contacts);
    ContactDynamics other(trial.mechanism.model);
    if (!solve(other, permuted).holds(1e-12)) return;
    velocities.expect_equal(to_vector(other.velocity()), to_vector(dynamics.velocity()), 1);
    ++compared;
  });
  EXPECT_GT(compared, 10);
}

/// A contact seen from its other body is the same contact.
TEST(ContactLaws, ActionIsReaction) {
  Comparison velocities("velocity", 1e-7);
  int compared = 0;
  each_trial(3, [&](const ContactTrial& trial, ContactDynamics& dynamics, const ContactStatus& status) {
    if (!status.holds(1e-12)) return;
    ContactTrial exchanged = trial;
    for (Contact& c : exchanged.contacts) {
      std::swap(c.a, c.b);
      c.normal = -c.normal;
    }
    ContactDynamics other(trial.mechanism.model);
    if (!solve(other, exchanged).holds(1e-12)) return;
    velocities.expect_equal(to_vector(other.velocity()), to_vector(dynamics.velocity()), 1);
    ++compared;
  });
  EXPECT_GT(compared, 10);
}

/// A slider that meets its hard stop, and a block that meets a wall there, move alike.
TEST(ContactLaws, AStopIsAContact) {
  const auto slider = [](bool stop) {
    Description description;
    BodyDescription body{.name = "block"};
    body.joint = {.kind = JointKind::prismatic, .axis = {1, 0, 0}};
    body.inertia = MassProperties{.mass = 2, .Theta = {1, 1, 1, 0, 0, 0}};
    Dof dof;
    if (stop) dof = {.upper = 0.5, .hard_stops = true, .restitution = 0.6};
    body.joint.dof = {dof};
    description.bodies.push_back(body);
    return ModelBuilder(description).build();
  };
  for (const double speed : {0.02, 0.3, 7.0}) {
    const std::vector<double> q{0.4999}, v{speed}, tau{3};
    ContactDynamics by_stop(slider(true)), by_contact(slider(false));
    EXPECT_TRUE(by_stop.solve(q, v, tau, {}, {.h = 1e-2}).holds());
    const Contact wall{.a = 0,
                       .b = 1,
                       .point = {0.5, 0, 0},
                       .normal = {-1, 0, 0},
                       .gap = 0.5 - q[0],
                       .surface = {.restitution = 0.6}};
    EXPECT_TRUE(by_contact.solve(q, v, tau, std::span(&wall, 1), {.h = 1e-2}).holds());
    EXPECT_NEAR(by_stop.velocity()[0], by_contact.velocity()[0], 1e-12 * (1 + speed));
    if (speed == 7.0) {
      EXPECT_NEAR(by_stop.velocity()[0], -0.6 * speed, 1e-12);
    }
  }
}

TEST(ContactDynamics, RefusesWhatIsNoContact) {
  const ContactTrial trial = random_trial(3, 1);
  ContactDynamics dynamics(trial.mechanism.model);
  const auto message = [&](auto&& change) -> std::string {
    ContactTrial wrong = trial;
    change(wrong.contacts[0]);
    try {
      static_cast<void>(solve(dynamics, wrong));
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "nothing was thrown";
  };
  EXPECT_THAT(message([](Contact& c) { c.surface.friction = -0.5; }), testing::HasSubstr("not negative"));
  EXPECT_THAT(message([](Contact& c) { c.surface.restitution = 1.5; }),
              testing::HasSubstr("between 0 and 1"));
  EXPECT_THAT(message([](Contact& c) { c.normal = {1, 1, 0}; }), testing::HasSubstr("unit vector"));
  EXPECT_THAT(message([](Contact& c) { c.a = c.b; }), testing::HasSubstr("itself"));
  EXPECT_THAT(message([](Contact& c) { c.b = 1000; }), testing::HasSubstr("body 1000"));
  EXPECT_THAT(message([](Contact& c) { c.gap = std::nan(""); }), testing::HasSubstr("not finite"));
}

/// ∂v⁺/∂r and ∂v⁺/∂c against differences.
TEST(ContactDynamics, HasDerivativesByGapVelocityAndFriction) {
  const Model model = [] {
    Description description;
    BodyDescription body{.name = "ball"};
    body.joint = {.kind = JointKind::free};
    body.inertia = MassProperties{.mass = 2, .Theta = {0.2, 0.3, 0.25, 0, 0, 0}};
    description.bodies.push_back(body);
    return ModelBuilder(description).build();
  }();
  const std::vector<double> q{0, 0, 0, 1, 0, 0, 0.3}, v{0.1, 0.2, 0.5, 1, 0.4, -0.1}, tau(6);
  const auto velocity = [&](double mu, double gap) {
    const Contact contact{
        .a = 0, .b = 1, .point = {0.01, 0, 0}, .normal = {0, 0, 1}, .gap = gap, .surface = {.friction = mu}};
    ContactDynamics dynamics(model);
    EXPECT_TRUE(dynamics.solve(q, v, tau, std::span(&contact, 1), {.h = 1e-2}).holds(1e-12));
    return std::pair{Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(dynamics.velocity().data(), 6)),
                     std::pair{dynamics.derivative_by_r(), dynamics.derivative_by_friction()}};
  };
  const auto [by_r, by_friction] = velocity(0.3, 1e-5).second;
  const double e = 1e-6;
  const Eigen::VectorXd friction = (velocity(0.3 + e, 1e-5).first - velocity(0.3 - e, 1e-5).first) / (2 * e);
  EXPECT_LE((by_friction.col(1) + by_friction.col(2) - friction).norm(), 1e-8);
  EXPECT_GT(friction.norm(), 1e-3);
  const Eigen::VectorXd gap = (velocity(0.3, 1.1e-5).first - velocity(0.3, 0.9e-5).first) / 0.2e-5;
  EXPECT_LE((by_r.col(0) / 1e-2 - gap).norm(), 1e-7 * gap.norm());
}

}  // namespace
}  // namespace axode::test
