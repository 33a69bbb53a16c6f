#include "apps/study/contraction/tree_contraction.hpp"

#include "apps/study/contraction/contraction_counts.hpp"
#include "apps/study/study.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/hinge_chain.hpp"

/// Forward dynamics by contraction of the tree gives the accelerations of the articulated-body algorithm,
/// whatever is compressed, in a number of rounds that grows with log n.
namespace axode::test {
namespace {

using command::ContractionPlan;

/// The accelerations by a plan; empty if a segment may be singular.
std::vector<double> contracted(const Model& model, const ContractionPlan& plan, const State<double>& state,
                               const std::vector<double>& tau) {
  const Tree<double>& tree = model.tree<double>();
  command::TreeContraction<double> contraction(tree, plan);
  std::vector<double> a(state.v.size());
  if (!contraction.run(tree, state.q.data(), state.v.data(), tau.data(), a.data())) a.clear();
  return a;
}

TEST(TreeContraction, GivesTheAccelerationsOfForwardDynamicsWithAllKindsOfJoints) {
  const Case how = scalars()[0];
  // A segment is less accurate than the elimination from the leaves, if its joints move free bodies.
  Comparison eliminated("force, nothing compressed", how.agreement()), compressed("force, compressed", 1e-6);
  int trees = 0, compressions = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.couplings = false});
    trial.state.wrenches.clear();
    const std::vector<double> tau = trial.inverse_dynamics();
    if (definiteness(trial.mass_matrix()) <= how.agreement() / 10) return;
    ++trees;
    for (const int rounds : {0, 1, 2, 100}) {
      const ContractionPlan plan(trial.model.tree<double>(), rounds);
      const std::vector<double> a = contracted(trial.model, plan, trial.state, tau);
      ASSERT_FALSE(a.empty()) << "taken for singular";
      compressions += plan.compressions;
      (plan.compressions == 0 ? eliminated : compressed)
          .expect_equal(trial.inverse_dynamics(trial.state.v, a, trial.state.loads()), tau);
    }
  });
  EXPECT_GE(trees, 200);
  EXPECT_GE(compressions, 1000);
}

TEST(TreeContraction, IsAccurateForLongChains) {
  for (const int n : {7, 36, 100}) {
    const Model model = chain(n);
    Random<double> random(2);
    const State<double> state = random_state(model, random);
    const Case how = scalars()[0];
    Trial trial(how, model, {state.q, state.v, state.a});
    const std::vector<double> tau = trial.inverse_dynamics();
    Comparison("force", 1e-8)
        .expect_equal(trial.inverse_dynamics(
                          state.v, contracted(model, ContractionPlan(model.tree<double>()), state, tau), {}),
                      tau);
  }
}

TEST(TreeContraction, TakesRoundsThatGrowWithTheLogarithm) {
  for (const int n : {1, 2, 7, 36, 100, 256, 1000}) {
    const ContractionPlan plan(chain(n).tree<double>());
    EXPECT_LE(plan.rounds, 2 + std::log2(n)) << n;
    EXPECT_EQ(std::ssize(plan.steps), n);
  }
}

command::State state_of(const Model& model) {
  const std::vector<double> q(static_cast<std::size_t>(model.nq()), 0.3),
      v(static_cast<std::size_t>(model.nv()), 0.2);
  return {.q = q, .v = v, .a = v};
}

TEST(TreeContraction, WithoutCompressionsIsTheArticulatedBodyAlgorithm) {
  for (const int n : {7, 36}) {
    const Model model = chain(n);
    const long serial = command::operations<Spatial, command::JointFrames>(
                            command::Algorithm::forward_dynamics, model, state_of(model))
                            .total();
    const command::ContractionCount count = command::contraction_counts(model, state_of(model)).front();
    EXPECT_EQ(count.compressions, 0);
    EXPECT_LT(count.operations.total(), serial);  // which adds to the ground as well
    EXPECT_GT(20 * count.operations.total(), 18 * serial);
  }
}

TEST(TreeContraction, ShortensThePathOfLongChainsAndNotOfShortOnes) {
  const auto path = [](int n) {
    const auto counts = command::contraction_counts(chain(n), state_of(chain(n)));
    EXPECT_GE(counts.size(), 2U);
    EXPECT_GT(counts.back().operations.total(), 2 * counts.front().operations.total());
    return std::pair{counts.front().longest_path, counts.back().longest_path};
  };
  EXPECT_LT(path(7).first, path(7).second);
  EXPECT_GT(path(256).first, 2 * path(256).second);
}

TEST(TreeContraction, FindsASingularMassMatrix) {
  ModelBuilder builder("weightless");
  builder.add({.name = "pointer", .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}}});
  const Model model = builder.build();
  EXPECT_TRUE(command::contraction_counts(model, state_of(model)).empty());
}

}  // namespace
}  // namespace axode::test
