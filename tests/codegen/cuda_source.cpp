#include <algorithm>
#include <memory>
#include <numeric>

#include "axode/codegen.hpp"
#include "axode/codegen/tape/statement_order.hpp"
#include "tests/codegen/compiled.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/refused_arguments.hpp"

/// Generated kernels for a GPU: their text, and their results on random trees when they are compiled for the
/// processor and run thread by thread. The tests in tests/bridges compare every recorded function on a few
/// mechanisms.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;

class GeneratedCuda : public Law {};
INSTANTIATE_TEST_SUITE_P(Codegen, GeneratedCuda, testing::ValuesIn(scalars()), name_of);

constexpr const char* shim = R"(
#include <math.h>
#include <stdlib.h>
struct Index { unsigned x; };
static Index blockIdx, blockDim, threadIdx;
extern "C" void be_thread(unsigned block, unsigned size, unsigned thread) {
  blockIdx.x = block, blockDim.x = size, threadIdx.x = thread;
}
#define __device__
#define __global__
#define __forceinline__ inline
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(threads)
)";
const std::vector<std::string> as_cpp{"-x", "c++", "-std=c++14"};

/// Runs a kernel for states that are stored one after the other and returns its results in the same order.
template <class T>
std::vector<double> run_in(const Compiled& library, const std::string& name,
                           const std::vector<std::vector<double>>& arguments, std::size_t states,
                           std::size_t size) {
  std::vector<std::vector<T>> x;
  for (const std::vector<double>& argument : arguments) {
    const std::size_t length = argument.size() / states;
    x.emplace_back(argument.size());
    for (std::size_t k = 0; k < argument.size(); ++k)
      x.back()[k % length * states + k / length] = static_cast<T>(argument[k]);
  }
  std::vector<T> out(size * states, T(7));
  const auto be_thread = library.function<void(unsigned, unsigned, unsigned)>("be_thread");
  const auto call = [&](auto... pointers) {
    library.function<void(decltype(pointers)..., T*, int)>(name + "_states")(pointers..., out.data(),
                                                                             static_cast<int>(states));
  };
  constexpr unsigned block = 4;
  for (unsigned thread = 0; thread < (states + block - 1) / block * block; ++thread) {
    be_thread(thread / block, block, thread % block);
    const auto pointer = [&](std::size_t k) { return static_cast<const T*>(x.at(k).data()); };
    if (x.size() == 1)
      call(pointer(0));
    else
      call(pointer(0), pointer(1), pointer(2));
  }
  std::vector<double> result(out.size());
  for (std::size_t k = 0; k < out.size(); ++k)
    result[k % states * size + k / states] = static_cast<double>(out[k]);
  return result;
}

TEST_P(GeneratedCuda, GivesWhatTheLibraryGives) {
  const Case fastest = fast(GetParam());
  Comparison force("force", fastest.agreement()), inertia("mass matrix", fastest.agreement()),
      derivative("derivative", fastest.agreement());
  const std::vector<Function> functions{{Id("inverse_dynamics")},
                                        {Id("mass_matrix")},
                                        {Id("inverse_dynamics_derivatives")},
                                        {Id("forward_dynamics")}};
  constexpr std::size_t states = 5;
  constexpr std::uint64_t models = 10;
  std::vector<std::unique_ptr<Trial>> trials;
  std::vector<codegen::Source> sources;
  std::string text = shim;
  for (std::uint64_t seed = 1; seed <= models; ++seed) {
    trials.emplace_back(new Trial(fastest, seed, TreeRecipe{.most_bodies = 12, .springs = 0}));
    sources.push_back(codegen::c_source(trials.back()->model, functions,
                                        {"tree" + std::to_string(seed), fastest.single, codegen::Abi::cuda}));
    std::string& source = sources.back().text;
    if (seed > 1)
      source.erase(source.find("/* Entry k"), source.find("/* The drive forces") - source.find("/* Entry k"));
    text += source;
  }
  const Compiled library(text, as_cpp);
  int solvable = 0, doubted = 0;
  for (std::size_t m = 0; m < models; ++m) {
    SCOPED_TRACE("seed " + std::to_string(m + 1));
    Trial& trial = *trials[m];
    const std::size_t nv = static_cast<std::size_t>(trial.model.nv());
    Random<double> random(m + 1000);
    std::vector<Ask> asks;
    std::vector<double> q, v, a, tau;
    const auto append = [](std::vector<double>& to, const std::vector<double>& x) {
      to.insert(to.end(), x.begin(), x.end());
    };
    for (std::size_t s = 0; s < states; ++s) {
      const State<double> state = rounded(fastest, random_state(trial.model, random));
      asks.push_back({.q = state.q, .v = state.v, .a = state.a});
      asks.back().tau = trial.call("inverse_dynamics", asks.back());
      append(q, state.q);
      append(v, state.v);
      append(a, state.a);
      append(tau, asks.back().tau);
    }
    const auto results = [&](std::size_t f, const std::vector<std::vector<double>>& x, std::size_t size) {
      const auto all =
          (fastest.single ? run_in<float> : run_in<double>)(library, sources[m].functions[f].name, x, states,
                                                            size);
      std::vector<std::vector<double>> by_state;
      for (std::size_t s = 0; s < states; ++s)
        by_state.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(s * size),
                              all.begin() + static_cast<std::ptrdiff_t>((s + 1) * size));
      return by_state;
    };
    const auto forces = results(0, {q, v, a}, nv), M = results(1, {q}, nv * nv),
               dtau = results(2, {q, v, a}, 3 * nv * nv), found = results(3, {q, v, tau}, nv);
    for (std::size_t s = 0; s < states; ++s) {
      force.expect_equal(forces[s], asks[s].tau);
      inertia.expect_equal(M[s], trial.call("mass_matrix", asks[s]));
      const auto expected = trial.call("inverse_dynamics_derivatives", asks[s]);
      derivative.expect_equal(dtau[s], expected, std::max(largest(expected), 1e-6));
      const bool is_nan = nv > 0 && std::isnan(found[s][0]);
      doubted += is_nan;
      EXPECT_TRUE(is_nan || trial.answer("forward_dynamics", asks[s]).solvability.ok());
      if (is_nan)
        EXPECT_TRUE(std::ranges::all_of(found[s], [](double x) { return std::isnan(x); }));
      else
        ++solvable,
            force.expect_equal(
                trial.call("inverse_dynamics", {.q = asks[s].q, .v = asks[s].v, .a = found[s]}), asks[s].tau);
    }
  }
  EXPECT_GE(solvable, static_cast<int>(models) * 3 / 2);
  EXPECT_GE(doubted, 1);
}

