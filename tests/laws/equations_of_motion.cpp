#include "axode/dynamics/closed_form.hpp"
#include "tests/laws/law.hpp"

/// The terms of the equations of motion fit together, on trees with joints of all kinds, massless bodies and
/// couplings.
namespace axode::test {
namespace {

template <class C> class EquationsOfMotion : public testing::Test {};
TYPED_TEST_SUITE(EquationsOfMotion, Cases, CaseNames);

using Eigen::MatrixXd, Eigen::VectorXd;

/// What f(span) writes, as a matrix of the rows that it has.
template <class T, class F> MatrixXd rows(int n_rows, int n_columns, const F& f) {
  std::vector<T> x(static_cast<std::size_t>(n_rows) * static_cast<std::size_t>(n_columns));
  f(std::span<T>(x));
  return Eigen::Map<const Eigen::Matrix<T, -1, -1, Eigen::RowMajor>>(x.data(), n_rows, n_columns)
      .template cast<double>();
}
template <class T> VectorXd vector(const std::vector<T>& x) {
  return Eigen::Map<const Eigen::VectorX<T>>(x.data(), static_cast<int>(x.size())).template cast<double>();
}

template <class Rep, class T> MatrixXd mass_matrix(Trial<T>& t) {
  return rows<T>(t.model.nv(), t.model.nv(),
                 [&](auto M) { axode::mass_matrix<Rep>(t.model, t.workspace, t.state.q, M); });
}
template <class T> MatrixXd coriolis_matrix(Trial<T>& t, CoriolisForm form) {
  return rows<T>(t.model.nv(), t.model.nv(), [&](auto C) {
    axode::coriolis_matrix(t.model, t.workspace, t.state.q, t.state.v, form, C);
  });
}

TYPED_TEST(EquationsOfMotion, MassMatrixIsTheDerivativeOfInverseDynamics) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("M a", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<T> with = trial.template inverse_dynamics<Rep>(trial.state.v, trial.state.a, {}),
                         without = trial.template inverse_dynamics<Rep>(trial.state.v, trial.zero(), {});
    const double size = std::max(largest(entries(with)), largest(entries(without)));
    torque.expect_equal(VectorXd(mass_matrix<Rep>(trial) * vector(trial.state.a)),
                        VectorXd(vector(with) - vector(without)), size);
  });
}

TYPED_TEST(EquationsOfMotion, AreTheSumOfTheirTerms) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    Loads<T> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    std::vector<T> Cv = trial.zero(), g = trial.zero(), Q = trial.zero();
    coriolis_vector<Rep>(trial.model, trial.workspace, trial.state.q, trial.state.v, Cv);
    gravity_vector<Rep>(trial.model, trial.workspace, trial.state.q, g);
    generalized_loads<Rep>(trial.model, trial.workspace, trial.state.q, trial.state.v, loads, Q);
    const VectorXd sum = mass_matrix<Rep>(trial) * vector(trial.state.a) + vector(Cv) + vector(g) - vector(Q);
    const std::vector<T> tau = trial.template inverse_dynamics<Rep>(trial.state.v, trial.state.a, loads);
    torque.expect_equal(vector(tau), sum,
                        std::max({largest(entries(Cv)), largest(entries(g)), largest(entries(Q))}));
  });
}

TYPED_TEST(EquationsOfMotion, InverseMassMatrixIsTheInverse) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison inverse("M⁻¹ M x", agreement<T>), sparse("M x by factors", agreement<T>);
  for_seeds(300, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.always_mass = true}};
    const int nv = trial.model.nv();
    bool solved = false;
    const MatrixXd M_inverse = rows<T>(nv, nv, [&](auto out) {
      solved = inverse_mass_matrix<Rep>(trial.model, trial.workspace, trial.state.q, out).ok();
    });
    if (!solved) return;
    const MatrixXd M = mass_matrix<Rep>(trial);
    const VectorXd x = vector(trial.state.a), force = M * x;
    const double size =
        M.cwiseAbs().maxCoeff() * M_inverse.cwiseAbs().maxCoeff() * force.cwiseAbs().maxCoeff();
    inverse.expect_equal(VectorXd(M * (M_inverse * force)), force, size);
    MassMatrixFactor<T> factor(trial.model);
    std::vector<T> entries_of_M;
    for (int r = 0; r < nv; ++r)
      for (int c = 0; c < nv; ++c) entries_of_M.push_back(static_cast<T>(M(r, c)));
    ASSERT_TRUE(factor.factorize(entries_of_M).ok());
    MatrixXd L(nv, nv);
    VectorXd D(nv);
    for (int r = 0; r < nv; ++r) {
      D[r] = double(factor.D(r));
      for (int c = 0; c < nv; ++c) L(r, c) = double(factor.L(r, c));
    }
    sparse.expect_equal(MatrixXd(L.transpose() * D.asDiagonal() * L), M);
    std::vector<T> y(static_cast<std::size_t>(nv));
    for (int c = 0; c < nv; ++c) y[static_cast<std::size_t>(c)] = static_cast<T>(force[c]);
    factor.solve(y);
    sparse.expect_equal(VectorXd(M * vector(y)), force);
  });
}

