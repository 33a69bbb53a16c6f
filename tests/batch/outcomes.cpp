#include <array>

#include "axode/batch.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Calls on many states that a monitor stops, and states for which there are no results.
namespace axode::test {
namespace {

using batch::Monitor;
using catalog::Id, catalog::Input;

constexpr std::array functions{
    Id("inverse_dynamics"), Id("forward_dynamics"), Id("mass_matrix"), Id("inverse_mass_matrix"), Id("poses"),
    Id("joint_screws")};

/// Runs a function that takes q and, for velocities, accelerations and forces alike, x. Returns the number of
/// states that were done.
std::size_t done_of(Id function, const Model& model, std::span<const double> q, std::span<const double> x,
                    std::span<double> out, int threads, const Monitor& monitor) {
  catalog::Arguments<double> given{.q = q};
  for (const Input input : function.words().numbers())
    if (input != Input::q) catalog::numbers(given, input) = x;
  return batch::run(model, function, given, out, threads, monitor).done;
}
std::size_t size_of(Id function, const Model& model) {
  return catalog::find<Fast>(function.words().name)->size(model, 0);
}
std::size_t number(int n) { return static_cast<std::size_t>(n); }

/// The arm has three hinges. The last one moves a mass, moves no mass, or is coupled to the first one.
enum class Wrist { solid, massless, coupled };
Model arm(Wrist wrist) {
  Description arm{.name = "arm"};
  const auto add = [&](const char* name, const char* on, Vec3<> axis, bool mass) {
    BodyDescription body{.name = name, .predecessor = on};
    body.joint = {.name = std::string(name) + " joint",
                  .kind = JointKind::revolute,
                  .axis = axis,
                  .point = {0, 0, 0.3}};
    if (mass) body.inertia = MassProperties{.mass = 1, .com = {0.1, 0.2, 0.3}, .Theta = {1, 1, 1}};
    arm.bodies.push_back(std::move(body));
  };
  add("upper", "ground", {0, 1, 0}, true), add("fore", "upper", {1, 0, 0}, true);
  add("hand", "fore", {0, 0, 1}, wrist != Wrist::massless);
  if (wrist == Wrist::coupled) arm.bodies.back().joint.coupling = Coupling{"upper joint", 2, 0};
  return ModelBuilder(arm).build();
}

std::vector<double> any_numbers(std::size_t size) {
  std::vector<double> x(size);
  for (std::size_t k = 0; k < size; ++k) x[k] = std::sin(static_cast<double>(k));
  return x;
}

class Batches : public testing::TestWithParam<Wrist> {};
INSTANTIATE_TEST_SUITE_P(, Batches, testing::Values(Wrist::solid, Wrist::massless, Wrist::coupled),
                         [](const auto& wrist) {
                           return std::string(wrist.param == Wrist::solid      ? "solid"
                                              : wrist.param == Wrist::massless ? "massless"
                                                                               : "coupled");
                         });

TEST_P(Batches, TheFirstResultsAreThereAndTheMonitorIsAskedNoMore) {
  const Model model = arm(GetParam());
  const std::size_t nq = number(model.nq());
  for (const Id function : functions)
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(std::string(function.words().name) + " on " + std::to_string(threads));
      int asked = 0;
      const Monitor stop = [&](std::size_t done, std::size_t of) {
        EXPECT_LE(done, of);
        ++asked;
        return false;
      };
      for (std::size_t N = 100'000; asked == 0;
           N *= 2) {  // until a call takes long enough for the monitor to be called
        ASSERT_LT(N, 100'000'000u);
        const std::vector<double> q = any_numbers(nq * N);
        const std::size_t size = size_of(function, model);
        std::vector<double> out(size * N, -1);
        const std::size_t done = done_of(function, model, q, q, out, threads, stop);
        if (asked == 0) {
          EXPECT_EQ(done, N);
        }
        if (done == N) {  // all states were done before the monitor was called
          asked = 0;
          continue;
        }
        EXPECT_EQ(asked, 1);
        EXPECT_GT(done, 0u);
        const std::size_t some = std::min<std::size_t>(done, 5000);  // the last ones that were done are
                                                                     // compared
        const std::span<const double> q_last = std::span(q).subspan((done - some) * nq, some * nq);
        std::vector<double> expected(size * some);
        done_of(function, model, q_last, q_last, expected, 1, {});
        for (std::size_t k = 0; k < expected.size(); ++k) {
          const double x = out[(done - some) * size + k];
          ASSERT_TRUE(x == expected[k] || (std::isnan(x) && std::isnan(expected[k])));
        }
      }
    }
}

TEST_P(Batches, OutcomesCountTheStatesThatAreDone) {
  const Model model = arm(GetParam());
  for (std::size_t N = 100'000;; N *= 2) {
    ASSERT_LT(N, 100'000'000u);
    const std::vector<double> q = any_numbers(number(model.nq()) * N);
    std::vector<double> a(q.size());
    const batch::Outcome outcome = batch::run(model, "forward_dynamics", {.q = q, .v = q, .tau = q}, a, 1,
                                              [](std::size_t, std::size_t) { return false; });
    EXPECT_EQ(outcome.singular_states, GetParam() == Wrist::massless ? outcome.done : 0);
    EXPECT_EQ(outcome.first, 0u);
    if (outcome.done < N) break;
  }
}

TEST(ManyStatesArguments, ResultsHaveMemoryOfTheirOwn) {
  const Model model = arm(Wrist::solid);
  const std::size_t N = 20;
  for (const Id function : functions) {
    const std::size_t size = N * size_of(function, model);
    std::vector<double> memory = any_numbers(size + 6 * N);
    const std::span<double> all(memory);
    for (const std::size_t at : {std::size_t{0}, std::size_t{1}, size - 1})
      EXPECT_THAT(message_of([&] {
                    const std::span<double> q = all.subspan(at, 3 * N);
                    done_of(function, model, q, q, all.first(size), 1, {});
                  }),
                  testing::HasSubstr(" shares memory with q; this result needs memory of its own"))
          << function.words().name << " at " << at;
    const std::span<double> beside = all.subspan(size, 3 * N);
    EXPECT_EQ(message_of([&] { done_of(function, model, beside, beside, all.first(size), 1, {}); }),
              "no error");
  }
  const std::vector<double> q = any_numbers(3 * N);
  std::vector<double> x = any_numbers(3 * N);
  EXPECT_EQ(message_of([&] {
              static_cast<void>(batch::run(model, "inverse_dynamics", {.q = q, .v = q, .a = x}, x));
            }),
            "tau shares memory with a; this result needs memory of its own");
  EXPECT_EQ(message_of([&] {
              static_cast<void>(batch::run(model, "inverse_dynamics", {.q = q, .v = x, .a = q}, x));
            }),
            "tau shares memory with v; this result needs memory of its own");
  EXPECT_EQ(message_of([&] {
              static_cast<void>(batch::run(model, "forward_dynamics", {.q = q, .v = q, .tau = x}, x));
            }),
            "a shares memory with tau; this result needs memory of its own");
}

TEST_P(Batches, WhatIsNotFiniteIsCountedAndTheOthersAreRight) {
  const Model model = arm(GetParam());
  const std::size_t N = 100, nv = number(model.nv());
  const std::vector<double> q = any_numbers(number(model.nq()) * N);
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
    std::vector<double> v = any_numbers(nv * N), tau = v, a(nv * N), right(nv * N);
    const batch::Outcome before = batch::run(model, "forward_dynamics", {.q = q, .v = v, .tau = tau}, right);
    v[37 * nv] = wrong, v[64 * nv + 1] = wrong;
    const batch::Outcome outcome = batch::run(model, "forward_dynamics", {.q = q, .v = v, .tau = tau}, a);
    if (GetParam() == Wrist::massless) {
      EXPECT_EQ(outcome.singular_states, N);
      continue;
    }
    EXPECT_TRUE(before.ok());
    EXPECT_EQ(outcome.singular_states, 2u);
    EXPECT_EQ(outcome.first, 37u);
    EXPECT_TRUE(outcome.solvability.not_finite);
    for (std::size_t k = 0; k < N; ++k)
      for (std::size_t c = 0; c < nv && k != 37 && k != 64; ++c) EXPECT_EQ(a[k * nv + c], right[k * nv + c]);
  }
}

