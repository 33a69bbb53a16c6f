#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "axode/codegen.hpp"
#include "axode/io.hpp"
#include "tests/codegen/specialised_models.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// batch::run() with a specialised model gives the same results as with the model, whatever is asked of it.
namespace axode::test {
namespace {

using batch::Monitor;
using catalog::Id, catalog::Input;

/// The states from index `first` on.
template <class T> RandomStates<T> from(std::size_t first, std::size_t N, RandomStates<T> states) {
  for (auto* x : {&states.q, &states.v, &states.a, &states.dq, &states.dv, &states.da, &states.w})
    x->erase(x->begin(), x->begin() + static_cast<std::ptrdiff_t>(x->size() / N * first));
  return states;
}

/// Runs a function in all states, with a model or a specialised model.
template <class T, class M>
batch::Outcome call(Id function, const M& m, const RandomStates<T>& all, std::span<T> out, int threads = 1,
                    const Monitor& monitor = {}) {
  const auto& [q, v, x, dq, dv, dx, w] = all;  // x serves as accelerations or as forces
  catalog::Arguments<T> given{.q = q};
  const std::pair<Input, std::span<const T>> others[]{{Input::v, v},     {Input::a, x},      {Input::tau, x},
                                                      {Input::dq, dq},   {Input::dv, dv},    {Input::da, dx},
                                                      {Input::dtau, dx}, {Input::weights, w}};
  for (const auto& [input, numbers] : others)
    if (function.words().takes_input(input)) catalog::numbers(given, input) = numbers;
  return batch::run<T>(m, {function}, given, out, threads, monitor);
}

const std::vector<codegen::Function> batches{{Id("inverse_dynamics")},
                                             {Id("forward_dynamics")},
                                             {Id("mass_matrix")},
                                             {Id("inverse_mass_matrix")},
                                             {Id("poses")},
                                             {Id("inverse_dynamics_derivatives")},
                                             {Id("forward_dynamics_derivatives")},
                                             {Id("inverse_dynamics_jvp")},
                                             {Id("forward_dynamics_jvp")},
                                             {Id("inverse_dynamics_vjp")},
                                             {Id("forward_dynamics_vjp")}};

std::string name_of(Id quantity) { return std::string(quantity.words().name); }
/// The size of the result for one state, in numbers.
std::size_t size_of(Id quantity, const Model& model) {
  return catalog::find<Fast>(name_of(quantity))->size(model, 0);
}
bool is_solved(Id quantity) { return quantity.words().may_fail; }

template <class T> void expect_same(const std::vector<T>& x, const std::vector<T>& y) {
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t k = 0; k < x.size(); ++k)
    ASSERT_TRUE(x[k] == y[k] || (std::isnan(x[k]) && std::isnan(y[k]))) << k << ": " << x[k] << ' ' << y[k];
}

template <class T> double largest_number(std::span<const T> x) {
  double largest = 0;
  for (const T number : x) largest = std::max(largest, std::abs(static_cast<double>(number)));
  return largest;
}

void expect_same(const batch::Outcome& x, const batch::Outcome& y) {
  EXPECT_EQ(x.done, y.done);
  EXPECT_EQ(x.singular_states, y.singular_states);
  EXPECT_EQ(x.first, y.first);
  EXPECT_EQ(x.solvability, y.solvability);
}

/// Compares all functions in N states. Results that contain M⁻¹ are compared to the accuracy that the
/// condition of M allows.
template <class T>
void expect_the_librarys(const Model& model, const Specialised<T>& specialised, std::size_t N, int threads,
                         double tolerance) {
  const RandomStates<T> all(model, N, 7 + N);
  const std::size_t nv2 = size_of(Id("mass_matrix"), model);
  std::vector<T> M(nv2 * N), M_inverse(nv2 * N);
  EXPECT_TRUE(batch::run<T>(model, "mass_matrix", {.q = all.q}, M).ok());
  EXPECT_EQ(batch::run<T>(model, "inverse_mass_matrix", {.q = all.q}, M_inverse).done, N);
  for (const codegen::Function& function : batches) {
    if (!specialised.has(function)) continue;
    SCOPED_TRACE(name_of(function.row) + " of " + std::to_string(N) + " states of " + model.name() + " on " +
                 std::to_string(threads));
    const std::size_t size = size_of(function.row, model);
    std::vector<T> found(size * N, -1), expected(size * N, -1);
    expect_same(call<T>(function.row, specialised, all, found, threads),
                call<T>(function.row, model, all, expected, threads));
    for (std::size_t k = 0; k < N; ++k) {
      const auto of_state = [&](const std::vector<T>& x, std::size_t n) {
        return std::span(x).subspan(k * n, n);
      };
      double scale = std::max(largest_number(of_state(expected, size)), 1e-6);
      if (is_solved(function.row))
        scale *=
            std::max(1.0, 1e-2 * largest_number(of_state(M, nv2)) * largest_number(of_state(M_inverse, nv2)));
      for (std::size_t i = k * size; i < (k + 1) * size; ++i)
        if (std::isnan(expected[i])) {
          ASSERT_TRUE(std::isnan(found[i])) << i;
        } else {
          ASSERT_NEAR(found[i], expected[i], tolerance * scale) << i;
        }
    }
  }
}

class SpecialisedBatches : public SpecialisedModels {};

TEST_F(SpecialisedBatches, GiveWhatTheLibrarysGive) {
  for_seeds(4, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model =
        seed == 1 ? every_joint()
                  : ModelBuilder(described(random_mechanism(random, {.most_bodies = 7}), random)).build();
    const Specialised<> specialised(model, batches, {.flags = quickly});
    for (const std::size_t N : {0, 1, 2, 3, 7, 8, 9, 17, 67})
      for (const int threads : {1, 4}) expect_the_librarys(model, specialised, N, threads, 1e-12);
  });
}

