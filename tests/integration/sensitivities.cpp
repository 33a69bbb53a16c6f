#include "axode/integration/sensitivities.hpp"

#include <cmath>
#include <optional>

#include "axode/integration/simulation.hpp"
#include "axode/model/configuration.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Sensitivities of motions: they equal limits of differences of motions, and the forward derivatives,
/// gradients and matrices agree with each other.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;
using Eigen::MatrixXd, Eigen::VectorXd;

/// A motion of a few steps by a method of any order. Its mechanism is a random tree, some with springs and
/// stops, or one whose geometric parameters are to be changed.
struct SensitiveMotion {
  Mechanism drawn;
  Model model;
  State<double> start;
  Numbers tau;
  double step = 5e-3;
  std::size_t K;
  const Tableau& method;
  bool losses;

  enum class For { state, geometry };
  /// Every second motion has joint losses. A `smooth` one has no dry friction, which would jump.
  explicit SensitiveMotion(std::uint64_t seed, bool smooth = false, For what = For::state)
      : drawn([&] {
          Random<double> random(seed);
          Mechanism mechanism = random_mechanism(
              random,
              {.most_bodies = 8, .composite = what == For::state, .always_mass = true, .friction = smooth});
          for (DrawnBody& body : mechanism.bodies)
            for (Dof& dof : body.dof)
              if (smooth) dof.friction = 0;
          return mechanism;
        }()),
        model(built(drawn, what == For::state && seed % 3 == 0 ? seed : 0)),
        start([&] {
          Random<double> random(seed + 1);
          return random_state(model, random);
        }()),
        K(1 + seed % 4),
        method(runge_kutta(1 + static_cast<int>(seed % 5))),
        losses(seed % 2 == 0) {
    Random<double> random(seed + 2);
    tau = random_numbers(random, static_cast<int>(K) * model.nv());
  }
  static Model built(const Mechanism& mechanism, std::uint64_t springs = 0) {
    Random<double> random(1), of_springs(springs);
    const Description tree = described(mechanism, random);
    return ModelBuilder(springs > 0 ? with_springs(tree, of_springs) : tree).build();
  }
  std::size_t nv() const { return start.v.size(); }
  Loads<double> loads() const { return {start.wrenches, losses}; }

  Numbers direction(std::uint64_t seed, std::size_t rows = 1) const {
    Random<double> random(seed + 1000);
    return random_numbers(random, static_cast<int>(rows) * model.nv());
  }

  /// The states after each step of simulate_fixed(); nothing if the motion cannot go on.
  struct States {
    std::vector<Numbers> q, v;
  };
  std::optional<States> states(const Model& of, const Numbers& q, const Numbers& v,
                               const Numbers& forces) const {
    States out{{q}, {v}};
    for (std::size_t k = 0; k < K; ++k) {
      const SimulationOptions options{
          .drive = [&](double, auto, auto,
                       std::span<double> tau_k) { std::copy_n(&forces[k * nv()], nv(), tau_k.begin()); },
          .loads = start.wrenches,
          .joint_losses = losses};
      const Trajectory one = simulate_fixed(of, out.q.back(), out.v.back(), step, step, method, options);
      if (!one.complete || one.size() != 2) return std::nullopt;
      out.q.emplace_back(one.q(1).begin(), one.q(1).end());
      out.v.emplace_back(one.v(1).begin(), one.v(1).end());
    }
    return out;
  }
  std::optional<States> states() const { return states(model, start.q, start.v, tau); }
  /// The differences of all states of a motion from those of another one: displacements first, and then
  /// velocities.
  VectorXd away(const States& from, const std::optional<States>& to) const {
    VectorXd x = VectorXd::Constant(static_cast<Eigen::Index>(2 * (K + 1) * nv()), std::nan(""));
    if (!to) return x;
    for (std::size_t k = 0; k <= K; ++k) {
      const Numbers by = difference(model, from.q[k], to->q[k]);
      for (std::size_t c = 0; c < nv(); ++c) {
        x(static_cast<Eigen::Index>(k * nv() + c)) = by[c];
        x(static_cast<Eigen::Index>((K + 1 + k) * nv() + c)) = to->v[k][c] - from.v[k][c];
      }
    }
    return x;
  }

  /// The result of rollout_jvp(), in the order of away().
  VectorXd jvp(const Numbers& dq, const Numbers& dv, const Numbers& dtau) const {
    Numbers q_out((K + 1) * nv()), v_out(q_out);
    EXPECT_TRUE(
        rollout_jvp(model, start.q, start.v, tau, step, dq, dv, dtau, q_out, v_out, loads(), method).ok());
    q_out.insert(q_out.end(), v_out.begin(), v_out.end());
    return vector(q_out);
  }
  struct Gradients {
    Numbers q, v, tau, geometry;
  };
  Gradients vjp(const Numbers& w) const {
    Gradients to{
        Numbers(nv()), Numbers(nv()), Numbers(K * nv()),
        Numbers(model.springs().elements.empty() ? 6 * static_cast<std::size_t>(model.n_bodies()) : 0)};
    const std::span<const double> all(w), w_q = all.first(w.size() / 2), w_v = all.last(w.size() / 2);
    EXPECT_TRUE(rollout_vjp(model, start.q, start.v, tau, step, w_q, w_v, {to.q, to.v, to.tau, to.geometry},
                            loads(), method)
                    .ok());
    return to;
  }
};

