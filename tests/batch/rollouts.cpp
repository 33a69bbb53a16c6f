#include "axode/batch.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/integration.hpp"
#include "axode/model/configuration.hpp"
#include "tests/constraints/mechanisms.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// The motions of a rollout of many states under one drive equal simulations of each state alone.
namespace axode::test {
namespace rollouts {
namespace {

using Vector = std::vector<double>;
using Span = std::span<const double>;

/// A random tree, some of them with a spring, and random states of it.
struct Driven {
  Model model;
  std::size_t N, nq, nv;
  Vector q, v;

  Driven(std::uint64_t seed, std::size_t count)
      : model([&] {
          Random<double> random(seed);
          const TreeRecipe recipe{.most_bodies = 7, .couplings = seed % 4 == 0, .always_mass = true};
          Description tree = described(random_mechanism(random, recipe), random);
          if (seed % 5 == 0)
            tree.springs = {{.between = {"ground", tree.bodies[0].name}, .stiffness = 5, .rest = 0.3}};
          return ModelBuilder(tree).build();
        }()),
        N(count),
        nq(static_cast<std::size_t>(model.nq())),
        nv(static_cast<std::size_t>(model.nv())) {
    Random<double> random(seed + 1);
    for (std::size_t k = 0; k < N; ++k) {
      const State<double> state = random_state(model, random);
      q.insert(q.end(), state.q.begin(), state.q.end());
      v.insert(v.end(), state.v.begin(), state.v.end());
    }
  }
  Span q_of(std::size_t n) const { return Span(q).subspan(n * nq, nq); }
  Span v_of(std::size_t n) const { return Span(v).subspan(n * nv, nv); }
};

/// Drives of all kinds: those of the library and one that is a function of this test.
std::vector<std::pair<const char*, Drive>> drives(const Driven& at, std::uint64_t seed, double step) {
  Random<double> random(seed + 2);
  const int nv = at.model.nv();
  const auto some = [&](double size) { return random_numbers(random, nv, size); };
  const auto positive = [&](double size) {
    Vector x = some(size);
    for (double& x_c : x) x_c = std::abs(x_c);
    return x;
  };
  Vector tau = some(1);
  for (int k = 0; k < 2; ++k) {
    const Vector more = some(1);
    tau.insert(tau.end(), more.begin(), more.end());
  }
  const Vector times{0, 2 * step, 5 * step}, q_d = random_configuration(at.model, seed), v_d = some(1),
                                             a_d = some(1), kp = positive(3), kd = positive(0.1);
  SimulationOptions turning;
  turning.drive = [](double t, Span, Span v, std::span<double> out) {
    for (std::size_t c = 0; c < out.size(); ++c)
      out[c] = std::sin(9 * t + static_cast<double>(c)) - 0.1 * v[c];
  };
  const Trajectory motion =
      simulate_fixed(at.model, at.q_of(0), at.v_of(0), 7 * step, step / 2, runge_kutta(4), turning);
  const SampledDrive lines(at.model, times, tau);
  std::vector<std::pair<const char*, Drive>> all{
      {"lines", lines},
      {"held", SampledDrive(at.model, times, tau, true)},
      {"PD", ProportionalDerivative(at.model, {kp, kd}, {at.model, q_d, v_d})},
      {"PD, clipped, forward", ProportionalDerivative(at.model, {kp, kd}, {at.model, q_d}, lines, true)},
      {"PD, a function forward", ProportionalDerivative(at.model, {kp, kd}, {at.model, q_d}, turning.drive)},
      {"computed torque", ComputedTorque(at.model, {kp, kd}, {at.model, q_d, v_d, a_d})},
      {"a function", turning.drive}};
  if (motion.complete && motion.size() > 0) {
    all.push_back({"PD along a motion", ProportionalDerivative(at.model, {kp, kd}, {at.model, motion})});
    all.push_back({"computed torque along a motion", ComputedTorque(at.model, {kp, kd}, {at.model, motion})});
  }
  return all;
}

TEST(Rollouts, UnderADriveAreTheMotionsOneByOne) {
  constexpr std::size_t K = 8;
  constexpr double step = 1e-3;
  Comparison velocity("velocities", 1e-11);
  std::size_t compared = 0, calls = 0;
  for_seeds(20, [&](std::uint64_t seed) {
    const std::size_t numbers[]{1, 2, 9, 17};
    const Driven at(seed, numbers[seed % 4]);
    if (at.nv == 0) return;
    for (const auto& [name, drive] : drives(at, seed, step)) {
      SCOPED_TRACE(name);
      Vector q(at.N * (K + 1) * at.nq), v(at.N * (K + 1) * at.nv), q_3(q), v_3(v);
      const batch::Outcome outcome = batch::rollout<double>(at.model, at.q, at.v, drive, K, step, q, v);
      EXPECT_EQ(
          outcome.ok(),
          batch::rollout<double>(at.model, at.q, at.v, drive, K, step, q_3, v_3, runge_kutta(4), 3).ok());
      SimulationOptions options;
      options.drive = drive;
      for (std::size_t n = 0; n < at.N; ++n) {
        const Trajectory motion =
            simulate_fixed(at.model, at.q_of(n), at.v_of(n), K * step, step, runge_kutta(4), options);
        const Span q_n = Span(q).subspan(n * (K + 1) * at.nq, (K + 1) * at.nq),
                   v_n = Span(v).subspan(n * (K + 1) * at.nv, (K + 1) * at.nv);
        for (std::size_t k = 0; k < q_n.size(); ++k)
          if (!std::isnan(q_n[k])) {
            ASSERT_EQ(q_n[k], q_3[n * q_n.size() + k]);
          }
        if (!motion.complete) continue;
        // A second simulation with forces that are larger by one part in a million shows how strongly these
        // velocities depend on rounding.
        options.drive = [its = drive](double t, Span q_t, Span v_t, std::span<double> tau) {
          its(t, q_t, v_t, tau);
          for (double& tau_c : tau) tau_c *= 1 + 1e-6;
        };
        const Trajectory other =
            simulate_fixed(at.model, at.q_of(n), at.v_of(n), K * step, step, runge_kutta(4), options);
        options.drive = drive;
        double scale = 0;
        for (std::size_t c = 0; c < at.nv; ++c)
          scale = std::max({scale, std::abs(motion.v(K)[c]),
                            1e6 * std::abs(other.complete ? other.v(K)[c] - motion.v(K)[c] : INFINITY)});
        for (std::size_t k = 0; k <= K; ++k) {
          const Span expected = motion.v(k);
          velocity.expect_equal(Vector(v_n.begin() + static_cast<std::ptrdiff_t>(k * at.nv),
                                       v_n.begin() + static_cast<std::ptrdiff_t>((k + 1) * at.nv)),
                                Vector(expected.begin(), expected.end()), scale);
        }
        const Vector apart = difference(at.model, motion.q(K), q_n.last(at.nq));
        velocity.expect_equal(apart, Vector(at.nv), scale);
        ++compared;
      }
      ++calls;
    }
  });
  EXPECT_GT(compared, 5 * calls);
}

TEST(Rollouts, OfManyStepsAndInSinglePrecisionSeeTheDriveOfEachStep) {
  const Model model = reduced(shoulder(), {}, Vector{0, 0, 0, 1, 0});
  constexpr std::size_t K = 600, N = 3;
  constexpr double step = 1e-3;
  Vector times, tau;
  for (const double t : {0.0, 0.2, 0.256, 0.3, 0.512, 0.59})
    for (std::size_t c = 0; c < 4; ++c) {
      if (c == 0) times.push_back(t);
      tau.push_back(0.01 * std::sin(100 * t + static_cast<double>(c)));
    }
  const Vector q_d{0, 0, 0, 1, 0.5}, kp{0.5}, kd{0.1};
  Random<double> random(5);
  Vector q, v;
  for (std::size_t n = 0; n < N; ++n) {
    const State<double> state = random_state(model, random);
    q.insert(q.end(), state.q.begin(), state.q.end()), v.insert(v.end(), 4, 0.1);
  }
  SimulationOptions options;
  options.drive =
      ProportionalDerivative(model, {kp, kd}, {model, q_d}, SampledDrive(model, times, tau, true));
  Vector q_out(N * (K + 1) * 5), v_out(N * (K + 1) * 4);
  ASSERT_TRUE(batch::rollout<double>(model, q, v, options.drive, K, step, q_out, v_out).ok());
  const std::vector<float> q_f(q.begin(), q.end()), v_f(v.begin(), v.end());
  for (const std::size_t count : {N, std::size_t{1}}) {  // all motions in lanes, and one alone
    std::vector<float> q_single(count * (K + 1) * 5), v_single(count * (K + 1) * 4);
    ASSERT_TRUE(batch::rollout<float>(model, std::span(q_f).first(5 * count), std::span(v_f).first(4 * count),
                                      options.drive, K, step, q_single, v_single)
                    .ok());
    for (std::size_t k = 0; k < v_single.size(); ++k) ASSERT_NEAR(v_single[k], v_out[k], 1e-3);
  }
  for (std::size_t n = 0; n < N; ++n) {
    const Trajectory motion = simulate_fixed(model, Span(q).subspan(5 * n, 5), Span(v).subspan(4 * n, 4),
                                             K * step, step, runge_kutta(4), options);
    ASSERT_EQ(motion.size(), K + 1);
    for (std::size_t k = 0; k < 4 * (K + 1); ++k)
      ASSERT_NEAR(v_out[n * 4 * (K + 1) + k], motion.v()[k], 1e-11);
  }
}

TEST(Rollouts, OfMechanismsWithLoopsAreTheMotionsOneByOne) {
  constexpr std::size_t K = 300, N = 5;
  constexpr double step = 1e-3;
  for (const Description& description : {four_bar(), bricard(), gough()}) {
    SCOPED_TRACE(description.name);
    const Model model = ModelBuilder(description).build();
    const std::size_t nq = static_cast<std::size_t>(model.nq()), nv = static_cast<std::size_t>(model.nv());
    Random<double> random(3);
    Vector q, v;
    for (std::size_t n = 0; n < N; ++n) {
      const AssemblyResult at = assemble(model, neutral(model), random_numbers(random, model.nv()));
      q.insert(q.end(), at.q.begin(), at.q.end()), v.insert(v.end(), at.v.begin(), at.v.end());
    }
    SimulationOptions options;
    const Vector zero{0}, tau = random_numbers(random, model.nv());
    options.drive = SampledDrive(model, zero, tau);
    Vector q_out(N * (K + 1) * nq), v_out(N * (K + 1) * nv), q_tau(q_out), v_tau(v_out), all;
    for (std::size_t k = 0; k < N * K; ++k) all.insert(all.end(), tau.begin(), tau.end());
    ASSERT_TRUE(
        batch::rollout<double>(model, q, v, options.drive, K, step, q_out, v_out, runge_kutta(4), 2).ok());
    ASSERT_TRUE(batch::rollout<double>(model, q, v, all, step, q_tau, v_tau).ok());
    EXPECT_EQ(q_out, q_tau);
    EXPECT_EQ(v_out, v_tau);
    for (std::size_t n = 0; n < N; ++n) {
      const Trajectory motion =
          simulate_fixed(model, Span(q).subspan(n * nq, nq), Span(v).subspan(n * nv, nv), K * step, step,
                         runge_kutta(4), options);
      ASSERT_EQ(motion.size(), K + 1);
      for (std::size_t k = 0; k < nq * (K + 1); ++k)
        ASSERT_NEAR(q_out[n * nq * (K + 1) + k], motion.q()[k], 1e-10);
    }
    v[nv] += 1;
    EXPECT_THAT(message_of([&] { (void)batch::rollout<double>(model, q, v, all, step, q_tau, v_tau); }),
                testing::StartsWith("state 1: v does not keep loop"));
    const std::vector<float> q_f(q.begin(), q.end()), v_f(v.begin(), v.end()), tau_f(all.begin(), all.end());
    std::vector<float> q_single(q_out.size()), v_single(v_out.size());
    EXPECT_THAT(
        message_of([&] { (void)batch::rollout<float>(model, q_f, v_f, tau_f, step, q_single, v_single); }),
        testing::HasSubstr("has loops, which rollouts count in double precision alone"));
  }
}

TEST(Rollouts, EndWhereLoopsCannotBeKeptClosed) {
  const Model model = ModelBuilder(four_bar()).build();
  Random<double> random(3);
  const AssemblyResult still = assemble(model, neutral(model)),
                       fast = assemble(model, neutral(model), Vector{300, 0, 0});
  Vector q(still.q), v(still.v), q_out(2 * 4 * 3), v_out(q_out);
  q.insert(q.end(), fast.q.begin(), fast.q.end()), v.insert(v.end(), fast.v.begin(), fast.v.end());
  const batch::Outcome outcome = batch::rollout<double>(model, q, v, Vector(2 * 3 * 3), 0.1, q_out, v_out);
  EXPECT_EQ(outcome.singular_states, 1u);
  EXPECT_EQ(outcome.first, 1u);
  EXPECT_TRUE(outcome.loops_open);
  EXPECT_FALSE(std::isnan(q_out[11]));
  EXPECT_TRUE(std::isnan(q_out[23]));
}

TEST(Rollouts, RefuseNoDriveAndResultsOfOtherSizes) {
  const Model model = reduced(shoulder(), {}, Vector{0, 0, 0, 1, 0});
  const Vector q{0, 0, 0, 1, 0}, v(4), kp{1};
  Vector q_out(15), v_out(12);
  const Drive drive = ProportionalDerivative(model, {kp, kp}, {model, q});
  const auto roll = [&](const Drive& any, std::size_t K, double step) {
    return message_of(
        [&] { static_cast<void>(batch::rollout<double>(model, q, v, any, K, step, q_out, v_out)); });
  };
  EXPECT_EQ(roll(drive, 2, 0.1), "no error");
  EXPECT_EQ(roll({}, 2, 0.1), "drive is empty; expected a function of (t, q, v)");
  EXPECT_THAT(roll(drive, 3, 0.1), testing::StartsWith("q_out has 15 entries; expected (K + 1) nq N = 20"));
  EXPECT_THAT(roll(drive, 2, 0), testing::StartsWith("step is 0"));
}

}  // namespace
}  // namespace rollouts
}  // namespace axode::test