TEST_F(SpecialisedBatches, GiveItInSinglePrecision) {
  const Model model = load(robot("double_pendulum.toml"));
  const Specialised<float> specialised(model, batches, {.flags = quickly});
  for (const std::size_t N : {1, 5, 33})
    for (const int threads : {1, 4}) expect_the_librarys(model, specialised, N, threads, 1e-4);
}

TEST_F(SpecialisedBatches, GiveTheDerivativesOfManyStates) {
  const Model model = load(robot("arm7.toml"));
  const Specialised<> specialised(
      model, {{Id("inverse_dynamics_derivatives")}, {Id("forward_dynamics_derivatives")}},
      {.flags = quickly});
  for (const int threads : {1, 4}) expect_the_librarys(model, specialised, 1001, threads, 1e-12);
}

/// The code is compiled such that a state alone and the same state in lanes would be rounded differently.
TEST_F(SpecialisedBatches, DependOnNeitherTheirPlaceNorTheThreads) {
  const Model model = load(robot("arm7.toml"));
  const std::vector<codegen::Function> functions{{Id("poses")}, {Id("inverse_dynamics_derivatives")}};
  const Specialised<> specialised(
      model, functions, {.flags = {"-O3", "-march=native", "-ffp-contract=fast", "-ftree-slp-vectorize"}});
  const std::size_t N = 53;
  const RandomStates<double> all(model, N, 1);
  for (const auto& [quantity, frame, representation] : functions) {
    SCOPED_TRACE(name_of(quantity));
    const std::size_t size = size_of(quantity, model);
    std::vector<double> alone(size * N), shared(size * N);
    ASSERT_EQ(call<double>(quantity, specialised, all, alone).done, N);
    for (const int threads : {2, 5}) {
      ASSERT_EQ(call<double>(quantity, specialised, all, shared, threads).done, N);
      expect_same(alone, shared);
    }
    for (std::size_t first = 1; first < N - 1; ++first) {
      std::vector<double> part(size * (N - first));
      ASSERT_EQ(call<double>(quantity, specialised, from(first, N, all), part).done, N - first);
      expect_same(part, {alone.begin() + static_cast<std::ptrdiff_t>(first * size), alone.end()});
    }
  }
}

TEST_F(SpecialisedBatches, LeaveWhatIsSingularOrNotFiniteToTheLibrary) {
  const Model pendulum = load(robot("double_pendulum.toml"));
  for (const Model& model : {singular_wrist(), pendulum, every_joint()}) {
    const Specialised<> specialised(model, {{Id("forward_dynamics")}, {Id("forward_dynamics_derivatives")}},
                                    {.flags = quickly});
    const std::size_t N = 50, nv = static_cast<std::size_t>(model.nv());
    for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
      RandomStates<double> all(model, N, 3);
      all.v[37 * nv] = wrong, all.a[21 * nv + 1] = wrong * 1e300, all.v[49 * nv + 1] = wrong;
      if (model.tree<double>()->quaternion_bodies.empty()) all.q[5 * nv + 1] = std::nan("");
      for (const Id quantity : {Id("forward_dynamics"), Id("forward_dynamics_derivatives")})
        for (const int threads : {1, 4}) {
          SCOPED_TRACE(name_of(quantity) + " of " + model.name() + " with " + std::to_string(wrong));
          const std::size_t size = size_of(quantity, model);
          std::vector<double> found(size * N), expected(size * N);
          const batch::Outcome outcome = call<double>(quantity, specialised, all, found, threads);
          expect_same(outcome, call<double>(quantity, model, all, expected, threads));
          EXPECT_GE(outcome.singular_states, 3u);
          for (std::size_t k = 0; k < N; ++k) {
            const auto is_finite = [&](const std::vector<double>& x) {
              return std::ranges::all_of(std::span(x).subspan(k * size, size),
                                         [](double number) { return std::isfinite(number); });
            };
            EXPECT_EQ(is_finite(found), is_finite(expected)) << k;
          }
        }
    }
  }
}

