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
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial hybrid(GetParam(), Random<double>(seed)), fastest = hybrid.by(fast(GetParam()));
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
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial hybrid(GetParam(), Random<double>(seed)), fastest = hybrid.by(fast(GetParam()));
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

}  // namespace
}  // namespace axode::test
