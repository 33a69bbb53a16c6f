#include <Eigen/Eigenvalues>

#include "tests/laws/law.hpp"

/// Forward dynamics undoes inverse dynamics, in every representation and with every load; a mass matrix that
/// cannot be inverted is reported, and only such.
namespace axode::test {
namespace {

template <class C> class ForwardDynamics : public testing::Test {};
TYPED_TEST_SUITE(ForwardDynamics, CasesWithFast, CaseNames);

template <class Rep, class T> Eigen::MatrixX<T> mass_matrix(Trial<T>& trial) {
  const int nv = trial.model.nv();
  Eigen::MatrixX<T> M(nv, nv);
  axode::mass_matrix<Rep>(trial.model, trial.workspace, trial.state.q,
                          std::span(M.data(), static_cast<std::size_t>(M.size())));
  return M;
}

/// The smallest eigenvalue of M scaled to a unit diagonal: how far it is from singular.
template <class T> double definiteness(const Eigen::MatrixX<T>& M) {
  Eigen::MatrixXd S = M.template cast<double>();
  if (S.rows() == 0) return 1;
  if (S.diagonal().minCoeff() <= 0) return 0;
  const Eigen::VectorXd scale = S.diagonal().cwiseSqrt().cwiseInverse();
  S = (scale.asDiagonal() * S * scale.asDiagonal()).eval();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

TYPED_TEST(ForwardDynamics, UndoesInverseDynamics) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  int solved = 0, singular = 0;
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    Loads<T> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    const std::vector<T> tau = trial.template inverse_dynamics<Rep>(trial.state.v, trial.state.a, loads);
    std::vector<T> a = trial.zero();
    const Solvability solvability =
        forward_dynamics<Rep>(trial.model, trial.workspace, trial.state.q, trial.state.v, tau, a, loads);
    const double pivot = definiteness(mass_matrix<Rep>(trial));
    if (solvability.ok()) {
      ++solved;
      torque.expect_equal(trial.template inverse_dynamics<Rep>(trial.state.v, a, loads), tau);
    } else {
      ++singular;
      EXPECT_LE(pivot, agreement<T> / 10);
      EXPECT_TRUE(std::all_of(a.begin(), a.end(), [](T x) { return std::isnan(x); }));
    }
  });
  EXPECT_GE(solved, (solved + singular) / 10);
  EXPECT_GE(singular, (solved + singular) / 10);
}

}  // namespace
}  // namespace axode::test