TEST_F(SpecialisedBatches, EndWhereTheMonitorSaysSo) {
  const Model model = load(robot("double_pendulum.toml"));
  const Id quantity = Id("forward_dynamics_derivatives");
  const Specialised<> specialised(model, {{quantity}}, {.flags = quickly});
  const std::size_t size = size_of(quantity, model), repeated = 1000;
  const RandomStates<double> some(model, repeated, 2);
  std::vector<double> expected(size * repeated);
  ASSERT_TRUE(call<double>(quantity, specialised, some, expected).ok());
  for (const int threads : {1, 4}) {
    int asked = 0;
    for (std::size_t times = 100; asked == 0;
         times *= 2) {  // until a call takes long enough for the monitor to be called
      ASSERT_LT(times, 100'000u);
      RandomStates<double> all(some);
      for (std::size_t k = 1; k < times; ++k) {
        all.q.insert(all.q.end(), some.q.begin(), some.q.end());
        all.v.insert(all.v.end(), some.v.begin(), some.v.end());
        all.a.insert(all.a.end(), some.a.begin(), some.a.end());
      }
      const std::size_t N = times * repeated;
      std::vector<double> out(size * N, -1);
      const batch::Outcome outcome =
          call<double>(quantity, specialised, all, out, threads, [&](std::size_t done, std::size_t of) {
            EXPECT_LE(done, of);
            EXPECT_EQ(of, N);
            ++asked;
            return false;
          });
      EXPECT_TRUE(outcome.ok());
      EXPECT_LE(asked, 1);
      if (asked == 0) {
        EXPECT_EQ(outcome.done, N);
      } else if (outcome.done == N) {  // all states were done before the monitor was called
        asked = 0;
      }
      EXPECT_GT(outcome.done, 0u);
      for (std::size_t k = 0; k < outcome.done * size; ++k)
        ASSERT_EQ(out[k], expected[k % expected.size()]) << k;
    }
  }
}

TEST_F(SpecialisedBatches, RefuseWhatTheLibrarysRefuse) {
  const Model model = shoulder();
  const Specialised<> specialised(model, batches, {.flags = quickly});
  const std::size_t N = 3;
  for (const codegen::Function& function : batches) {
    const Id quantity = function.row;
    const std::size_t size = size_of(quantity, model) * N;
    const auto both_say = [&](const auto& spoil, int threads = 1) {
      RandomStates<double> all(model, N, 4);
      std::vector<double> out(size);
      spoil(all, out);
      const auto message = [&](const auto& m) {
        return message_of([&] { static_cast<void>(call<double>(quantity, m, all, out, threads)); });
      };
      EXPECT_EQ(message(specialised), message(model)) << name_of(quantity);
      return message(model);
    };
    EXPECT_EQ(both_say([](auto&, auto&) {}), "no error");
    EXPECT_NE(both_say([](auto& all, auto&) { all.q.pop_back(); }), "no error");
    EXPECT_NE(both_say([](auto& all, auto&) { all.q[8] = 3; }), "no error");
    EXPECT_EQ(both_say([](auto&, auto&) {}, 0), "threads is 0; expected 1 or more");
    if (quantity == Id("poses")) continue;  // whose result is counted in numbers here
    EXPECT_NE(both_say([](auto&, auto& out) { out.push_back(0); }), "no error");
    for (const auto argument :
         {&RandomStates<double>::v, &RandomStates<double>::a, &RandomStates<double>::dq,
          &RandomStates<double>::dv, &RandomStates<double>::da, &RandomStates<double>::w})
      both_say([&](auto& all, auto& out) { (all.*argument).pop_back(), out.pop_back(); });
    for (const auto argument : {&RandomStates<double>::q, &RandomStates<double>::v, &RandomStates<double>::a,
                                &RandomStates<double>::dq, &RandomStates<double>::w}) {
      const RandomStates<double> all(model, N, 4);
      const std::span<double> inside(const_cast<double*>((all.*argument).data()), (all.*argument).size());
      if (size != inside.size()) continue;
      const auto message = [&](const auto& m) {
        return message_of([&] { static_cast<void>(call<double>(quantity, m, all, inside)); });
      };
      EXPECT_EQ(message(specialised), message(model)) << name_of(quantity);
    }
  }
  std::vector<double> q{0, 0, 0, 1, 0}, v(4), a(4), tau(4);
  EXPECT_EQ(message_of([&] {
              static_cast<void>(batch::run(specialised, {"inverse_dynamics"}, {.q = q, .v = v, .a = a}, a));
            }),
            "tau shares memory with a; this result needs memory of its own");
  const Specialised<> without(model, {{Id("poses")}}, {.flags = quickly});
  EXPECT_EQ(message_of([&] {
              static_cast<void>(batch::run(without, {"inverse_dynamics"}, {.q = q, .v = v, .a = a}, tau));
            }),
            "model \"shoulder\" was specialised without inverse_dynamics");
}

}  // namespace
}  // namespace axode::test
