#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "axode/scalar/instruction_set.hpp"
#include "tests/laws/law.hpp"

/// The fast path gives the same results as the hybrid representation: on trees with all kinds of joints, with
/// couplings, loads and losses, and where the mass matrix is singular.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

class FastPath : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, FastPath, testing::ValuesIn(scalars()), name_of);

TEST_P(FastPath, GivesTheSameForces) {
  Comparison force("force", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial hybrid(GetParam(), seed), fastest = hybrid.by(fast(GetParam()));
    Ask ask = hybrid.ask();
    ask.loads.joint_losses = seed % 2 == 0;
    const auto all = [&](Trial& trial) {
      Numbers forces;
      for (const char* function :
           {"inverse_dynamics", "coriolis_vector", "gravity_torques", "generalized_loads"}) {
        const Numbers part = trial.call(function, ask);
        forces.insert(forces.end(), part.begin(), part.end());
      }
      return forces;
    };
    force.expect_equal(all(fastest), all(hybrid));
  });
}

TEST_P(FastPath, GivesTheSameMassMatrixAndJudgesItsInverseAlike) {
  Comparison inertia("mass matrix", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial hybrid(GetParam(), seed), fastest = hybrid.by(fast(GetParam()));
    const Numbers M = fastest.call("mass_matrix");
    inertia.expect_equal(M, hybrid.call("mass_matrix"));
    const std::size_t nv = hybrid.state.v.size();
    for (std::size_t i = 0; i < nv && hybrid.model.n_screws() == hybrid.model.nv(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_EQ(M[i * nv + j], M[j * nv + i]) << "symmetric to the last bit where no joints are coupled";
    const Answer inverse = fastest.answer("inverse_mass_matrix", fastest.ask()),
                 judged = hybrid.answer("inverse_mass_matrix", hybrid.ask());
    EXPECT_EQ(inverse.solvability.singular_body, judged.solvability.singular_body);
    if (inverse.solvability.ok())
      expect_same_inverse(inverse.numbers, judged.numbers, M, GetParam().agreement());
  });
}

Model chain(Random<double>& random, int n) {
  ModelBuilder builder("chain");
  for (int i = 1; i <= n; ++i)
    builder.add({.name = std::to_string(i),
                 .predecessor = i == 1 ? "ground" : std::to_string(i - 1),
                 .joint = {.kind = JointKind::revolute, .axis = random.vector(), .point = random.vector()},
                 .inertia = MassProperties{.mass = 1, .Theta = {.1, .1, .1, 0, 0, 0}}});
  return builder.build();
}

TEST(FastMatrices, AreWrittenFromTheFirstEntryToTheLast) {
  for (int n = 1; n <= 40; ++n) {
    Random<double> random(static_cast<std::uint64_t>(n));
    const Model model = chain(random, n);
    Workspace<> workspace(model);
    const Numbers q = random_numbers(random, n);
    const std::size_t entries = static_cast<std::size_t>(n * n);
    const double nothing = 12345;
    for (const bool inverse : {false, true}) {
      Numbers room(entries + 64, nothing), hybrid(entries);
      const auto out = std::span(room).subspan(32, entries);
      if (inverse) {
        EXPECT_TRUE(inverse_mass_matrix(model, workspace, q, out).ok());
        EXPECT_TRUE(inverse_mass_matrix<Hybrid>(model, workspace, q, hybrid).ok());
      } else {
        mass_matrix(model, workspace, q, out);
        mass_matrix<Hybrid>(model, workspace, q, hybrid);
      }
      Comparison matrix("matrix", 1e-9);
      matrix.expect_equal(Numbers(out.begin(), out.end()), hybrid);
      for (std::size_t k = 0; k < 32; ++k)
        EXPECT_TRUE(room[k] == nothing && room[entries + 32 + k] == nothing) << k << " of " << n;
    }
  }
}

/// The four blocks of the Hessian of inverse dynamics, each of which has memory of exactly its size.
std::array<Numbers, 4> hessian(const Model& model, const State<double>& at, const Numbers& w) {
  Workspace<> workspace(model);
  std::array<Numbers, 4> x;
  for (Numbers& block : x) block.resize(w.size() * w.size());
  inverse_dynamics_hessian(model, workspace, at.q, at.v, at.a, w, {x[0], x[1], x[2], x[3]}, at.loads());
  return x;
}

/// Compilers join products and sums to fused operations differently in the two loops, on processors that have
/// these: Clang always, and GCC 12 for AVX-512. The results then differ by rounding.
bool rounds_alike() {
  const std::string_view set = instruction_set();
#ifdef __clang__
  return set == "x86-64";
#else
  return set != "x86-64-v4";
#endif
}

TEST(FastHessians, AreTheSameToTheLastBitWhereOtherJointsAreCoupled) {
  for_seeds(300, [](std::uint64_t seed) {
    Random<double> random(seed);
    Description tree = random_description(random, {.most_bodies = 12, .couplings = false, .springs = 0});
    const Model alone = ModelBuilder(tree).build();
    for (const char* name : {"leader", "follower"})
      tree.bodies.push_back({.name = name,
                             .predecessor = "ground",
                             .joint = {.kind = JointKind::revolute},
                             .inertia = MassProperties{.mass = 1, .Theta = {.1, .1, .1, 0, 0, 0}}});
    tree.bodies.back().joint.coupling = Coupling{.leader = "leader_joint"};
    const Model coupled = ModelBuilder(tree).build();
    State<double> state = random_state(alone, random);
    Numbers w = random_numbers(random, alone.nv());
    const std::array<Numbers, 4> by_columns = hessian(alone, state, w);
    for (AppliedWrench<>& W : state.wrenches) W.frame = coupled.frame_index(alone.frame(W.frame).name);
    for (Numbers* const x : {&state.q, &state.v, &state.a, &w}) x->push_back(random.number(-1, 1));
    const std::array<Numbers, 4> by_entries = hessian(coupled, state, w);
    const std::size_t nv = w.size() - 1;
    double size = 0;
    for (const Numbers& block : by_columns)
      for (const double x : block) size = std::max(size, std::abs(x));
    const double allowed = rounds_alike() ? 0 : 1e-14 * size;
    for (std::size_t block = 0; block < 4; ++block)
      for (std::size_t r = 0; r < nv; ++r)
        for (std::size_t c = 0; c < nv; ++c)
          EXPECT_NEAR(by_columns[block][r * nv + c], by_entries[block][r * (nv + 1) + c], allowed)
              << "block " << block << ", row " << r << ", column " << c;
  });
}

}  // namespace
}  // namespace axode::test