TYPED_TEST(EquationsOfMotion, AFrameAnswersAnImpulse) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison response("M Y", agreement<T>), symmetry("mobility", agreement<T>), unit("Λ Λ⁻¹ W", agreement<T>);
  for_seeds(200, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.always_mass = true}};
    const int f = trial.model.n_frames() - 1, nv = trial.model.nv();
    const Place<T> place(f, Vec3<T>{T(0.1), T(-0.2), T(0.05)});
    std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(nv)), Y = J;
    jacobian<Rep>(trial.model, trial.workspace, trial.state.q, place, J);
    if (!impulse_response<Rep>(trial.model, trial.workspace, trial.state.q, place, Y).ok()) return;
    MatrixXd J_all(6, nv), Y_all(6, nv);
    for (int c = 0; c < nv; ++c) {
      J_all.col(c) = to_eigen(J[static_cast<std::size_t>(c)]).template cast<double>();
      Y_all.col(c) = to_eigen(Y[static_cast<std::size_t>(c)]).template cast<double>();
    }
    const MatrixXd M = mass_matrix<Rep>(trial);
    response.expect_equal(MatrixXd(M * Y_all.transpose()), MatrixXd(J_all.transpose()),
                          M.cwiseAbs().maxCoeff() * Y_all.cwiseAbs().maxCoeff());
    const MatrixXd mobile = rows<T>(6, 6, [&](auto out) {
      EXPECT_TRUE(mobility<Rep>(trial.model, trial.workspace, trial.state.q, place, out).ok());
    });
    symmetry.expect_equal(mobile, MatrixXd(J_all * Y_all.transpose()));
    OperationalSpace outcome;
    const MatrixXd Lambda = rows<T>(6, 6, [&](auto out) {
      outcome = operational_space_inertia<Rep>(trial.model, trial.workspace, trial.state.q, place, out);
    });
    if (!outcome.ok()) {
      EXPECT_TRUE(Lambda.array().isNaN().all());
      return;
    }
    const VectorXd V = mobile * VectorXd::Ones(6);
    unit.expect_equal(VectorXd(mobile * (Lambda * V)), V,
                      mobile.cwiseAbs().maxCoeff() * Lambda.cwiseAbs().maxCoeff());
  });
}

TYPED_TEST(EquationsOfMotion, GravityIsTheGradientOfThePotentialEnergy) {
  using Rep = typename TypeParam::Rep;
  Comparison work("g v", 1e-7);  // differences, in double
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 20}};
    const double h = 1e-5;
    const auto energy = [&](double s) {
      std::vector<double> step = trial.exact.v;
      for (double& x : step) x *= s;
      return potential_energy(trial.model, trial.workspace, integrate(trial.model, trial.exact.q, step));
    };
    std::vector<double> g = trial.zero();
    gravity_vector<Rep>(trial.model, trial.workspace, trial.exact.q, g);
    const double size = norm(trial.model.gravity()) * trial.model.total_mass() + std::abs(energy(0));
    work.expect_equal((energy(h) - energy(-h)) / (2 * h), vector(g).dot(vector(trial.exact.v)), size);
  });
}

// --------------------------------------------------------------------------------------------------- double only

class ClosedForms : public testing::Test {};

/// How large the terms of a Coriolis matrix are, though they may cancel.
double size_of_C(Trial<double>& t) {
  return mass_matrix<Spatial>(t).cwiseAbs().maxCoeff() * largest(entries(t.state.v));
}

/// M' along v, from the partials of M.
MatrixXd mass_matrix_rate(Trial<double>& t) {
  const int nv = t.model.nv();
  std::vector<double> dM(static_cast<std::size_t>(nv) * nv * nv);
  mass_matrix_partials(t.model, t.workspace, t.state.q, dM);
  MatrixXd rate = MatrixXd::Zero(nv, nv);
  for (int k = 0; k < nv; ++k)
    rate +=
        t.state.v[static_cast<std::size_t>(k)] * Eigen::Map<const MatrixXd>(dM.data() + k * nv * nv, nv, nv);
  return rate;
}

TEST_F(ClosedForms, PartialsOfTheMassMatrixAreItsDerivatives) {
  Comparison dM("dM", 1e-7);  // central differences
  for_seeds(200, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 20}};
    const double h = 1e-5;
    const auto moved = [&](double s) {
      Trial<double> there(trial.model, trial.exact);
      std::vector<double> step = trial.state.v;
      for (double& x : step) x *= s;
      there.state.q = integrate(trial.model, trial.state.q, step);
      return mass_matrix<Spatial>(there);
    };
    dM.expect_equal(mass_matrix_rate(trial), MatrixXd((moved(h) - moved(-h)) / (2 * h)),
                    mass_matrix<Spatial>(trial).cwiseAbs().maxCoeff());
  });
}

