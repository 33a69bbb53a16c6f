#include "apps/study/study.hpp"
#include "tests/laws/law.hpp"

/// Drive forces, joint accelerations and mass matrices do not depend on the body frames. The recursions give
/// the same results in the frames of the user, in frames at the centres of mass and with all frames at the
/// construction frame as in the joint frames.
namespace axode::test {
namespace {

using command::Algorithm;
using Numbers = std::vector<double>;

/// A recursion with a choice of body frames, as `axode study` runs it.
struct Choice {
  std::string name;
  std::unique_ptr<command::Subject> (*subject)(const Model&, const command::State&);
};
template <class Frames> void add(std::vector<Choice>& choices, const char* frames) {
  for (const Representation representation : representations)
    with_representation(representation, [&](auto rep) {
      choices.push_back({name(representation) + "_" + frames, command::make_subject<decltype(rep), Frames>});
    });
}
const std::vector<Choice>& choices() {
  static const std::vector<Choice> all = [] {
    std::vector<Choice> made;
    add<UserFrames>(made, "user");
    add<MassCenterFrames>(made, "mass_center");
    add<ConstructionFrames>(made, "construction");
    return made;
  }();
  return all;
}
std::ostream& operator<<(std::ostream& out, const Choice& choice) { return out << choice.name; }
std::string name_of_choice(const testing::TestParamInfo<Choice>& info) { return info.param.name; }

const Case how = scalars()[0];

class ChoiceOfFrames : public testing::TestWithParam<Choice> {
 protected:
  /// The results of an algorithm at the state of a trial. Algorithms that take forces get them in `a_or_tau`.
  Numbers results_of(Algorithm algorithm, const Trial& t, const Numbers& a_or_tau) const {
    const command::State state{.q = t.state.q, .v = t.state.v, .a = a_or_tau, .loads = t.state.wrenches};
    return GetParam().subject(t.model, state)->results_of(algorithm);
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, ChoiceOfFrames, testing::ValuesIn(choices()), name_of_choice);

TEST_P(ChoiceOfFrames, DoesNotChangeTheForces) {
  Comparison force("force", how.agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(how, seed);
    force.expect_equal(results_of(Algorithm::inverse_dynamics, trial, trial.state.a),
                       trial.inverse_dynamics());
  });
}

TEST_P(ChoiceOfFrames, DoesNotChangeTheMassMatrix) {
  Comparison inertia("mass matrix", how.agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(how, seed);
    inertia.expect_equal(results_of(Algorithm::mass_matrix, trial, trial.state.a), trial.call("mass_matrix"));
  });
}

TEST_P(ChoiceOfFrames, DoesNotChangeTheAccelerations) {
  Comparison force("force", how.agreement());
  int solved = 0, singular = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(how, seed);
    // If M is singular to rounding, it depends on rounding, and so on the choice of frames, whether it is
    // found to be singular.
    if (definiteness(trial.mass_matrix()) <= how.agreement() / 10) {
      ++singular;
      return;
    }
    ++solved;
    const Numbers tau = trial.inverse_dynamics(), a = results_of(Algorithm::forward_dynamics, trial, tau);
    EXPECT_FALSE(std::isnan(largest(a))) << "taken for singular";
    force.expect_equal(trial.inverse_dynamics(trial.state.v, a, trial.state.loads()), tau);
  });
  EXPECT_GE(solved, (solved + singular) / 10);
  EXPECT_GE(singular, (solved + singular) / 10);
}

class MomentaInFrames : public testing::TestWithParam<Choice> {};
INSTANTIATE_TEST_SUITE_P(Laws, MomentaInFrames, testing::Values(choices()[1], choices()[5], choices()[9]),
                         name_of_choice);

TEST_P(MomentaInFrames, GiveTheSameVelocitiesAndRates) {
  Comparison momentum("M v", how.agreement()), rate("p'", how.agreement());
  int compared = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(how, seed);
    if (definiteness(trial.mass_matrix()) < 1e-2)
      return;  // M must be well conditioned, because the rates are computed from the velocities
    ++compared;
    const auto momenta = [&](const Numbers& v) {
      return trial.call("momenta", {.q = trial.state.q, .v = v});
    };
    Ask ask = trial.ask();
    ask.tau = trial.inverse_dynamics(), ask.p = momenta(trial.state.v);
    const auto [reference, solvability] = trial.answer("momentum_form", ask);
    ASSERT_TRUE(solvability.ok());
    const command::State state{.q = ask.q, .v = ask.p, .a = ask.tau, .loads = trial.state.wrenches};
    const Numbers found = GetParam().subject(trial.model, state)->results_of(Algorithm::momentum_form);
    const std::ptrdiff_t nv = trial.model.nv();
    const auto rates = [&](const Numbers& both) { return Numbers(both.begin() + nv, both.end()); };
    momentum.expect_equal(momenta({found.begin(), found.begin() + nv}), ask.p);
    rate.expect_equal(rates(found), rates(reference), largest(ask.tau));
  });
  EXPECT_GE(compared, 10);
}

/// Calls f(i, c, k) for every joint screw; screw c is the k-th screw of joint i.
template <class F> void each_screw(const Model& model, const F& f) {
  for (int i = 1; i <= model.n_bodies(); ++i)
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) f(i, model.first_screw(i) + k, k);
}

TEST(Frames, OfTheUserHaveTheScrewsOfTheModel) {
  Comparison screw("X", how.agreement()), pose("B", how.agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    const Trial trial(how, seed);
    const FramedTree<double, UserFrames> tree(trial.model.tree<double>());
    each_screw(trial.model, [&](int i, int c, int k) {
      pose.expect_equal(tree.B[i], trial.model.body(i).B);
      screw.expect_equal(tree.X[c], trial.model.body(i).X[k]);
    });
  });
}

TEST(Frames, InTheConstructionFrameHaveSpatialScrewsAndNothingBetweenBodies) {
  Comparison screw("Y", how.agreement()), pose("B", how.agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    const Trial trial(how, seed);
    const FramedTree<double, ConstructionFrames> tree(trial.model.tree<double>());
    each_screw(trial.model, [&](int i, int c, int k) {
      pose.expect_equal(tree.B[i], SE3<>{});
      screw.expect_equal(tree.X[c], Ad(trial.model.body(i).A, trial.model.body(i).X[k]));
    });
  });
}

}  // namespace
}  // namespace axode::test