Numbers moved_by(const Numbers& x, double eps, const Numbers& dx) {
  return numbers(VectorXd(vector(x) + eps * vector(dx)));
}
/// The limit of (x(eps) - x(-eps)) / (2 eps) for small eps.
template <class F> VectorXd central_difference(const F& x) {
  const double h = 1e-4;
  return (8 * (x(h) - x(-h)) - (x(2 * h) - x(-2 * h))) / (12 * h);
}
double inner(const Numbers& a, const Numbers& b) { return vector(a).dot(vector(b)); }

TEST(Sensitivities, OfAMotionAreLimitsOfDifferences) {
  Comparison comparison("displaced motion", 1e-8);
  int compared = 0;
  for_seeds(150, [&](std::uint64_t seed) {
    const SensitiveMotion at(seed, true);
    const auto states = at.states();
    if (!states || at.nv() == 0) return;
    ++compared;
    const Numbers dq = at.direction(seed), dv = at.direction(seed + 1), dtau = at.direction(seed + 2, at.K);
    const VectorXd found = at.jvp(dq, dv, dtau),
                   expected = central_difference([&](double eps) {
                     const Numbers by = numbers(VectorXd(eps * vector(dq)));
                     return at.away(*states,
                                    at.states(at.model, integrate(at.model, at.start.q, by),
                                              moved_by(at.start.v, eps, dv), moved_by(at.tau, eps, dtau)));
                   });
    comparison.expect_equal(found, expected, std::max(1.0, largest_entry(expected)));
  });
  EXPECT_GT(compared, 0);
}

TEST(Sensitivities, OnTheWayBackAreThoseOnTheWayTransposed) {
  Comparison comparison("w·(J d) and (Jᵀ w)·d", 1e-12);
  for_seeds(150, [&](std::uint64_t seed) {
    const SensitiveMotion at(seed);
    if (!at.states() || at.nv() == 0) return;
    const Numbers dq = at.direction(seed), dv = at.direction(seed + 1), dtau = at.direction(seed + 2, at.K),
                  w = at.direction(seed + 3, 2 * (at.K + 1));
    const VectorXd moved = at.jvp(dq, dv, dtau);
    const SensitiveMotion::Gradients by = at.vjp(w);
    const double scale = vector(w).cwiseAbs().dot(moved.cwiseAbs()) +
                         vector(by.q).cwiseAbs().dot(vector(dq).cwiseAbs()) +
                         vector(by.v).cwiseAbs().dot(vector(dv).cwiseAbs()) +
                         vector(by.tau).cwiseAbs().dot(vector(dtau).cwiseAbs());
    comparison.expect_equal(Numbers{inner(by.q, dq) + inner(by.v, dv) + inner(by.tau, dtau)},
                            Numbers{vector(w).dot(moved)}, scale);
  });
}

TEST(Sensitivities, OfStepsMultiplyToThoseOfTheMotion) {
  Comparison value("end of a step", 1e-12), product_of_steps("product of steps", 1e-12);
  for_seeds(150, [&](std::uint64_t seed) {
    const SensitiveMotion at(seed);
    const auto states = at.states();
    if (!states || at.nv() == 0) return;
    const Eigen::Index n = at.model.nv();
    using Rows = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;
    const Numbers dq = at.direction(seed), dv = at.direction(seed + 1), dtau = at.direction(seed + 2, at.K);
    const VectorXd expected = at.jvp(dq, dv, dtau);
    VectorXd x(2 * n), all(expected.size());
    x << vector(dq), vector(dv);
    VectorXd sizes = x.cwiseAbs();  // the sizes of the terms that are added up, step by step
    Workspace<> workspace(at.model);
    double scale = largest_entry(expected);
    for (std::size_t k = 0; k <= at.K; ++k) {
      all.segment(static_cast<Eigen::Index>(k) * n, n) = x.head(n);
      all.segment(static_cast<Eigen::Index>(at.K + 1 + k) * n, n) = x.tail(n);
      if (k == at.K) break;
      Rows A(2 * n, 2 * n), B(2 * n, n);
      Numbers q(at.start.q.size()), v(at.nv());
      const std::span<const double> tau_k(&at.tau[k * at.nv()], at.nv());
      ASSERT_TRUE(step_derivatives(at.model, workspace, states->q[k], states->v[k], tau_k, at.step,
                                   {q,
                                    v,
                                    {A.data(), static_cast<std::size_t>(A.size())},
                                    {B.data(), static_cast<std::size_t>(B.size())}},
                                   at.loads(), at.method)
                      .ok());
      value.expect_equal(q, states->q[k + 1], 1);
      value.expect_equal(v, states->v[k + 1], std::max(1.0, largest(states->v[k + 1])));
      const VectorXd dtau_k = vector(dtau).segment(static_cast<Eigen::Index>(k) * n, n);
      sizes = (A.cwiseAbs() * sizes + B.cwiseAbs() * dtau_k.cwiseAbs()).eval();
      scale = std::max(scale, largest_entry(sizes));
      x = (A * x + B * dtau_k).eval();
    }
    product_of_steps.expect_equal(all, expected, scale);
  });
}