TEST_F(ClosedForms, CoriolisMatricesMakeTheCoriolisVector) {
  Comparison forces("C v", 1e-11), closed("C in closed form", 1e-11);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 30}};
    std::vector<double> Cv = trial.zero();
    coriolis_vector<Spatial>(trial.model, trial.workspace, trial.state.q, trial.state.v, Cv);
    const double v_largest = largest(entries(trial.state.v)), size = size_of_C(trial);
    for (const CoriolisForm form :
         {CoriolisForm::paper, CoriolisForm::skew, CoriolisForm::spatial, CoriolisForm::christoffel}) {
      const MatrixXd C = coriolis_matrix(trial, form);
      forces.expect_equal(VectorXd(C * vector(trial.state.v)), vector(Cv), size * v_largest);
      closed.expect_equal(closed_form::coriolis_matrix(trial.model, trial.state.q, trial.state.v, form), C,
                          size);
    }
  });
}

TEST_F(ClosedForms, MassMatrixRateMinusTwiceCIsSkewWhereItIsClaimed) {
  Comparison skew("M' - 2C", 1e-11);
  int not_skew = 0, trees = 0;
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 30}};
    const MatrixXd dM = mass_matrix_rate(trial);
    const auto symmetric_part = [&](CoriolisForm form) {
      const MatrixXd difference = dM - 2 * coriolis_matrix(trial, form);
      return MatrixXd(difference + difference.transpose());
    };
    const double size = size_of_C(trial);
    for (const CoriolisForm form : {CoriolisForm::skew, CoriolisForm::spatial, CoriolisForm::christoffel}) {
      const MatrixXd part = symmetric_part(form);
      skew.expect_equal(part, MatrixXd::Zero(part.rows(), part.cols()).eval(), size);
    }
    ++trees, not_skew += symmetric_part(CoriolisForm::paper).cwiseAbs().maxCoeff() > 1e-3 * size;
  });
  EXPECT_GT(not_skew, trees / 2) << "the paper's C";
}

TEST_F(ClosedForms, ChristoffelSymbolsAreTheMetricConnection) {
  Comparison metric("∂_k M_ij", 1e-11), matrix("C", 1e-11);
  for_seeds(300, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 15}};
    const int nv = trial.model.nv();
    const std::size_t n = static_cast<std::size_t>(nv);
    std::vector<double> Gamma(n * n * n), dM = Gamma, sum;
    christoffel_symbols(trial.model, trial.workspace, trial.state.q, Gamma);
    mass_matrix_partials(trial.model, trial.workspace, trial.state.q, dM);
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          sum.push_back(Gamma[(i * n + j) * n + k] + Gamma[(j * n + i) * n + k]);
    const double size = mass_matrix<Spatial>(trial).cwiseAbs().maxCoeff();
    metric.expect_equal(sum, dM, size);
    MatrixXd C(nv, nv);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        double x = 0;
        for (std::size_t k = 0; k < n; ++k) x += Gamma[(i * n + j) * n + k] * trial.state.v[k];
        C(static_cast<int>(i), static_cast<int>(j)) = x;
      }
    matrix.expect_equal(coriolis_matrix(trial, CoriolisForm::christoffel), C, size_of_C(trial));
    for (int i = 1; i <= trial.model.n_bodies(); ++i)
      if (trial.model.joint(i).dof.size() != 1) return;
    Comparison binet("Binet", 1e-11);
    binet.expect_equal(closed_form::christoffel_symbols(trial.model, trial.state.q), Gamma, size);
  });
}

TEST_F(ClosedForms, AgreeWithTheRecursions) {
  Comparison torque("torque", 1e-11), mass("M", 1e-11);
  for_seeds(300, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 30}};
    Loads<double> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    const std::vector<double>&q = trial.state.q, &v = trial.state.v, &a = trial.state.a;
    const VectorXd tau = vector(trial.inverse_dynamics<Spatial>(v, a, loads));
    const auto check = [&](auto rep) {
      using Rep = decltype(rep);
      torque.expect_equal(closed_form::projection_equations<Rep>(trial.model, q, v, a, loads), tau);
      mass.expect_equal(closed_form::mass_matrix<Rep>(trial.model, q), mass_matrix<Rep>(trial));
    };
    check(BodyFixed{}), check(Spatial{}), check(Hybrid{}), check(Mixed{});
    torque.expect_equal(closed_form::momentum_balance(trial.model, q, v, a, loads), tau);
    torque.expect_equal(closed_form::lagrange_equations(trial.model, q, v, a, loads), tau);
  });
}

}  // namespace
}  // namespace axode::test
