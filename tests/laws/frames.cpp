#include <Eigen/Eigenvalues>

#include "axode/dynamics/momentum_recursion.hpp"
#include "axode/model/framed_tree.hpp"
#include "tests/laws/law.hpp"

/// Drive forces, accelerations of the joints and mass matrices do not depend on the frames of the bodies: in the user's,
/// at the centres of mass and all in the construction frame they are what they are in the joint frames.
namespace axode::test {
namespace {

template <class Rep_, class Frames_> struct Choice {
  using Rep = Rep_;
  using Frames = Frames_;
};
using Choices = testing::Types<
    Choice<BodyFixed, UserFrames>, Choice<BodyFixed, MassCenterFrames>, Choice<BodyFixed, ConstructionFrames>,
    Choice<Spatial, UserFrames>, Choice<Spatial, MassCenterFrames>, Choice<Spatial, ConstructionFrames>,
    Choice<Hybrid, UserFrames>, Choice<Hybrid, MassCenterFrames>, Choice<Hybrid, ConstructionFrames>,
    Choice<Mixed, UserFrames>, Choice<Mixed, MassCenterFrames>, Choice<Mixed, ConstructionFrames>>;

template <class Choice> class ChoiceOfFrames : public testing::Test {};
TYPED_TEST_SUITE(ChoiceOfFrames, Choices);

TYPED_TEST(ChoiceOfFrames, DoesNotChangeTheForces) {
  using Rep = typename TypeParam::Rep;
  Comparison force("force", agreement<double>);
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed)};
    const FramedTree<double, typename TypeParam::Frames> tree(trial.model.tree<double>());
    Workspace<>::Arena arena(trial.workspace);
    InverseDynamicsRecursion<Rep, double> recursion{arena};
    const auto& [q, v, a, wrenches] = trial.state;
    recursion.run(tree, q.data(), v.data(), a.data(), trial.state.loads());
    std::vector<double> tau = trial.zero();
    recursion.project(tree, v.data(), a.data(), false, tau.data());
    force.expect_equal(tau, trial.inverse_dynamics<Hybrid>());
  });
}

TYPED_TEST(ChoiceOfFrames, DoesNotChangeTheMassMatrix) {
  using Rep = typename TypeParam::Rep;
  Comparison inertia("mass matrix", agreement<double>);
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed)};
    const FramedTree<double, typename TypeParam::Frames> tree(trial.model.tree<double>());
    const std::size_t nv = trial.zero().size();
    std::vector<double> M(nv * nv), reference(nv * nv);
    Workspace<>::Arena arena(trial.workspace);
    CompositeBodies<Rep, double> bodies{arena, body_links<Rep>(tree, arena, trial.state.q.data())};
    bodies.run(tree, tree.armature.data(), M.data());
    mass_matrix<Hybrid>(trial.model, trial.workspace, trial.state.q, reference);
    inertia.expect_equal(M, reference);
  });
}

/// The smallest eigenvalue of the mass matrix scaled to a unit diagonal.
double definiteness(Trial<double>& trial) {
  const int nv = trial.model.nv();
  Eigen::MatrixXd M(nv, nv);
  mass_matrix<Hybrid>(trial.model, trial.workspace, trial.state.q,
                      std::span(M.data(), static_cast<std::size_t>(M.size())));
  if (nv == 0) return 1;
  if (M.diagonal().minCoeff() <= 0) return 0;
  const Eigen::VectorXd scale = M.diagonal().cwiseSqrt().cwiseInverse();
  M = (scale.asDiagonal() * M * scale.asDiagonal()).eval();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

TYPED_TEST(ChoiceOfFrames, DoesNotChangeTheAccelerations) {
  using Rep = typename TypeParam::Rep;
  Comparison force("force", agreement<double>);
  int solved = 0, singular = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed)};
    const FramedTree<double, typename TypeParam::Frames> tree(trial.model.tree<double>());
    const auto& [q, v, a, wrenches] = trial.state;
    const std::vector<double> tau = trial.inverse_dynamics<Hybrid>();
    std::vector<double> found = trial.zero();
    const Solvability solvability =
        solve_forward_dynamics<Rep>(tree, Workspace<>::Arena(trial.workspace), q.data(), v.data(), tau.data(),
                                    trial.state.loads(), found.data());
    // Where M is singular to rounding, rounding decides, which differs from frame to frame.
    if (definiteness(trial) <= agreement<double> / 10) {
      ++singular;
    } else {
      ++solved;
      EXPECT_TRUE(solvability.ok());
      force.expect_equal(trial.inverse_dynamics<Hybrid>(v, found, trial.state.loads()), tau);
    }
  });
  EXPECT_GE(solved, (solved + singular) / 10);
  EXPECT_GE(singular, (solved + singular) / 10);
}

