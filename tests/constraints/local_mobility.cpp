#include "axode/constraints/local_mobility/local_mobility.hpp"

#include <cmath>

#include "axode/constraints/local_mobility/walks.hpp"
#include "axode/constraints/loops.hpp"
#include "axode/constraints/mobility.hpp"
#include "axode/model/configuration.hpp"
#include "tests/constraints/known_mobility.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/random_loops.hpp"

/// Mobility of higher order: derivatives of closures, and mechanisms whose motions are known.
namespace axode::test {
namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

LocalMobility found_at_zero(const Drawing& drawing, const LocalMobilityOptions& options = {}) {
  const Model model = drawing.model();
  return local_mobility(model, neutral(model), options);
}

struct Known {
  std::string name;
  Drawing drawing;
  int rank;
  std::vector<int> orders;
  std::vector<int> dimensions;  ///< of the branches, ascending
  std::vector<std::string> words;
};

std::vector<Known> known() {
  using Words = std::vector<std::string>;
  const Words at_branch{"branch point", "kinematic singularity"};
  const auto rigid = [](int order) { return Words{"shaky", "rigid at order " + std::to_string(order)}; };
  return {
      {"Toggle", planar({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), 2, {1, 0, 0}, {}, rigid(2)},
      {"Parallelogram",
       planar({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}}),
       2,
       {2, 1, 1},
       {1, 1},
       at_branch},
      {"BricardsCube", cube(), 5, {1, 1, 1}, {1}, {"regular"}},
      {"FoldedBricard", folded_bricard(), 4, {2, 1, 1}, {1, 1}, at_branch},
      {"Sarrus", sarrus(), 5, {1, 1, 1}, {1}, {"regular"}},
      {"TwoFourBars",
       four_bars(2),
       4,
       {3, 1, 1},
       {1, 1, 1},
       {"branch point", "kinematic singularity", "shaky", "idle drive of bar 1_joint",
        "idle drive of coupler 1_joint", "idle drive of coupler 2_joint", "idle drive of left bar_joint"}},
      {"SlantedWattSlider", watt_slider({.5, .5, 1, 1, .4}), 5, {1, 1, 0, 0}, {}, rigid(3)},
      {"UnequalWattSlider", watt_slider({.25, .5, 1, .5}), 5, {1, 1, 1, 0}, {}, rigid(4)},
      {"EqualWattSlider", watt_slider({.5, .5, 1, 1}), 5, {1, 1, 1, 1, 0}, {}, rigid(5)},
      {"DoubleWattCusp",
       double_watt(2, {.5, .5, 1, 1, .4}),
       8,
       {2, 1, 0, 0},
       {1},
       {"cusp", "kinematic singularity", "dead point of bar_joint"}},
      {"DoubleWattTangent",
       double_watt(1, {.25, .5, 1, .5}),
       8,
       {2, 1, 1, 1, 1},
       {1, 1},
       {"branch point", "kinematic singularity", "dead point of bar_joint"}},
      {"DoubleWattIsolated", double_watt(1, {.5, .25, .5, 1}), 8, {2, 1, 1, 0}, {}, rigid(4)},
      {"KiteWithCrosses",
       kite_with_crosses(),
       3,
       {3, 2, 2},
       {1, 2},
       {"branch point", "kinematotropic", "kinematic singularity", "idle drive of link 1_joint",
        "idle drive of link 3_joint", "idle drive of link 4_joint", "idle drive of link 5_joint"}},
      {"Wunderlich",
       wunderlich(),
       13,
       {3, 2, 2, 2},
       {1, 2},
       {"branch point", "kinematotropic", "kinematic singularity"}},
      {"InclinedUpu", three_upu(.6, false), 12, {3, 3}, {3}, {"regular"}},
      {"UprightUpu", three_upu(1, false), 10, {5, 3, 3}, {3, 3}, at_branch},
      {"LockedUpu", three_upu(1, true), 10, {2, 2}, {2}, {"regular"}},
      {"RadialLockedUpu", three_upu(.6, true, true), 10, {2, 0}, {}, rigid(2)}};
}

class MobilityOfKnownMechanisms : public testing::TestWithParam<Known> {};
INSTANTIATE_TEST_SUITE_P(Mechanisms, MobilityOfKnownMechanisms, testing::ValuesIn(known()),
                         [](const auto& info) { return info.param.name; });

TEST_P(MobilityOfKnownMechanisms, OrdersBranchesAndWords) {
  const Known& expected = GetParam();
  const Model model = expected.drawing.model();
  const LocalMobility found = local_mobility(model, neutral(model));
  EXPECT_EQ(found.rank, expected.rank);
  ASSERT_GE(found.mobility_by_order.size(), expected.orders.size());
  for (std::size_t k = 0; k < found.mobility_by_order.size(); ++k)
    EXPECT_EQ(found.mobility_by_order[k], expected.orders[std::min(k, expected.orders.size() - 1)]);
  std::vector<int> dimensions;
  for (const MotionBranch& branch : found.branches) dimensions.push_back(branch.dimension);
  std::ranges::sort(dimensions);
  EXPECT_EQ(dimensions, expected.dimensions);
  EXPECT_EQ(mobility_words(model, found), expected.words);
  EXPECT_EQ(found.probe.missed, 0);
}

/// The points of every branch close the loops of the model, and its series satisfies the constraints of every
/// order: a curve of the branch has H^(k) = 0.
TEST_P(MobilityOfKnownMechanisms, BranchesSatisfyTheConstraints) {
  const Model model = GetParam().drawing.model();
  const std::vector<double> q = neutral(model);
  const LocalMobility found = local_mobility(model, q);
  LoopWorkspace<> workspace(model);
  std::vector<double> r(static_cast<std::size_t>(model.loops().residuals));
  for (const MotionBranch& branch : found.branches) {
    EXPECT_FALSE(branch.points.empty());
    for (const BranchPoint& point : branch.points) {
      loop_residual<double>(model, workspace, point.q, r);
      EXPECT_LT(largest(r), 1e-13);
    }
    if (branch.dimension > 1) continue;
    Eigen::MatrixXd derivatives = branch.series.rightCols(branch.series.cols() - 1);
    double factorial = 1;
    for (Eigen::Index k = 0; k < derivatives.cols(); ++k) derivatives.col(k) *= factorial *= double(k + 1);
    for (const Eigen::MatrixXd& H : closure_derivatives(model, q, derivatives)) {
      double size = 1;
      for (Eigen::Index k = 0; k < H.cols(); ++k) {
        size = std::max(size, derivatives.leftCols(k + 1).cwiseAbs().maxCoeff());
        EXPECT_LT(H.col(k).cwiseAbs().maxCoeff(), 1e-9 * std::pow(size, 2)) << "order " << k + 1;
      }
    }
  }
}

/// Lengths that are a thousand times as large change nothing, and neither do other names.
TEST_P(MobilityOfKnownMechanisms, DoesNotDependOnTheUnitOfLengthOrOnNames) {
  Drawing large = GetParam().drawing;
  const double scale = 1000;
  for (BodyDescription& body : large.description.bodies) {
    body.joint.point = scale * body.joint.point;
    body.inertia->com = scale * body.inertia->com;
  }
  for (LoopDescription& loop : large.description.loops) loop.point = scale * loop.point;
  for (std::size_t k = 0; k < large.description.bodies.size(); ++k) {
    const std::string old = large.description.bodies[k].name, name = "body " + std::to_string(k);
    for (BodyDescription& body : large.description.bodies) {
      if (body.name == old) body.name = name;
      if (body.predecessor == old) body.predecessor = name;
    }
    for (LoopDescription& loop : large.description.loops)
      for (std::string& end : loop.between)
        if (end == old) end = name;
  }
  const LocalMobility one = found_at_zero(GetParam().drawing), other = found_at_zero(large);
  EXPECT_NEAR(other.length, scale * one.length, 1e-9 * scale);
  EXPECT_EQ(other.mobility_by_order, one.mobility_by_order);
  ASSERT_EQ(other.branches.size(), one.branches.size());
  for (std::size_t k = 0; k < one.branches.size(); ++k) {
    Eigen::VectorXd unit(static_cast<Eigen::Index>(one.coordinates.size()));
    for (std::size_t c = 0; c < one.coordinates.size(); ++c)
      unit[static_cast<Eigen::Index>(c)] = one.coordinates[c].angular ? 1 : scale;
    EXPECT_EQ(other.branches[k].dimension, one.branches[k].dimension);
    const Eigen::MatrixXd T = one.branches[k].T * unit.asDiagonal(), &T_other = other.branches[k].T;
    EXPECT_LT((T - T_other).norm(), 1e-8 * T.norm());
  }
}

/// What does not depend on where a loop is cut.
void expect_same(const LocalMobility& one, const LocalMobility& other) {
  EXPECT_EQ(other.rank, one.rank);
  EXPECT_NEAR(other.length, one.length, 1e-12);
  EXPECT_NEAR(other.smallest_kept, one.smallest_kept, 1e-11);
  EXPECT_EQ(other.mobility_by_order, one.mobility_by_order);
  EXPECT_EQ(other.conditions.size(), one.conditions.size());
  const auto curvatures = [](const LocalMobility& found) {
    std::vector<double> out;
    for (const MotionBranch& branch : found.branches)
      out.push_back(branch.II.norm() + 100 * branch.dimension);
    std::ranges::sort(out);
    return out;
  };
  const std::vector<double> a = curvatures(one), b = curvatures(other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-8);
}

TEST(LocalMobility, IsTheSameWhereverALoopIsCut) {
  const Vec3<> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, a{1, 2, 2}, b{-2, 1, 3};
  const std::vector<std::vector<Pair>> rings{{pin({0, 0, 0}), pin({1, 0, 0}), pin({3, 0, 0}), pin({2, 0, 0})},
                                             {pin({0, 0, 0}, z),
                                              {JointKind::spherical, z, {0, 1, 0}},
                                              {JointKind::spherical, z, {2, 2, 1}},
                                              pin({2, 0, 0}, y)},
                                             {pin({0, 0, 0}, a),
                                              {JointKind::universal, x, {0, 1, 0}, z},
                                              {JointKind::cylindrical, b, {1, 2, 1}},
                                              {JointKind::helical, a, {2, 0, 1}},
                                              pin({2, 0, 0}, b)},
                                             {{JointKind::planar, a, {0, 0, 0}},
                                              {JointKind::prismatic, x, {0, 1, 0}},
                                              {JointKind::spherical, z, {1, 2, 1}}}};
  for (const std::vector<Pair>& pairs : rings) {
    const LocalMobility whole = found_at_zero(ring_of(pairs));
    EXPECT_TRUE(whole.settled);
    for (std::size_t cut = 0; cut + 1 < pairs.size(); ++cut) {
      SCOPED_TRACE("cut at " + std::to_string(cut) + " of " + std::to_string(pairs.size()));
      expect_same(whole, found_at_zero(ring_of(pairs, cut)));
    }
  }
}

TEST(LocalMobility, HasTheCurvatureOfBricardsCube) {
  const LocalMobility found = found_at_zero(cube(), {.length = 1});
  ASSERT_EQ(found.branches.size(), 1U);
  const Eigen::MatrixXd sixth = Eigen::MatrixXd::Constant(1, 6, 1.0 / 6);
  EXPECT_LT((found.branches[0].II - sixth).norm(), 1e-13);
  for (Eigen::Index c = 0; c < 6; ++c)
    EXPECT_NEAR(std::abs(found.branches[0].T(0, c)), 1 / std::sqrt(6.0), 1e-14);
}

/// Near the cusp, the heights of the two Watt points satisfy (y_b - y_a)² = 4 L c y_a³ with c = k / (4 h a²).
TEST(LocalMobility, FindsTheCuspOfConnellyAndServatius) {
  const double L = 2, h = 0.5, a = 1, k = 0.4, c = k / (4 * h * a * a);
  const LocalMobility found = found_at_zero(double_watt(L, {h, h, a, a, k}), {.length = 1});
  ASSERT_EQ(found.branches.size(), 1U);
  const MotionBranch& branch = found.branches[0];
  EXPECT_EQ(branch.power, 2);
  // To lowest order, the height of each point is a times the angle of its crank, towards its coupler.
  const Eigen::VectorXd first = branch.series.col(2), second = branch.series.col(3);
  const double y = a * first[0], difference = a * (-second[4] - second[0]);
  EXPECT_NEAR(first[4], -first[0], 1e-12);
  EXPECT_NEAR(difference * difference, 4 * L * c * y * y * y, 1e-10);
}

TEST(LocalMobility, SaysWhichLoopsMove) {
  const LocalMobility found = found_at_zero(four_bars(2));
  std::vector<std::vector<int>> loops;
  for (const MotionBranch& branch : found.branches) loops.push_back(branch.loops);
  std::ranges::sort(loops);
  EXPECT_EQ(loops, (std::vector<std::vector<int>>{{0, 1}, {0, 1}, {1}}));
  ASSERT_EQ(found.conditions.size(), 2U);
  EXPECT_EQ(found.conditions[0].degree, 2);
}

TEST(LocalMobility, CountsCouplingsAndLeavesOutOtherJoints) {
  Drawing drawing;
  drawing.body("a", "ground", pin({0, 0, 0}))
      .body("b", "ground", pin({1, 0, 0}))
      .body("c", "b", pin({2, 0, 0}));
  drawing.description.couplings.push_back({.terms = {{"a_joint", 1}, {"b_joint", -2}}});
  const LocalMobility found = found_at_zero(drawing);
  EXPECT_EQ(found.rank, 1);
  EXPECT_EQ(found.local_mobility, 1);
  EXPECT_EQ(found.outside, std::vector<int>{2});
  EXPECT_TRUE(found.decided_by_rank);
  ASSERT_EQ(found.branches.size(), 1U);
  EXPECT_NEAR(found.branches[0].T(0, 0), 2 / std::sqrt(5.0), 1e-14);
}

/// The axes of a spherical mechanism meet in a point, whose coordinates are known but for rounding errors.
/// The distances of these points are no lengths of the mechanism.
TEST(LocalMobility, TakesPointsThatDifferByRoundingForOne) {
  for (const Vec3<>& center : {Vec3<>{}, Vec3<>{0.1, -0.2, 0.3}, Vec3<>{1e3, 0, 0}}) {
    const double rounding = 2e-16 * (0.1 + norm(center));
    const auto meet = [&](const Vec3<>& axis, const Vec3<>& off) {
      return pin(center + rounding * off, axis);
    };
    const LocalMobility found =
        found_at_zero(ring_of({meet({0, 0, 1}, {1, 0, 0}), meet({0, 0.2, 1}, {0, 1, 0}),
                               meet({0.7, 0.4, 1}, {0, 0, 1}), meet({0.8, -0.1, 1}, {-1, 0, 0})}));
    EXPECT_EQ(found.length, 1);
    EXPECT_EQ(found.rank, 3);
    EXPECT_EQ(found.local_mobility, 1);
  }
}

TEST(LocalMobility, SaysThatTooFewOrdersDoNotSettle) {
  const Model model = watt_slider({.5, .5, 1, 1}).model();
  const LocalMobility found = local_mobility(model, neutral(model), {.order = 4});
  EXPECT_FALSE(found.settled);
  EXPECT_EQ(mobility_words(model, found).back(), "not settled up to order 4");
}

/// A millimetre beside a branch point, series converge within about a millimetre only.
TEST(LocalMobility, IsRegularNearASingularity) {
  const Model model = planar({{0, 0, 0}, {1, 0, 0}, {3, 1e-3, 0}, {2, 0, 0}}).model();
  const LocalMobility found = local_mobility(model, neutral(model));
  EXPECT_EQ(mobility_words(model, found).front(), "regular");
  ASSERT_EQ(found.branches.size(), 1U);
  EXPECT_TRUE(found.branches[0].closes);
  EXPECT_EQ(found.probe.missed, 0);
  EXPECT_GT(found.branches[0].II.norm(), 100);
}

/// The default order falls with the number of free velocities, so that many independent loops are answered.
TEST(LocalMobility, TakesMechanismsWithManyLoops) {
  Drawing drawing;
  constexpr int loops = 12;
  for (int k = 0; k < loops; ++k) {
    const std::string name = "m" + std::to_string(k);
    const double y = 10.0 * k;
    drawing.body(name + "a", "ground", pin({0, y, 0}))
        .body(name + "b", name + "a", pin({0, y + 1, 0}))
        .body(name + "c", "ground", pin({2, y, 0}));
    drawing.description.loops.push_back(
        {.between = {name + "b", name + "c"}, .axis = {0, 0, 1}, .point = {2, y + 1.5, 0}});
  }
  const Model model = drawing.model();
  const LocalMobility found = local_mobility(model, neutral(model));
  EXPECT_EQ(found.local_mobility, loops);
  EXPECT_EQ(mobility_words(model, found), std::vector<std::string>{"regular"});
}

TEST(LocalMobility, EndsWhereItsMonitorWantsIt) {
  const Model model = four_bars(3).model();
  int asked = 0;
  const LocalMobility found = local_mobility(model, neutral(model), {.monitor = [&] { return ++asked < 3; }});
  EXPECT_EQ(asked, 3);
  EXPECT_TRUE(found.coordinates.empty());
  EXPECT_FALSE(found.settled);
}

TEST(LocalMobility, RefusesWhatItCannotAnswer) {
  const Model model = four_bars(1).model();
  std::vector<double> q = neutral(model);
  for (const int order : {-1, 1, 21})
    EXPECT_THROW(static_cast<void>(local_mobility(model, q, {.order = order})), std::invalid_argument);
  for (const double length : {-1.0, std::nan(""), 1e-300, 1e300})
    EXPECT_THROW(static_cast<void>(local_mobility(model, q, {.length = length})), std::invalid_argument);
  EXPECT_THROW(closure_derivatives(model, q, Eigen::MatrixXd::Zero(3, 2)), std::invalid_argument);
  EXPECT_THROW(closure_derivatives(model, q, Eigen::MatrixXd::Zero(4, 0)), std::invalid_argument);
  q[0] = 0.1;
  EXPECT_THROW(static_cast<void>(local_mobility(model, q)), std::invalid_argument) << "the loop is open";
  q[0] = std::nan("");
  EXPECT_THROW(static_cast<void>(local_mobility(model, q)), std::invalid_argument);
  EXPECT_THROW(closure_derivatives(model, q, Eigen::MatrixXd::Zero(4, 2)), std::invalid_argument);
  Drawing rolling;
  rolling.body("wheel", "ground", {JointKind::free, {}, {}});
  rolling.description.loops.push_back({.between = {"ground", "wheel"},
                                       .kind = LoopKind::rolling,
                                       .axis = {0, 0, 1},
                                       .point = {0, 0, -1},
                                       .center = {0, 0, 0}});
  const Model on_ground = rolling.model();
  EXPECT_THROW(static_cast<void>(local_mobility(on_ground, neutral(on_ground))), std::invalid_argument);
}

/// The coefficients of a 4 × 4 matrix that depends on t.
using MatrixSeries = std::vector<Eigen::Matrix4d>;

MatrixSeries product_of_series(const MatrixSeries& a, const MatrixSeries& b) {
  MatrixSeries out(a.size(), Eigen::Matrix4d::Zero());
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t j = 0; j <= k; ++j) out[k] += a[j] * b[k - j];
  return out;
}

