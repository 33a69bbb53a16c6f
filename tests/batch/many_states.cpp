#include "axode/batch.hpp"

#include <gmock/gmock.h>

#include "axode/dynamics.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/random_states.hpp"
#include "tests/support/refused_arguments.hpp"

/// A call on many states gives the same results as calls on each of them alone, whatever the number of
/// states, their order and the number of threads.
namespace axode::test {
namespace {

using catalog::Id;

template <class T> class ManyStates : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(ManyStates, Scalars);

Model tree(Random<double>& random) {
  for (;;) {
    Model model = ModelBuilder(described(random_mechanism(random, {}), random)).build();
    if (model.nq() > 0) return model;
  }
}
std::size_t some_number(std::uint64_t seed) {
  const std::size_t numbers[]{1, 2, 3, 7, 8, 9, 16, 17, 31, 33};
  return numbers[seed % std::size(numbers)];
}
template <class T> std::vector<T> part(const std::vector<T>& all, std::size_t k, std::size_t n) {
  return {all.begin() + static_cast<std::ptrdiff_t>(k * n),
          all.begin() + static_cast<std::ptrdiff_t>((k + 1) * n)};
}

/// The forces that belong to accelerations or their rates: M times each of these matrices, whose columns
/// belong to one direction each.
template <class T>
std::vector<T> by_mass(const std::vector<T>& M, const std::vector<T>& all, std::size_t nv,
                       std::size_t columns) {
  std::vector<T> out(all.size());
  for (std::size_t block = 0; block < all.size(); block += nv * columns)
    for (std::size_t r = 0; r < nv; ++r)
      for (std::size_t c = 0; c < columns; ++c)
        for (std::size_t i = 0; i < nv; ++i)
          out[block + r * columns + c] += M[r * nv + i] * all[block + i * columns + c];
  return out;
}

template <class T> double largest_of(const std::vector<T>& x) {
  return largest(std::vector<double>(x.begin(), x.end()));
}

/// Compares every function that runs in lanes. Results that contain M⁻¹ are compared after multiplication by
/// M, as forces, and derivatives relative to the largest of the forces.
TYPED_TEST(ManyStates, GiveInEveryFunctionWhatTheyGiveOneByOne) {
  using T = TypeParam;
  Comparison number("number", agreement<T>), force("force", agreement<T>);
  int singular = 0, regular = 0;
  std::size_t compared = 0;
  for_seeds(300, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = tree(random);
    const std::size_t N = some_number(seed), nv = static_cast<std::size_t>(model.nv());
    const RandomStates<T> states(model, N, seed + 5000);
    Workspace<T> workspace(model);
    const auto run = [&](const catalog::Function<T>& row, const catalog::Arguments<T>& given) {
      std::vector<T> out(given.q.size() / static_cast<std::size_t>(model.nq()) * row.size(model, 0));
      return std::pair(batch::run<T>(model, *Id::of(row.name), given, out), out);
    };
    const auto rows = catalog::functions<Fast, T>();
    const auto find = [](std::string_view name) { return catalog::find<Fast, T>(name); };
    const std::vector<T> M = run(*find("mass_matrix"), {.q = states.q}).second;
    const std::vector<T> tau =
        run(*find("inverse_dynamics"), {.q = states.q, .v = states.v, .a = states.a}).second;
    std::size_t singular_states = 0;
    for (const catalog::Function<T>& row : rows) {
      const bool derivative = row.name.find("_dynamics_") != std::string_view::npos;
      if (!row.lanes || (derivative && seed > 100)) continue;  // derivatives take long
      SCOPED_TRACE(std::string(row.name));
      const auto given = [&](std::size_t first, std::size_t count) {
        catalog::Arguments<T> all = states.given(model, row, first, count);
        if (row.name == "forward_dynamics") all.tau = std::span(tau).subspan(first * nv, count * nv);
        return all;
      };
      const std::size_t size = row.size(model, 0);
      const auto [outcome, all] = run(row, given(0, N));
      EXPECT_EQ(outcome.done, N);
      std::size_t failed = 0;
      for (std::size_t k = 0; k < N; ++k) {
        std::vector<T> alone(size);
        const std::vector<T> found = part(all, k, size), M_k = part(M, k, nv * nv);
        if (!row.call(model, workspace, given(k, 1), alone).ok()) {
          if (failed++ == 0) {
            EXPECT_EQ(outcome.first, k);
          }
          EXPECT_TRUE(std::ranges::all_of(found, [](T x) { return std::isnan(x); }));
          continue;
        }
        double scale = 0;
        if (derivative) {
          const catalog::Function<T>& derivatives = *find("inverse_dynamics_derivatives");
          std::vector<T> dtau(3 * nv * nv);
          std::ignore = derivatives.call(model, workspace, states.given(model, derivatives, k, 1), dtau);
          scale = std::max(largest_of(dtau), 1e-6);
        }
        ++compared;
        if (row.name == "inverse_mass_matrix") {
          expect_same_inverse(found, alone, M_k, agreement<T>);
        } else if (row.name == "forward_dynamics") {
          std::vector<T> back(nv);
          inverse_dynamics(model, workspace, states.given(model, row, k, 1).q,
                           states.given(model, row, k, 1).v, found, back);
          force.expect_equal(back, part(tau, k, nv));
        } else if (!row.may_fail) {
          number.expect_equal(found, alone, scale);
        } else if (std::same_as<T, float> || row.name == "forward_dynamics_vjp") {
          EXPECT_TRUE(
              std::ranges::all_of(found, [](T x) { return std::isfinite(x); }));  // M may be ill-conditioned
        } else {
          const std::size_t columns = row.name == "forward_dynamics_jvp" ? 1 : nv;
          force.expect_equal(by_mass(M_k, found, nv, columns), by_mass(M_k, alone, nv, columns), scale);
        }
      }
      if (row.may_fail) {
        EXPECT_EQ(outcome.singular_states, failed);
      }
      if (row.name == "forward_dynamics") singular_states = failed;
    }
    (singular_states > 0 ? singular : regular) += 1;
  });
  EXPECT_GE(singular, (singular + regular) / 20);
  EXPECT_GE(regular, (singular + regular) / 20);
  EXPECT_GT(compared, 0U);
}

TYPED_TEST(ManyStates, DependOnNeitherTheirPlaceNorTheThreads) {
  using T = TypeParam;
  for_seeds(60, [&](std::uint64_t seed) {
    Random<double> random(1000 + seed);
    const Model model = tree(random);
    const RandomStates<T> states(model, 37, 2000 + seed);
    const std::size_t N = 37, nq = static_cast<std::size_t>(model.nq()),
                      nv = static_cast<std::size_t>(model.nv());
    const std::vector<T>&q = states.q, &v = states.v, &x = states.a;
    const auto everything = [&](std::span<const T> q_, std::span<const T> v_, std::span<const T> x_,
                                int threads) {
      const std::size_t n = q_.size() / nq;
      std::vector<T> all(n * nv * 2 + n * nv * nv * 2);
      const std::span<T> out(all);
      EXPECT_TRUE(
          batch::run<T>(model, "inverse_dynamics", {.q = q_, .v = v_, .a = x_}, out.first(n * nv), threads)
              .ok());
      EXPECT_EQ(batch::run<T>(model, "forward_dynamics", {.q = q_, .v = v_, .tau = x_},
                              out.subspan(n * nv, n * nv), threads)
                    .done,
                n);
      EXPECT_TRUE(
          batch::run<T>(model, "mass_matrix", {.q = q_}, out.subspan(2 * n * nv, n * nv * nv), threads).ok());
      EXPECT_EQ(batch::run<T>(model, "inverse_mass_matrix", {.q = q_}, out.last(n * nv * nv), threads).done,
                n);
      return all;
    };
    const auto same = [](T a, T b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    const std::vector<T> alone = everything(q, v, x, 1);
    for (const int threads : {2, 5}) {
      const std::vector<T> shared = everything(q, v, x, threads);
      EXPECT_TRUE(std::equal(alone.begin(), alone.end(), shared.begin(), same)) << threads << " threads";
    }
    for (std::size_t k = 0; k < N; k += 5) {
      const std::vector<T> one =
          everything(std::span(q).subspan(k * nq, nq), std::span(v).subspan(k * nv, nv),
                     std::span(x).subspan(k * nv, nv), 1);
      EXPECT_TRUE(std::equal(one.begin(), one.begin() + static_cast<std::ptrdiff_t>(nv),
                             alone.begin() + static_cast<std::ptrdiff_t>(k * nv), same));
      EXPECT_TRUE(std::equal(one.end() - static_cast<std::ptrdiff_t>(nv * nv), one.end(),
                             alone.end() - static_cast<std::ptrdiff_t>((N - k) * nv * nv), same));
    }
  });
}

TYPED_TEST(ManyStates, MayBeNone) {
  using T = TypeParam;
  Random<double> random(1);
  const Model model = tree(random);
  std::vector<T> none;
  EXPECT_TRUE(batch::run<T>(model, "inverse_dynamics", {.q = none, .v = none, .a = none}, none).ok());
  EXPECT_TRUE(batch::run<T>(model, "forward_dynamics", {.q = none, .v = none, .tau = none}, none, 3).ok());
  EXPECT_TRUE(batch::run<T>(model, "mass_matrix", {.q = none}, none).ok());
  EXPECT_TRUE(batch::run<T>(model, "inverse_mass_matrix", {.q = none}, none).ok());
}

TEST(ManyStatesArguments, AreChecked) {
  const Model model = ModelBuilder("ball")
                          .add({.name = "ball",
                                .joint = {.kind = JointKind::spherical},
                                .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}})
                          .build();
  const std::vector<double> q{0, 0, 0, 1, 0, 0, 0, 1}, v(6), a(5), off{0, 0, 0, 1, 0, 0, 0, 1.1};
  std::vector<double> tau(6);
  const auto call = [&](const std::vector<double>& q_, const std::vector<double>& v_,
                        const std::vector<double>& a_, int threads = 1) {
    return message_of([&] {
      EXPECT_TRUE(batch::run(model, "inverse_dynamics", {.q = q_, .v = v_, .a = a_}, tau, threads).ok());
    });
  };
  EXPECT_EQ(call(q, v, a), "a has 5 entries; expected nv N = 6");
  EXPECT_EQ(call(q, a, v), "v has 5 entries; expected nv N = 6");
  EXPECT_EQ(call({0, 0, 1}, v, v), "q has 3 entries; expected a multiple of nq = 4");
  EXPECT_EQ(call(q, v, v, 0), "threads is 0; expected 1 or more");
  EXPECT_THAT(call(off, v, v),
              testing::StartsWith("state 1: q: the quaternion of joint \"ball_joint\" has norm 1.1"));
}

}  // namespace
}  // namespace axode::test
