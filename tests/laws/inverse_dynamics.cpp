#include <Eigen/Eigenvalues>

#include "tests/laws/law.hpp"

/// The generalised forces of a mechanism do not depend on the representation, and have the structure
/// τ = M(q) a + C(q, v) v + g(q) - Jᵀ W.
namespace axode::test {
namespace {

template <class C> class InverseDynamics : public testing::Test {};
TYPED_TEST_SUITE(InverseDynamics, Cases, CaseNames);

TYPED_TEST(InverseDynamics, AgreesWithTheOtherRepresentations) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<T> tau = trial.template inverse_dynamics<Rep>();
    const auto compare = [&](auto other) {
      if constexpr (!std::same_as<Rep, decltype(other)>)
        torque.expect_equal(tau, trial.template inverse_dynamics<decltype(other)>());
    };
    compare(BodyFixed{}), compare(Spatial{}), compare(Hybrid{}), compare(Mixed{});
  });
}

/// M(q), column by column.
template <class Rep, class T> Eigen::MatrixXd mass_matrix(Trial<T>& trial) {
  const int n = trial.model.nv();
  const std::vector<T> zero = trial.zero(), at_rest = trial.template inverse_dynamics<Rep>(zero, zero, {});
  Eigen::MatrixXd M(n, n);
  for (int k = 0; k < n; ++k) {
    std::vector<T> a = zero;
    a[static_cast<std::size_t>(k)] = 1;
    const std::vector<T> tau = trial.template inverse_dynamics<Rep>(zero, a, {});
    for (std::size_t i = 0; i < tau.size(); ++i)
      M(static_cast<int>(i), k) = double(tau[i]) - double(at_rest[i]);
  }
  return M;
}

template <class T> std::vector<T> product(const Eigen::MatrixXd& M, const std::vector<T>& x) {
  const Eigen::VectorXd y =
      M * Eigen::Map<const Eigen::VectorX<T>>(x.data(), M.cols()).template cast<double>();
  return cast<T>(std::vector<double>(y.begin(), y.end()));
}

TYPED_TEST(InverseDynamics, MassMatrixIsSymmetricAndNotNegative) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison symmetry("symmetry", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    const bool every_body_has_mass = seed % 2 == 0;
    Trial<T> trial{Random<double>(seed),
                   {.couplings = !every_body_has_mass, .always_mass = every_body_has_mass}};
    if (trial.model.nv() == 0) return;
    // Gravity would only bury M in rounding.
    trial.model = ModelBuilder(trial.model).gravity({}).build();
    const Eigen::MatrixXd M = mass_matrix<Rep>(trial);
    symmetry.expect_equal(M, Eigen::MatrixXd(M.transpose()));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(M, Eigen::EigenvaluesOnly);
    EXPECT_GE(solver.eigenvalues()[0], -agreement<T> * M.cwiseAbs().maxCoeff());
    if (every_body_has_mass && std::same_as<T, double>) {
      EXPECT_EQ(M.llt().info(), Eigen::Success) << "not positive definite";
    }
  });
}

TYPED_TEST(InverseDynamics, IsAffineInTheAccelerations) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<T> tau = trial.template inverse_dynamics<Rep>();
    std::vector<T> sum = product(mass_matrix<Rep>(trial), trial.state.a);
    const std::vector<T> bias =
        trial.template inverse_dynamics<Rep>(trial.state.v, trial.zero(), trial.state.loads());
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += bias[k];
    torque.expect_equal(sum, tau);
  });
}

TYPED_TEST(InverseDynamics, VelocityTermsAreQuadratic) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const auto velocity_terms = [&](T scale) {
      std::vector<T> v = trial.state.v;
      for (T& x : v) x *= scale;
      std::vector<T> tau = trial.template inverse_dynamics<Rep>(v, trial.zero(), {});
      const std::vector<T> rest = trial.template inverse_dynamics<Rep>(trial.zero(), trial.zero(), {});
      for (std::size_t k = 0; k < tau.size(); ++k) tau[k] = (tau[k] - rest[k]) / (scale * scale);
      return tau;
    };
    const double weight =
        largest(entries(trial.template inverse_dynamics<Rep>(trial.zero(), trial.zero(), {})));
    torque.expect_equal(velocity_terms(T(-2)), velocity_terms(T(1)), weight);
  });
}

TYPED_TEST(InverseDynamics, LoadsActThroughTheTransposedJacobian) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = ModelBuilder(told(random_mechanism(random), random)).gravity({}).build();
    Trial<T> trial(model, random);
    if (trial.state.wrenches.empty()) return;
    const std::vector<T> drives =
        trial.template inverse_dynamics<Rep>(trial.zero(), trial.zero(), trial.state.loads());
    const std::vector<SE3<T>> C = trial.poses();
    std::vector<T> power;
    for (std::size_t k = 0; k < drives.size(); ++k) {
      std::vector<T> v = trial.zero();
      v[k] = 1;
      const std::vector<Twist<Rep, T>> J = trial.template twists<Rep>(v);
      T sum(0);
      for (const AppliedWrench<T>& load : trial.state.wrenches) {
        const std::size_t f = static_cast<std::size_t>(load.frame);
        with_representation(load.representation, [&](auto rep) {
          sum -= Wrench<decltype(rep), T>{load.m, load.f} | change<decltype(rep)>(C[f], J[f]);
        });
      }
      power.push_back(sum);
    }
    torque.expect_equal(drives, power);
  });
}

TYPED_TEST(InverseDynamics, DampingAndFrictionResistOnlyWhenAsked) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    if (seed % 3 == 0 && !trial.state.v.empty()) trial.state.v[0] = 0;
    const std::vector<T> without = trial.template inverse_dynamics<Rep>(trial.state.v, trial.state.a, {});
    const std::vector<T> with =
        trial.template inverse_dynamics<Rep>(trial.state.v, trial.state.a, {.joint_losses = true});
    std::vector<T> expected = without;
    for (const Joint& joint : trial.model.joints()) {
      const double ratio = joint.leader ? joint.leader->ratio : 1;
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const std::size_t k = static_cast<std::size_t>(joint.iv) + d;
        const double speed = ratio * trial.state.v[k], sign = speed > 0 ? 1 : speed < 0 ? -1 : 0;
        expected[k] += T(ratio * (joint.dof[d].damping * speed + joint.dof[d].friction * sign));
      }
    }
    torque.expect_equal(with, expected);
  });
}

template <class Rep> class FloatInverseDynamics : public testing::Test {};
using Representations = testing::Types<BodyFixed, Spatial, Hybrid, Mixed>;
struct RepresentationNames {
  template <class Rep> static std::string GetName(int) {
    const std::string name = CaseNames::GetName<Case<Rep, float>>(0);
    return name.substr(0, name.find('_'));
  }
};
TYPED_TEST_SUITE(FloatInverseDynamics, Representations, RepresentationNames);

TYPED_TEST(FloatInverseDynamics, AgreesWithDouble) {
  Comparison torque("torque", agreement<float>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<float> trial{Random<double>(seed)};
    Trial<double> exact(trial.model, trial.exact);
    torque.expect_equal(cast<double>(trial.template inverse_dynamics<TypeParam>()),
                        exact.template inverse_dynamics<TypeParam>());
  });
}

}  // namespace
}  // namespace axode::test