/// The mechanism after everything that joint i moves was displaced by D, a pose in the construction frame.
Mechanism displaced_by(Mechanism mechanism, std::size_t i, const SE3<>& D) {
  std::vector<bool> goes(mechanism.bodies.size());
  for (std::size_t j = 0; j < goes.size(); ++j) {
    DrawnBody& body = mechanism.bodies[j];
    goes[j] = j == i || (body.predecessor >= 0 && goes[static_cast<std::size_t>(body.predecessor)]);
    if (!goes[j]) continue;
    body.A = D * body.A, body.J = D * body.J;
    if (body.matter)
      body.matter->com = D * body.matter->com, body.matter->Theta_c = rotate(D.R, body.matter->Theta_c);
  }
  for (DrawnFrame& frame : mechanism.frames)
    if (frame.body >= 0 && goes[static_cast<std::size_t>(frame.body)]) frame.pose = D * frame.pose;
  return mechanism;
}

TEST(Sensitivities, ByGeometricParametersAreLimitsOfDifferences) {
  Comparison comparison("gradient by geometry", 1e-8);
  int compared = 0;
  for_seeds(60, [&](std::uint64_t seed) {
    const SensitiveMotion at(seed, true, SensitiveMotion::For::geometry);
    const auto states = at.states();
    if (!states || at.nv() == 0) return;
    const Numbers w = at.direction(seed, 2 * (at.K + 1));
    const Numbers gradient = at.vjp(w).geometry;
    const std::size_t i = seed % at.drawn.bodies.size();
    const DrawnBody& body = at.drawn.bodies[i];
    if (body.kind == JointKind::fixed) return;
    ++compared;
    const auto moving = static_cast<std::size_t>(at.model.frame_index(body.name));
    Random<double> random(seed + 5);
    const Screw<> U{random.vector(1), random.vector(1)};
    const VectorXd moved = central_difference([&](double eps) {
      const SE3<> D = body.A * exp(eps * U) * inverse(body.A);
      return at.away(*states, at.states(SensitiveMotion::built(displaced_by(at.drawn, i, D)), at.start.q,
                                        at.start.v, at.tau));
    });
    const double scale = std::max(vector(w).cwiseAbs().dot(moved.cwiseAbs()), largest(gradient));
    const Numbers of_body(&gradient[(moving - 1) * 6], &gradient[(moving - 1) * 6] + 6);
    comparison.expect_equal(Numbers{inner(of_body, {U.w.x, U.w.y, U.w.z, U.v.x, U.v.y, U.v.z})},
                            Numbers{vector(w).dot(moved)}, std::max(1.0, scale));
  });
  EXPECT_GT(compared, 0);
}

TEST(Sensitivities, AreNotANumberWhereTheMotionCannotGoOn) {
  const Model model = shoulder();
  const Numbers q = neutral(model), v(4), dq(4, 1);
  Numbers tau(3 * 4), out_q(16), out_v(16), by_tau(12);
  const auto both = [&](const Monitor& monitor) {
    const Solvability forward =
        rollout_jvp(model, q, v, tau, 0.1, dq, dq, tau, out_q, out_v, {}, runge_kutta(4), monitor);
    Numbers by_q(4), by_v(4);
    const Numbers w(16, 1);
    const Solvability back =
        rollout_vjp(model, q, v, tau, 0.1, w, w, {by_q, by_v, by_tau}, {}, runge_kutta(4), monitor);
    EXPECT_EQ(forward.ok(), back.ok());
    EXPECT_EQ(std::isnan(out_v[3]), !forward.ok());
    EXPECT_EQ(std::isnan(by_tau[0]), !forward.ok());
    return forward.ok();
  };
  EXPECT_TRUE(both({}));
  int asked = 0;
  EXPECT_FALSE(both([&] { return ++asked % 2 == 1; }));
  tau[5] = 1e300;
  EXPECT_FALSE(both({}));

  const Model rod = ModelBuilder("rod")
                        .add({.name = "rod", .joint = {.name = "hinge", .kind = JointKind::revolute}})
                        .build();
  Workspace<> workspace(rod);
  const Numbers zero(1);
  Numbers x(1), y(1), A(4), B(2);
  const Solvability none = step_derivatives(rod, workspace, zero, zero, zero, 0.1, {x, y, A, B});
  EXPECT_EQ(none.singular_body, 1);
  for (const double a : A) EXPECT_TRUE(std::isnan(a));
}