TEST(GeneratedCudaArguments, AreThoseOfC) {
  const Model rod = ModelBuilder("rod")
                        .add({.name = "rod",
                              .joint = {.kind = JointKind::revolute, .axis = {1, 0, 0}},
                              .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}})
                        .build();
  const auto source = [&](const std::vector<Function>& functions, const std::string& prefix = "") {
    return codegen::c_source(rod, functions, {.prefix = prefix, .abi = codegen::Abi::cuda});
  };
  EXPECT_EQ(message_of([&] { source({}); }),
            "functions is empty; expected at least one to generate code for");
  EXPECT_EQ(message_of([&] {
              source({{Id("jacobian"), 9}});
            }),
            "frame is 9; model \"rod\" has frames 0 to 1");
  const codegen::Source one = source({{Id("forward_dynamics")}}, "r");
  EXPECT_EQ(one.functions.at(0).name, "r_forward_dynamics");
  EXPECT_NE(one.text.find("enum { r_nq = 1, r_nv = 1, r_n_frames = 2 };"), std::string::npos);
  EXPECT_NE(one.text.find("static __device__ __forceinline__ int r_forward_dynamics("), std::string::npos);
  EXPECT_NE(one.text.find("extern \"C\" __global__ __launch_bounds__(128) void r_forward_dynamics_states("),
            std::string::npos);
}

/// The largest number of results that are waiting at the same time to be used by a later statement of this
/// order. Also expects that operands come before the statements that use them.
int most_waiting(const std::vector<std::vector<int>>& operands, const std::vector<int>& order) {
  std::vector<int> uses(operands.size()), done(operands.size());
  for (const auto& from : operands)
    for (const int k : from) ++uses[static_cast<std::size_t>(k)];
  int waiting = 0, most = 0;
  for (const int k : order) {
    for (const int from : operands[static_cast<std::size_t>(k)]) {
      EXPECT_TRUE(done[static_cast<std::size_t>(from)]);
      waiting -= --uses[static_cast<std::size_t>(from)] == 0;
    }
    done[static_cast<std::size_t>(k)] = 1;
    waiting += uses[static_cast<std::size_t>(k)] > 0;
    most = std::max(most, waiting);
  }
  EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), std::ssize(operands));
  return most;
}

TEST(StatementOrder, DoesOneBranchAfterTheOther) {
  constexpr int branches = 50,
                steps = 20;  // statement s of branch b is s * branches + b, as a recursion records them
  std::vector<std::vector<int>> operands(static_cast<std::size_t>(branches * steps));
  for (int k = branches; k < branches * steps; ++k) operands[static_cast<std::size_t>(k)] = {k - branches};
  std::vector<int> recorded(operands.size());
  std::iota(recorded.begin(), recorded.end(), 0);
  EXPECT_EQ(most_waiting(operands, recorded), branches);
  EXPECT_EQ(most_waiting(operands, codegen::order_for_few_registers(operands, {})), 1);
}

TEST(StatementOrder, HasOperandsFirst) {
  Random<double> random(5);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = static_cast<int>(random.number(0, 200));
    std::vector<std::vector<int>> operands;
    for (int k = 0; k < n; ++k) {
      operands.emplace_back();
      for (int i = 0; k > 0 && i < 3; ++i)
        if (const int from = static_cast<int>(random.number(0, k));
            std::ranges::find(operands.back(), from) == operands.back().end())
          operands.back().push_back(from);
    }
    const std::vector<int> lasting = n > 0 ? std::vector<int>{n / 2} : std::vector<int>{};
    most_waiting(operands, codegen::order_for_few_registers(operands, lasting));
  }
}

}  // namespace
}  // namespace axode::test
