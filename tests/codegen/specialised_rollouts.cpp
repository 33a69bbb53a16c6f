#include <atomic>
#include <cmath>

#include "axode/codegen.hpp"
#include "axode/io.hpp"
#include "tests/codegen/specialised_models.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Motions with compiled forward dynamics equal those that the library computes.
namespace axode::test {
namespace compiled_rollouts {
namespace {

using catalog::Id;
using Vector = std::vector<double>;

constexpr std::size_t K = 8;
constexpr double step = 1e-3;

/// The initial states of N motions, and the forces for each of their steps.
template <class T = double> struct Starts {
  std::size_t N, nq, nv;
  std::vector<T> q, v, tau;

  Starts(const Model& model, std::size_t count, std::uint64_t seed, std::size_t steps = K)
      : N(count), nq(static_cast<std::size_t>(model.nq())), nv(static_cast<std::size_t>(model.nv())) {
    Random<double> random(seed);
    for (std::size_t n = 0; n < N; ++n) {
      const State<double> state = random_state(model, random);
      for (const double x : state.q) q.push_back(static_cast<T>(x));
      for (const double x : state.v) v.push_back(static_cast<T>(x));
    }
    for (const double x : random_numbers(random, static_cast<int>(N * steps * nv)))
      tau.push_back(static_cast<T>(x));
  }
};

/// The motions and the outcome of a rollout.
template <class T = double> struct Motion {
  batch::Outcome outcome;
  std::vector<T> q, v;

  explicit Motion(const Starts<T>& at, std::size_t steps = K)
      : q(at.N * (steps + 1) * at.nq), v(at.N * (steps + 1) * at.nv) {}
};
template <class T, class M>
Motion<T> under_forces(const M& model, const Starts<T>& at, int threads = 1, bool losses = false) {
  Motion<T> of(at);
  of.outcome =
      batch::rollout<T>(model, at.q, at.v, at.tau, step, of.q, of.v, runge_kutta(4), threads, {}, losses);
  return of;
}
template <class T, class M>
Motion<T> driven(const M& model, const Starts<T>& at, const Drive& drive, int threads = 1,
                 bool losses = false) {
  Motion<T> of(at);
  of.outcome =
      batch::rollout<T>(model, at.q, at.v, drive, K, step, of.q, of.v, runge_kutta(4), threads, {}, losses);
  return of;
}

template <class T> double largest(std::span<const T> x) {
  double most = 0;
  for (const T x_k : x) most = std::max(most, std::abs(static_cast<double>(x_k)));
  return most;
}

/// Compares two motions. The motion `other` has forces that are larger by one part in a million and shows how
/// strongly velocities depend on rounding.
template <class T>
void expect_same(const Motion<T>& found, const Motion<T>& expected, const Motion<T>& other,
                 const Starts<T>& at, double tolerance) {
  EXPECT_EQ(found.outcome.done, expected.outcome.done);
  EXPECT_EQ(found.outcome.singular_states, expected.outcome.singular_states);
  EXPECT_EQ(found.outcome.first, expected.outcome.first);
  const std::size_t rows = (K + 1) * at.nv;
  for (std::size_t n = 0; n < at.N; ++n) {
    const auto of = [&](const std::vector<T>& x) { return std::span<const T>(x).subspan(n * rows, rows); };
    double scale = std::max(1.0, largest(of(expected.v)));
    for (std::size_t k = 0; k < rows; ++k)
      scale = std::max(scale, 1e6 * std::abs(static_cast<double>(of(other.v)[k] - of(expected.v)[k])));
    for (std::size_t k = 0; k < rows; ++k)
      ASSERT_NEAR(of(found.v)[k], of(expected.v)[k], tolerance * scale) << n << ' ' << k;
    for (std::size_t k = n * (K + 1) * at.nq; k < (n + 1) * (K + 1) * at.nq; ++k)
      ASSERT_NEAR(found.q[k], expected.q[k], tolerance * scale) << n << ' ' << k;
  }
}

std::vector<std::pair<const char*, Drive>> drives(const Model& model, std::uint64_t seed) {
  Random<double> random(seed);
  const auto some = [&](double size) { return random_numbers(random, model.nv(), size); };
  Vector tau = some(1);
  for (const double x : some(1)) tau.push_back(x);
  const Vector times{0, 4 * step}, q_d = random_configuration(model, seed), v_d = some(1), a_d = some(1),
                                   kp{3}, kd{0.1};
  const SampledDrive lines(model, times, tau);
  return {
      {"lines", lines},
      {"PD, clipped, forward", ProportionalDerivative(model, {kp, kd}, {model, q_d}, lines, true)},
      {"computed torque", ComputedTorque(model, {kp, kd}, {model, q_d, v_d, a_d})},
      {"a function", [](double t, std::span<const double>, std::span<const double> v, std::span<double> out) {
         for (std::size_t c = 0; c < out.size(); ++c)
           out[c] = std::sin(9 * t + static_cast<double>(c)) - 0.1 * v[c];
       }}};
}
/// The same drive with forces that are larger by one part in a million.
Drive more(const Drive& drive) {
  return [its = drive](double t, std::span<const double> q, std::span<const double> v,
                       std::span<double> tau) mutable {
    its(t, q, v, tau);
    for (double& tau_c : tau) tau_c *= 1 + 1e-6;
  };
}

class SpecialisedRollouts : public SpecialisedModels {};

TEST_F(SpecialisedRollouts, GiveWhatTheLibrarysGive) {
  for_seeds(6, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Model model = every_joint();  // one is coupled
    if (seed > 1) {
      const TreeRecipe recipe{.most_bodies = 7, .always_mass = true};
      Description tree = described(random_mechanism(random, recipe), random);
      if (seed % 3 == 0)
        tree.springs = {{.between = {"ground", tree.bodies[0].name}, .stiffness = 5, .rest = 0.3}};
      model = ModelBuilder(tree).build();
    }
    if (model.nv() == 0) return;
    const Specialised<> specialised(model, {{Id("forward_dynamics")}}, {.flags = quickly});
    for (const std::size_t N : {0, 1, 2, 9, 17})
      for (const bool losses : {false, true}) {
        const Starts<> at(model, N, seed + N);
        Starts<> pushed(at);
        for (double& tau : pushed.tau) tau *= 1 + 1e-6;
        const int threads = N == 9 ? 4 : 1;
        {
          SCOPED_TRACE(testing::Message() << N << " under forces, losses " << losses);
          expect_same(under_forces(specialised, at, threads, losses),
                      under_forces(model, at, threads, losses), under_forces(model, pushed, threads, losses),
                      at, 1e-11);
        }
        for (const auto& [name, drive] : drives(model, seed)) {
          SCOPED_TRACE(testing::Message() << N << " under " << name << ", losses " << losses);
          expect_same(driven(specialised, at, drive, threads, losses),
                      driven(model, at, drive, threads, losses),
                      driven(model, at, more(drive), threads, losses), at, 1e-11);
        }
      }
  });
}

TEST_F(SpecialisedRollouts, GiveItInSinglePrecision) {
  const Model model = load(robot("double_pendulum.toml"));
  const Specialised<float> specialised(model, {{Id("forward_dynamics")}}, {.flags = quickly});
  for (const std::size_t N : {1, 33}) {
    const Starts<float> at(model, N, 3);
    Starts<float> pushed(at);
    for (float& tau : pushed.tau) tau *= 1 + 1e-6F;
    expect_same(under_forces(specialised, at), under_forces(model, at), under_forces(model, pushed), at,
                1e-4);
    const Drive drive = drives(model, 2)[1].second;
    expect_same(driven(specialised, at, drive), driven(model, at, drive), driven(model, at, drive), at, 1e-4);
  }
}

TEST_F(SpecialisedRollouts, DependOnNeitherTheirPlaceNorTheThreads) {
  const Model model = every_joint();
  const Specialised<> specialised(model, {{Id("forward_dynamics")}}, {.flags = {"-O2", "-march=native"}});
  const Starts<> all(model, 21, 2);
  const Motion<> expected = under_forces(specialised, all);
  for (const int threads : {2, 5}) {
    const Motion<> shared = under_forces(specialised, all, threads);
    EXPECT_EQ(shared.q, expected.q);
    EXPECT_EQ(shared.v, expected.v);
  }
  for (std::size_t first = 1; first < all.N - 1; ++first) {
    Starts<> part(all);
    part.N -= first;
    for (const auto& [numbers, rows] :
         {std::pair{&part.q, all.nq}, std::pair{&part.v, all.nv}, std::pair{&part.tau, K * all.nv}})
      numbers->erase(numbers->begin(), numbers->begin() + static_cast<std::ptrdiff_t>(first * rows));
    const Motion<> found = under_forces(specialised, part);
    ASSERT_TRUE(std::equal(found.q.begin(), found.q.end(),
                           expected.q.begin() + static_cast<std::ptrdiff_t>(first * (K + 1) * all.nq)));
    ASSERT_TRUE(std::equal(found.v.begin(), found.v.end(),
                           expected.v.begin() + static_cast<std::ptrdiff_t>(first * (K + 1) * all.nv)));
  }
}

TEST_F(SpecialisedRollouts, LeaveWhatIsSingularOrNotFiniteToTheLibrary) {
  const Model pendulum = load(robot("double_pendulum.toml"));
  for (const Model& model : {singular_wrist(), pendulum}) {
    const Specialised<> specialised(model, {{Id("forward_dynamics")}}, {.flags = quickly});
    for (const std::size_t N : {1, 19}) {
      Starts<> at(model, N, 4);
      at.v[(N - 1) * at.nv] = 1e200, at.tau[(N / 2) * K * at.nv + 5 * at.nv] = std::nan("");
      const Motion<> found = under_forces(specialised, at), expected = under_forces(model, at);
      EXPECT_FALSE(found.outcome.ok());
      EXPECT_EQ(found.outcome.singular_states, expected.outcome.singular_states);
      EXPECT_EQ(found.outcome.first, expected.outcome.first);
      EXPECT_EQ(found.outcome.solvability, expected.outcome.solvability);
      for (std::size_t k = 0; k < found.v.size(); ++k)
        ASSERT_EQ(std::isnan(found.v[k]), std::isnan(expected.v[k])) << k;
    }
  }
}

TEST_F(SpecialisedRollouts, EndWhereTheMonitorSaysSo) {
  const Model model = load(robot("double_pendulum.toml"));
  const Specialised<> specialised(model, {{Id("forward_dynamics")}}, {.flags = quickly});
  constexpr std::size_t long_K = 400'000;
  const Starts<> at(model, 2, 3, 0);
  Motion<> of(at, long_K);
  int asked = 0;
  const batch::Outcome outcome =
      batch::rollout<double>(specialised, at.q, at.v, drives(model, 1)[0].second, long_K, 1e-7, of.q, of.v,
                             runge_kutta(4), 1, [&](std::size_t, std::size_t of) {
                               EXPECT_EQ(of, 2u);
                               ++asked;
                               return false;
                             });
  EXPECT_GE(asked, 1);
  EXPECT_EQ(outcome.done, 0u);
}

TEST_F(SpecialisedRollouts, RefuseWhatTheLibrarysRefuse) {
  const Model model = shoulder();
  const Specialised<> specialised(model, {{Id("forward_dynamics")}}, {.flags = quickly});
  const Drive drive = drives(model, 1)[1].second;
  const auto both_say = [&](const auto& spoil) {
    Starts<> at(model, 2, 3);
    Motion<> of(at);
    double length = step;
    int threads = 1;
    Drive its = drive;
    spoil(at, of, length, threads, its);
    const auto messages = [&](const auto& m) {
      return message_of([&] {
               static_cast<void>(batch::rollout<double>(m, at.q, at.v, at.tau, length, of.q, of.v,
                                                        runge_kutta(4), threads));
             }) +
             " / " + message_of([&] {
               static_cast<void>(batch::rollout<double>(m, at.q, at.v, its, K, length, of.q, of.v,
                                                        runge_kutta(4), threads));
             });
    };
    EXPECT_EQ(messages(specialised), messages(model));
    return messages(model);
  };
  EXPECT_EQ(both_say([](auto&, auto&, double&, int&, Drive&) {}), "no error / no error");
  for (const std::string& said :
       {both_say([](auto&at, auto&, double&, int&, Drive&) { at.q.pop_back(); }),
        both_say([](auto&at, auto&, double&, int&, Drive&) { at.q[8] = 3; }),
        both_say([](auto&at, auto&, double&, int&, Drive&) { at.v.pop_back(); }),
        both_say([](auto&, auto&of, double&, int&, Drive&) { of.q.pop_back(); }),
        both_say([](auto&, auto&, double&length, int&, Drive&) { length = 0; }),
        both_say([](auto&, auto&, double&, int&threads, Drive&) { threads = 0; })}) {
    EXPECT_THAT(said, testing::Not(testing::StartsWith("no error")));
    EXPECT_THAT(said, testing::Not(testing::EndsWith("no error")));
  }
  EXPECT_THAT(both_say([](auto& at, auto&, double&, int&, Drive&) { at.tau.pop_back(); }),
              testing::StartsWith("tau has"));
  EXPECT_THAT(both_say([](auto&, auto&, double&, int&, Drive& its) { its = {}; }),
              testing::EndsWith("drive is empty; expected a function of (t, q, v)"));
  const Specialised<> without(model, {{Id("poses")}}, {.flags = quickly});
  EXPECT_EQ(message_of([&] { static_cast<void>(under_forces(without, Starts<>(model, 2, 3))); }),
            "model \"shoulder\" was specialised without forward_dynamics");
}

/// Made-up dynamics a = 2 tau - v, which no model has. It reports that M may be singular where the first
/// entry of tau is larger than 0.9.
template <class T>
void made_up(long count, const T* const* arguments, T* a, T*, unsigned char* maybe_singular) {
  for (long k = 0; k < count; ++k) {
    for (long c = 0; c < 2; ++c) a[2 * k + c] = 2 * arguments[2][2 * k + c] - arguments[1][2 * k + c];
    maybe_singular[k] = arguments[2][2 * k] > T(0.9);
  }
}

TEST(CompiledRollouts, GoByTheFunctionThatIsGivenUnlessItDoubts) {
  const Model model = load(robot("double_pendulum.toml"));
  const std::size_t N = 40;
  Starts<> at(model, N, 3);
  const Vector damping(model.tree<double>().damping.begin(), model.tree<double>().damping.end());
  for (std::size_t n = 0; n < N; ++n)
    for (std::size_t k = 1; k < K; ++k) at.tau[(n * K + k) * 2] *= 0.5;
  for (const bool alone : {false, true}) {
    std::size_t doubted = 0;
    for (std::size_t n = 0; n < (alone ? N : 1); ++n) {
      Starts<> some(at);
      if (alone) {
        some.N = 1;
        some.q.assign({at.q[2 * n], at.q[2 * n + 1]}), some.v.assign({at.v[2 * n], at.v[2 * n + 1]});
        some.tau.assign(at.tau.begin() + static_cast<std::ptrdiff_t>(n * K * 2),
                        at.tau.begin() + static_cast<std::ptrdiff_t>((n + 1) * K * 2));
      }
      Motion<> of(some);
      const batch::CompiledDynamics<double> compiled{made_up<double>, 0};
      ASSERT_TRUE(batch::rollout<double>(model, some.q, some.v, some.tau, step, of.q, of.v, runge_kutta(4), 1,
                                         {}, true, compiled)
                      .ok());
      const Motion<> librarys = under_forces(model, some, 1, true);
      for (std::size_t m = 0; m < some.N; ++m)
        for (std::size_t c = 0; c < 2; ++c) {
          const double v_0 = of.v[(m * (K + 1)) * 2 + c], v_1 = of.v[(m * (K + 1) + 1) * 2 + c],
                       tau = some.tau[m * K * 2 + c], rate = 1 + 2 * damping[c];
          if (some.tau[m * K * 2] > 0.9) {
            EXPECT_NEAR(v_1, librarys.v[(m * (K + 1) + 1) * 2 + c], 1e-11 * std::max(1.0, std::abs(v_1)));
            ++doubted;
          } else {
            EXPECT_NEAR(v_1, v_0 * std::exp(-rate * step) + 2 * tau / rate * (1 - std::exp(-rate * step)),
                        1e-12);
          }
        }
    }
    EXPECT_GT(doubted, 0u);
  }
}

}  // namespace
}  // namespace compiled_rollouts
}  // namespace axode::test
