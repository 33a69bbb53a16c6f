#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/dual.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"
#include "tests/support/refused_arguments.hpp"

/// The linear system at a state describes the difference of two neighbouring motions, in the limit. It
/// refuses mechanisms with loops.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Numbers = Trial::Numbers;

/// The linear system counts springs, and forward dynamics leaves them out. Where the two are compared, the
/// forces of springs are added to the drive forces.
class Linearized : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, Linearized, testing::ValuesIn(scalars()), name_of);
class LinearizedInDouble : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, LinearizedInDouble, testing::Values(scalars()[0]), name_of);

/// The matrices A and B, computed in the scalar type of a case.
struct System {
  MatrixXd A, B;
  Solvability solvability;
};
System linearized(const Case& c, const Model& model, const Ask& ask) {
  return with_scalar(c, [&](auto scalar) {
    using T = decltype(scalar);
    const Arguments<T> at(ask);
    const Eigen::Index nv = model.nv();
    using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Matrix A = Matrix::Constant(2 * nv, 2 * nv, T(7)), B = Matrix::Constant(2 * nv, nv, T(7));
    Workspace<T> workspace(model);
    const Solvability solvability =
        linearize(model, workspace, at.q, at.v, at.tau, {as_span(A), as_span(B)}, at.given().loads);
    return System{A.template cast<double>(), B.template cast<double>(), solvability};
  });
}

/// The state with random forces, its loads, and losses.
Ask any_state(const Trial& trial, Random<double>& random) {
  Ask ask = trial.ask();
  ask.loads.joint_losses = true;
  ask.tau = random_numbers(random, trial.model.nv());
  return ask;
}

/// The rate of the difference δ between two motions, one through q0 with velocities v0 and one through q1 =
/// q0 ⊕ δ with v1. It is the exact time derivative of q1 ⊖ q0, from the rates of the coordinates.
VectorXd rate_of_difference(const Model& model, const Numbers& q0, const Numbers& v0, const Numbers& q1,
                            const Numbers& v1) {
  using D = Dual<double, 1>;
  const auto moving = [&](const Numbers& q, const Numbers& v) {
    const Numbers dq = coordinate_rates(model, q, v);
    std::vector<D> out;
    for (std::size_t k = 0; k < q.size(); ++k) out.emplace_back(q[k], std::array{dq[k]});
    return out;
  };
  const std::vector<D> from = moving(q0, v0), to = moving(q1, v1);
  const Tree<D> tree = axode::cast<D>(model.tree<double>());
  std::vector<D> delta(v0.size());
  for (int i = 1; i <= tree->n; ++i)
    if (!tree->coupled[i])
      with_joint(tree, i, [&](const auto& joint) {
        joint.difference(&from[tree->iq[i]], &to[tree->iq[i]], &delta[tree->iv[i]]);
      });
  VectorXd rate(static_cast<Eigen::Index>(delta.size()));
  for (std::size_t k = 0; k < delta.size(); ++k) rate[static_cast<Eigen::Index>(k)] = delta[k].dx[0];
  return rate;
}

/// The arguments with the forces of springs added to the drive forces.
Ask with_springs(Trial& trial, Ask ask) {
  ask.tau = numbers(vector(ask.tau) + vector(trial.call("spring_forces", ask)));
  return ask;
}

/// The rate of the deviation x of a motion from the one through the state `at`, if the drive forces of the
/// deviating motion are larger by dtau.
VectorXd rate_of_deviation(Trial& trial, const Ask& at, const VectorXd& x, const VectorXd& dtau) {
  const Eigen::Index nv = trial.model.nv();
  Ask ask = at;
  ask.q = integrate(trial.model, at.q, numbers(x.head(nv)));
  ask.v = numbers(vector(at.v) + x.tail(nv)), ask.tau = numbers(vector(at.tau) + dtau);
  VectorXd rate(2 * nv);
  rate << rate_of_difference(trial.model, at.q, at.v, ask.q, ask.v),
      vector(trial.call("forward_dynamics", with_springs(trial, ask)));
  return rate;
}