TEST(Sensitivities, OfNoStepAreWhatWasGiven) {
  const Model model = shoulder();
  const Numbers q = neutral(model), v(4), none, dq{1, 2, 3, 4}, dv{5, 6, 7, 8};
  Numbers out_q(4), out_v(4), by_tau;
  EXPECT_TRUE(rollout_jvp(model, q, v, none, 0.1, dq, dv, none, out_q, out_v).ok());
  EXPECT_EQ(out_q, dq);
  EXPECT_EQ(out_v, dv);
  EXPECT_TRUE(rollout_vjp(model, q, v, none, 0.1, dq, dv, {out_q, out_v, by_tau}).ok());
  EXPECT_EQ(out_q, dq);
  EXPECT_EQ(out_v, dv);
}

TEST(Sensitivities, RefuseWhatTheyCannotUse) {
  const Model model = shoulder();
  const Numbers q = neutral(model), v(4), tau(8), w(12);
  Numbers a(12), b(12), c(4), d(4), e(8);
  const auto jvp = [&](const Numbers& q_0, const Numbers& dtau, double step, std::span<double> out,
                       const Loads<double>& loads = {}) {
    return
        [=, &model, &v, &tau, &b] { (void)rollout_jvp(model, q_0, v, tau, step, v, v, dtau, out, b, loads); };
  };
  const auto vjp = [&](const Numbers& weights, std::span<double> geometry) {
    return [=, &model, &q, &v, &tau, &w, &c, &d, &e] {
      (void)rollout_vjp(model, q, v, tau, 0.1, weights, w, {c, d, e, geometry});
    };
  };
  EXPECT_THAT(jvp(q, Numbers(7), 0.1, a), refused("dtau", 7, "K nv", 8));
  EXPECT_THAT(jvp(q, tau, 0.1, c), refused("dq_out", 4, "(K + 1) nv", 12));
  EXPECT_THAT(jvp({0, 0, 0, 2, 0}, tau, 0.1, a), refused_quaternion("ball"));
  EXPECT_THAT(message_of(jvp(q, tau, 0, a)), testing::StartsWith("step is 0 s"));
  EXPECT_THAT(message_of(jvp(q, tau, std::nan(""), a)), testing::StartsWith("step is nan"));
  EXPECT_THAT(message_of(jvp(q, tau, 0.1, b)), testing::StartsWith("dv_out shares memory with dq_out"));
  const std::vector<AppliedWrench<>> nowhere{{9, Representation::body, Vec3<>{}, Vec3<>{}}};
  EXPECT_THAT(message_of(jvp(q, tau, 0.1, a, {nowhere})), testing::HasSubstr("frame 9"));
  Description sprung{.name = "sprung"};
  sprung.bodies.push_back({.name = "bob", .predecessor = "ground"});
  sprung.bodies[0].joint = {.name = "pin", .kind = JointKind::revolute};
  sprung.bodies[0].inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}};
  sprung.springs.push_back({.between = {"ground", "bob"}, .stiffness = 2});
  const Model held = ModelBuilder(sprung).build();
  EXPECT_EQ(message_of([&] {
              Numbers one(1), two(2), by_q(1), by_v(1), by_tau(1), geometry(6);
              (void)rollout_vjp(held, one, one, one, 0.1, two, two, {by_q, by_v, by_tau, geometry});
            }),
            "model \"sprung\" has springs between frames, whose derivatives by geometry are not known");
  EXPECT_THAT(vjp(tau, {}), refused("w_q", 8, "(K + 1) nv", 12));
  EXPECT_THAT(vjp(w, a), testing::Not(testing::Throws<std::invalid_argument>()));
  EXPECT_THAT(vjp(w, e), refused("gradient.geometry", 8, "n_bodies * 6", 12));
  Workspace<> small(ModelBuilder("nothing").build());
  Numbers x(5), A(64), B(32);
  EXPECT_THAT(([&] {
                (void)step_derivatives(model, small, q, v, v, 0.1, {x, c, A, B});
              }),
              refused_workspace(0, 2));
  Workspace<> workspace(model);
  EXPECT_THAT(([&] {
                (void)step_derivatives(model, workspace, q, v, v, 0.1, {x, c, A, A});
              }),
              refused("end.B", 64, "2nv * nv", 32));
}

}  // namespace
}  // namespace axode::test