/// exp X for X without a constant, by its power series.
MatrixSeries exponential(const MatrixSeries& X) {
  MatrixSeries out(X.size(), Eigen::Matrix4d::Zero()), term = out;
  out[0] = term[0] = Eigen::Matrix4d::Identity();
  for (std::size_t k = 1; k < X.size(); ++k) {
    term = product_of_series(term, X);
    for (std::size_t j = 0; j < X.size(); ++j) out[j] += (term[j] /= double(k));
  }
  return out;
}

bool rolls(const Model& model) {
  return std::ranges::any_of(model.loops().joints,
                             [](const Loop& loop) { return loop.rows != loop.residuals; });
}

/// H^(k) are the derivatives of f' f⁻¹ for the product f of 4 × 4 matrices, for loop joints of all kinds.
TEST(ClosureDerivatives, AreThoseOfTheProductOfMatrices) {
  constexpr std::size_t K = 5;
  Comparison comparison("H", 1e-11);
  for_seeds(40, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const ClosedMechanism closed = closed_mechanism(random, {.most_bodies = 6});
    if (rolls(closed.model)) return;
    const higher_order::Walks walks = higher_order::walks(closed.model, closed.state.q);
    const auto n = static_cast<Eigen::Index>(walks.coordinates.size());
    Eigen::MatrixXd derivatives(n, K);
    for (double& entry : derivatives.reshaped()) entry = random.number(-1, 1);
    const std::vector<Eigen::MatrixXd> H = closure_derivatives(closed.model, closed.state.q, derivatives);
    ASSERT_EQ(H.size(), walks.loops.size());
    for (std::size_t l = 0; l < H.size(); ++l) {
      MatrixSeries f(K + 1, Eigen::Matrix4d::Zero()), df = f, inverse = f;
      f[0].setIdentity();
      for (const higher_order::PassedJoint& joint : walks.loops[l]) {
        MatrixSeries X(K + 1, Eigen::Matrix4d::Zero());
        for (std::size_t m = 0; m < joint.S.size(); ++m) {
          double factorial = 1;
          for (std::size_t k = 1; k <= K; ++k)
            X[k] += derivatives(joint.coordinates[m], Eigen::Index(k) - 1) / (factorial *= double(k)) *
                    hat(joint.S[m]);
        }
        f = product_of_series(f, exponential(X));
      }
      for (std::size_t k = 0; k < K; ++k) df[k] = double(k + 1) * f[k + 1];
      inverse[0].setIdentity();
      for (std::size_t k = 1; k <= K; ++k)
        for (std::size_t j = 1; j <= k; ++j) inverse[k] -= f[j] * inverse[k - j];
      const MatrixSeries V = product_of_series(df, inverse);
      Eigen::MatrixXd expected(6, K);
      double factorial = 1;
      for (std::size_t k = 0; k < K; ++k) {
        if (k > 0) factorial *= double(k);
        const Eigen::Matrix4d& A = V[k];
        expected.col(Eigen::Index(k)) =
            factorial * Vector6<double>(A(2, 1), A(0, 2), A(1, 0), A(0, 3), A(1, 3), A(2, 3));
      }
      comparison.expect_equal(H[l], expected);
    }
  });
}