TEST_P(LinearizedInDouble, IsTheLimitOfDifferencesOfMotions) {
  Comparison of_displacements("delta'", 1e-9), of_velocities("dv'", 1e-6);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 8, .always_mass = true});
    const Eigen::Index nv = trial.model.nv();
    if (nv == 0) return;
    const Ask ask = any_state(trial, random);
    const System linear = linearized(GetParam(), trial.model, ask);
    ASSERT_TRUE(linear.solvability.ok());
    for (int k = 0; k < 4; ++k) {
      const VectorXd x = vector(random_numbers(random, 2 * trial.model.nv())),
                     dtau = vector(random_numbers(random, trial.model.nv()));
      const double h = 1e-5;
      const auto at = [&](double eps) { return rate_of_deviation(trial, ask, eps * x, eps * dtau); };
      const VectorXd expected = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h),
                     rate = linear.A * x + linear.B * dtau;
      of_displacements.expect_equal(VectorXd(rate.head(nv)), VectorXd(expected.head(nv)), 1);
      of_velocities.expect_equal(VectorXd(rate.tail(nv)), VectorXd(expected.tail(nv)),
                                 largest_entry(linear.A));
    }
  });
}

TEST_P(Linearized, HasTheDerivativesOfForwardDynamicsBelow) {
  Comparison of_springs("da/dtau K", GetParam().agreement());
  int with = 0, without = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.always_mass = true});
    const Eigen::Index nv = trial.model.nv();
    const Ask ask = any_state(trial, random);
    const System linear = linearized(GetParam(), trial.model, ask);
    const Answer derivatives = trial.answer("forward_dynamics_derivatives", with_springs(trial, ask));
    EXPECT_EQ(linear.solvability, derivatives.solvability);
    if (!linear.solvability.ok() || nv == 0) return;
    const auto block = [&](const Numbers& all, Eigen::Index k) {
      return matrix(trial.model.nv(), Numbers(all.begin() + k * nv * nv, all.begin() + (k + 1) * nv * nv));
    };
    const Numbers K = trial.call("spring_force_derivatives", ask);
    const MatrixXd da_dtau = block(derivatives.numbers, 2);
    for (Eigen::Index k = 0; k < 2; ++k) {  // by q, by v
      const MatrixXd found = linear.A.block(nv, k * nv, nv, nv), of_tree = block(derivatives.numbers, k);
      if (trial.model.springs().empty()) {
        EXPECT_EQ(found, of_tree);
        continue;
      }
      const MatrixXd by_springs = block(K, k);
      of_springs.expect_equal(
          found, MatrixXd(of_tree + product(da_dtau, by_springs)),
          std::max(largest_entry(of_tree), largest_entry(da_dtau) * largest_entry(by_springs)));
    }
    ++(trial.model.springs().empty() ? without : with);
    EXPECT_EQ(MatrixXd(linear.B.bottomRows(nv)), da_dtau);
    EXPECT_TRUE(linear.B.topRows(nv).isZero(0));
    EXPECT_TRUE(linear.A.topRightCorner(nv, nv).isIdentity(0));
  });
  EXPECT_GT(with, 0);
  EXPECT_GT(without, 0);
}

TEST_P(Linearized, KeepsADisplacementAlongTheMotion) {  // because [v, v] = 0
  Comparison nothing("-ad_v v", GetParam().single ? 1e-6 : 1e-15);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.always_mass = true});
    const Eigen::Index nv = trial.model.nv();
    const System linear = linearized(GetParam(), trial.model, any_state(trial, random));
    if (!linear.solvability.ok() || nv == 0) return;
    const VectorXd v = vector(trial.state.v);
    nothing.expect_equal(VectorXd(linear.A.topLeftCorner(nv, nv) * v), VectorXd(VectorXd::Zero(nv)),
                         std::pow(largest(trial.state.v), 2));
  });
}

