#include "apps/study/ways.hpp"

#include "axode/derivatives.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/hinge_chain.hpp"

/// The ways of the study to compute the same give the same, on trees with all kinds of joints, and take as
/// many operations as the paper counts.
namespace axode::test {
namespace {

using command::Way;

class EveryWay : public testing::TestWithParam<Way> {
 protected:
  static std::vector<double> results(const Trial& trial) {
    return command::make_subject(GetParam(), trial.model,
                                 {.q = trial.state.q, .v = trial.state.v, .a = trial.state.a})
        ->results();
  }
};

/// The k-th derivative of the twists of all joint frames, with the ground at rest, 6 numbers for each body.
std::vector<double> twist_derivatives(const Trial& trial, int k, Representation representation) {
  HigherOrderMotion<double> motion(trial.model, 2);
  std::vector<double> rates = trial.state.v;
  for (const auto& row : {trial.state.a, trial.state.v}) rates.insert(rates.end(), row.begin(), row.end());
  motion.evaluate(trial.state.q, rates);
  std::vector<double> out;
  for (int i = 1; i <= trial.model.n_bodies(); ++i)
    with_representation(representation, [&](auto rep) {
      const Place<> joint_frame(i, inverse(trial.model.tree<double>().frame_offset[i]));
      append(out, to_eigen(motion.twist_derivative<decltype(rep)>(joint_frame, k)));
    });
  return out;
}

TEST_P(EveryWay, GivesTheSame) {
  const Way& way = GetParam();
  Comparison same(way.algorithm.data(), way.algorithm == "jerks" ? 1e-9 : 1e-11);
  for_seeds(200, [&](std::uint64_t seed) {
    Trial trial(scalars()[0], seed, {.couplings = false});
    trial.state.wrenches.clear();
    const std::size_t nv = static_cast<std::size_t>(trial.model.nv());
    std::vector<double> expected;
    if (way.algorithm == "inverse_dynamics") {
      expected = trial.inverse_dynamics();
    } else if (way.algorithm == "accelerations") {
      expected = twist_derivatives(trial, 1, way.representation);
    } else if (way.algorithm == "jerks") {
      expected = twist_derivatives(trial, 2, way.representation);
    } else if (way.algorithm == "second_order_inverse_dynamics") {
      InverseDynamicsRates<double> rates(trial.model, 2);
      std::vector<double> motion;
      for (const auto& row : {trial.state.v, trial.state.a, trial.state.v, trial.state.a})
        motion.insert(motion.end(), row.begin(), row.end());
      expected.resize(3 * nv);
      rates.evaluate(trial.state.q, motion, expected);
    } else {
      ASSERT_EQ(way.algorithm, "inverse_dynamics_derivatives");
      Workspace<> workspace(trial.model);
      expected.resize(3 * nv * nv);
      const std::span<double> all(expected);
      inverse_dynamics_derivatives(trial.model, workspace, trial.state.q, trial.state.v, trial.state.a,
                                   {all.first(nv * nv), all.subspan(nv * nv, nv * nv), all.last(nv * nv)});
    }
    same.expect_equal(results(trial), expected);
  });
}
std::string name_of_way(const testing::TestParamInfo<Way>& info) {
  std::string name;
  for (const std::string_view part :
       {info.param.algorithm, info.param.name, word_for(info.param.representation)})
    for (const char letter : part)
      if (std::isalnum(static_cast<unsigned char>(letter)) != 0) name += letter;
  return name;
}
INSTANTIATE_TEST_SUITE_P(Laws, EveryWay, testing::ValuesIn(command::ways()), name_of_way);

/// The operations for a chain of n hinges.
Operations operations_of(std::string_view algorithm, std::string_view name, Representation representation,
                         int n) {
  const Model model = chain(n);
  const std::vector<double> q(static_cast<std::size_t>(n), 0.3);
  return command::operations({algorithm, name, representation}, model, {.q = q, .v = q, .a = q});
}

/// Sections 4.2 and 4.3 of the paper count n transformations of screws and n of inertias in spatial twists,
/// and n rotations of screws and n of inertias with 3 n - 3 translations in hybrid ones. The ground is a
/// body here.
TEST(ScrewsOnce, TakeThePapersTransformations) {
  using Screws = std::array<long, n_screw_operations>;
  for (const int n : {1, 7, 36}) {
    const auto screws = [&](Representation in) {
      return operations_of("inverse_dynamics", "once", in, n).screws;
    };
    EXPECT_EQ(screws(Representation::spatial), (Screws{n, 0, 0, n, 0, 0, 2 * n}));
    EXPECT_EQ(screws(Representation::hybrid), (Screws{0, n, 3 * n, 0, n, 0, 3 * n}));
  }
}

TEST(AccelerationForms, TakeFewestOperationsInTheFirstHybridForm) {
  const auto total = [](std::string_view name) {
    return operations_of("accelerations", name, Representation::hybrid, 7).total();
  };
  EXPECT_LT(total("recVhdot1"), total("recVhdot3"));
  EXPECT_LT(total("recVhdot3"), total("recVhdot2"));
}

TEST(AccelerationForms, AreEquallyCheapInBodyFixedTwistsUnlessScrewsAreSparse) {
  const auto total = [](std::string_view name) {
    return operations_of("accelerations", name, Representation::body, 7).total();
  };
  EXPECT_EQ(total("arecVbi"), total("brecVbi"));
  EXPECT_EQ(total("arecVbi"), total("crecVbi"));
  EXPECT_LT(total("arecVbi, sparse"), total("arecVbi"));
}

}  // namespace
}  // namespace axode::test
