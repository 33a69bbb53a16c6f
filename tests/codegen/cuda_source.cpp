#include <algorithm>
#include <numeric>

#include "axode/codegen.hpp"
#include "axode/codegen/tape/statement_order.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// The text of kernels for a GPU. They are compiled for the processor and compared with the library in tests/bridges/cuda.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;

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

/// How many numbers wait at a time, at most, and whether operands come first.
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