TEST_P(Linearized, IsNotThereWhereTheMassMatrixIsSingular) {
  const Model model =
      ModelBuilder()
          .add({.name = "arm",
                .joint = {.kind = JointKind::spherical},
                .inertia = MassProperties{.mass = 1, .com = {0, 0, 1}, .Theta = {1, 1, 1, 0, 0, 0}}})
          .add({.name = "ghost", .predecessor = "arm", .joint = {.kind = JointKind::revolute}})
          .build();
  const Numbers zero(static_cast<std::size_t>(model.nv()));
  const System linear = linearized(GetParam(), model, {.q = neutral(model), .v = zero, .tau = zero});
  EXPECT_EQ(linear.solvability.singular_body, 2);
  EXPECT_TRUE(linear.A.array().isNaN().all() && linear.B.array().isNaN().all());
}

TEST(LinearizationResults, OfWrongSizesOrInSharedMemoryAreRefused) {
  const Model model = shoulder();
  Workspace<> workspace(model);
  const Numbers q = neutral(model), x(4);
  std::vector<double> memory(200);
  const std::span<double> all(memory);
  const auto into = [&](std::span<double> A, std::span<double> B) {
    return [&, A, B] { (void)linearize(model, workspace, q, x, x, {A, B}); };
  };
  EXPECT_THAT(into(all.first(63), all.last(32)), refused("linear.A", 63, "2nv * 2nv", 64));
  EXPECT_THAT(into(all.first(64), all.last(33)), refused("linear.B", 33, "2nv * nv", 32));
  const auto shared = [](const char* result, const char* other) {
    return testing::StartsWith(std::string(result) + " shares memory with " + other);
  };
  EXPECT_THAT(message_of(into(all.first(64), all.subspan(63, 32))), shared("linear.B", "linear.A"));
  const std::span<const double> v = all.subspan(60, 4);
  EXPECT_THAT(message_of([&] {
                (void)linearize(model, workspace, q, v, x, {all.first(64), all.last(32)});
              }),
              shared("linear.A", "v"));
  EXPECT_THAT(message_of([&] {
                (void)linearize(model, workspace, q, v, x, {all.last(64), all.subspan(63, 32)});
              }),
              shared("linear.B", "v"));
  EXPECT_THAT(message_of([&] {
                (void)linearize(model, workspace, q, std::span(x).first(3), x, {all.first(64), all.last(32)});
              }),
              testing::StartsWith("v has 3 entries"));
}

/// With springs, q and tau are read again while results are written, so that the call is refused.
TEST_P(Linearized, InTheMemoryOfQOrTauIsRightOrRefused) {
  int right = 0, refusals = 0;
  with_scalar(GetParam(), [&](auto scalar) {
    using T = decltype(scalar);
    for_seeds(50, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const Model model =
          ModelBuilder(random_description(random, {.most_bodies = 8, .always_mass = true})).build();
      const Arguments<T> at(model, random);
      Workspace<T> workspace(model);
      const std::size_t n = at.v.size();
      std::vector<T> A(4 * n * n), B(2 * n * n), A_in_place(A), B_in_place(B);
      const Solvability apart = linearize(model, workspace, at.q, at.v, at.tau, {A, B}, at.given().loads);
      if (n == 0 || !apart.ok() || at.q.size() > A.size()) return;
      std::ranges::copy(at.q, A_in_place.begin());
      std::ranges::copy(at.tau, B_in_place.begin());
      const auto call = [&](std::span<const T> q, std::span<const T> tau) {
        return linearize(model, workspace, q, at.v, tau, {A_in_place, B_in_place}, at.given().loads);
      };
      const std::span<const T> q = std::span(A_in_place).first(at.q.size()),
                               tau = std::span(B_in_place).first(n);
      if (!model.springs().empty()) {
        ++refusals;
        EXPECT_THAT(message_of([&] { (void)call(q, at.tau); }),
                    testing::StartsWith("linear.A shares memory with q"));
        EXPECT_THAT(message_of([&] { (void)call(at.q, tau); }),
                    testing::StartsWith("linear.B shares memory with tau"));
        return;
      }
      ++right;
      EXPECT_EQ(call(q, tau), apart);
      EXPECT_EQ(A_in_place, A);
      EXPECT_EQ(B_in_place, B);
    });
  });
  EXPECT_GT(right, 0);
  EXPECT_GT(refusals, 0);
}

}  // namespace
}  // namespace axode::test