/// Ranks are those of loop_mobility, tangents satisfy A v = 0, and points close the loops of the model.
TEST(LocalMobility, AgreesWithTheRowsOfRandomMechanisms) {
  int analysed = 0, moving = 0;
  for_seeds(40, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const ClosedMechanism closed = closed_mechanism(random, {.most_bodies = 5});
    if (rolls(closed.model)) return;
    ++analysed;
    const LoopMobility rows = loop_mobility(closed.model, closed.state.q);
    const LocalMobility found = local_mobility(closed.model, closed.state.q, {.order = 3});
    EXPECT_EQ(found.differential_mobility + static_cast<int>(found.outside.size()), rows.degrees_of_freedom);
    LoopWorkspace<> workspace(closed.model);
    const Loops& loops = closed.model.loops();
    Rows A(loops.rows, closed.model.nv());
    loop_jacobian<double>(closed.model, workspace, closed.state.q, {A.data(), std::size_t(A.size())});
    std::vector<double> r(static_cast<std::size_t>(loops.residuals));
    for (const MotionBranch& branch : found.branches) {
      ++moving;
      Eigen::MatrixXd v = Eigen::MatrixXd::Zero(closed.model.nv(), branch.dimension);
      for (std::size_t c = 0; c < found.coordinates.size(); ++c)
        if (found.coordinates[c].velocity >= 0)
          v.row(found.coordinates[c].velocity) = branch.T.col(Eigen::Index(c)).transpose();
      EXPECT_LT((A * v).norm(), 1e-7 * A.norm() + 1e-12);
      for (const BranchPoint& point : branch.points) {
        loop_residual<double>(closed.model, workspace, point.q, r);
        EXPECT_LT(largest(r), 1e-9);
      }
    }
  });
  EXPECT_GT(analysed, 5);
  EXPECT_GT(moving, 5);
}

}  // namespace
}  // namespace axode::test