template <class Frames> class MomentaInFrames : public testing::Test {};
using OtherFrames = testing::Types<UserFrames, MassCenterFrames, ConstructionFrames>;
TYPED_TEST_SUITE(MomentaInFrames, OtherFrames);

TYPED_TEST(MomentaInFrames, GiveTheSameVelocitiesAndRates) {
  Comparison momentum("M v", agreement<double>), rate("p'", agreement<double>);
  int compared = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed)};
    if (definiteness(trial) < 1e-2) return;  // the rates follow from the velocities, which M has to tell
    ++compared;
    const FramedTree<double, TypeParam> tree(trial.model.tree<double>());
    const std::vector<double>&q = trial.state.q, tau = trial.inverse_dynamics<Spatial>();
    std::vector<double> p = trial.zero(), v = p, dp = p, v_reference = p, dp_reference = p, again = p;
    generalized_momenta(trial.model, trial.workspace, q, trial.state.v, p);
    ASSERT_TRUE(
        momentum_form(trial.model, trial.workspace, q, p, tau, v_reference, dp_reference, trial.state.loads())
            .ok());
    ASSERT_TRUE(solve_momentum_form(tree, trial.workspace, q.data(), p.data(), tau.data(),
                                    trial.state.loads(), v.data(), dp.data())
                    .ok());
    generalized_momenta(trial.model, trial.workspace, q, v, again);
    momentum.expect_equal(again, p);
    rate.expect_equal(dp, dp_reference, largest(entries(tau)));
  });
  EXPECT_GE(compared, 10);
}

/// f(i, c, k) for every joint screw c, the k-th of joint i.
template <class F> void each_screw(const Model& model, const F& f) {
  for (int i = 1; i <= model.n_bodies(); ++i)
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) f(i, model.first_screw(i) + k, k);
}

TEST(Frames, OfTheUserHaveTheScrewsOfTheModel) {
  Comparison screw("X", agreement<double>), pose("B", agreement<double>);
  for_seeds(500, [&](std::uint64_t seed) {
    const Trial<double> trial{Random<double>(seed)};
    const FramedTree<double, UserFrames> tree(trial.model.tree<double>());
    each_screw(trial.model, [&](int i, int c, int k) {
      pose.expect_equal(tree.B[i], trial.model.body(i).B);
      screw.expect_equal(tree.X[c], trial.model.body(i).X[k]);
    });
  });
}

TEST(Frames, InTheConstructionFrameHaveSpatialScrewsAndNothingBetweenBodies) {
  Comparison screw("Y", agreement<double>), pose("B", agreement<double>);
  for_seeds(500, [&](std::uint64_t seed) {
    const Trial<double> trial{Random<double>(seed)};
    const FramedTree<double, ConstructionFrames> tree(trial.model.tree<double>());
    each_screw(trial.model, [&](int i, int c, int k) {
      pose.expect_equal(tree.B[i], SE3<>{});
      screw.expect_equal(tree.X[c], Ad(trial.model.body(i).A, trial.model.body(i).X[k]));
    });
  });
}

}  // namespace
}  // namespace axode::test