/// With such a model each lane would need 34 GB for matrices. Functions that return no matrices must not ask
/// for that memory.
TEST(LargeTreesInBatches, NeedNoMoreMemoryThanTheirResults) {
  const std::size_t n = 65537, N = 3;
  for (const bool coupled : {false, true}) {
    SCOPED_TRACE(coupled ? "coupled" : "uncoupled");
    Description chain{.name = "chain"};
    for (std::size_t i = 0; i < n; ++i) {
      BodyDescription body{.name = "b" + std::to_string(i),
                           .predecessor = i == 0 ? "ground" : "b" + std::to_string(i - 1)};
      body.joint = {.name = "j" + std::to_string(i), .kind = JointKind::revolute, .axis = {0, 0, 1}};
      if (coupled && i > 0 && i % 2 == 0) body.joint.coupling = Coupling{"j0", 0.5, 0};
      body.inertia = MassProperties{.mass = 1, .com = {0, 0, 0}, .Theta = {1, 1, 1}};
      chain.bodies.push_back(std::move(body));
    }
    const Model model = ModelBuilder(chain).build();
    const std::size_t nv = number(model.nv());
    const std::vector<double> q(N * nv), v(N * nv), ones(N * nv, 1.0);
    std::vector<double> tau(N * nv), a(N * nv), gradient(3 * N * nv);
    EXPECT_EQ(batch::run(model, "inverse_dynamics", {.q = q, .v = v, .a = ones}, tau).done, N);
    EXPECT_TRUE(batch::run(model, "forward_dynamics", {.q = q, .v = v, .tau = tau}, a).ok());
    EXPECT_EQ(batch::run(model, "inverse_dynamics_jvp",
                         {.q = q, .v = v, .a = ones, .dq = v, .dv = v, .da = ones}, a)
                  .done,
              N);
    EXPECT_EQ(a, tau);  // at rest and without weight, the drive forces equal M times the accelerations
    EXPECT_EQ(
        batch::run(model, "inverse_dynamics_vjp", {.q = q, .v = v, .a = ones, .w = ones}, gradient).done, N);
    EXPECT_TRUE(batch::run(model, "forward_dynamics_jvp",
                           {.q = q, .v = v, .tau = tau, .dq = v, .dv = v, .dtau = tau}, a)
                    .ok());
    EXPECT_TRUE(
        batch::run(model, "forward_dynamics_vjp", {.q = q, .v = v, .tau = tau, .w = ones}, gradient).ok());
  }
}

}  // namespace
}  // namespace axode::test
