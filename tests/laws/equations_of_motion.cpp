#include "axode/dynamics/closed_form/closed_form.hpp"
#include "tests/laws/law.hpp"

/// The terms of the equations of motion agree with each other, on trees with joints of all kinds, massless
/// bodies and couplings.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

class EquationsOfMotion : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, EquationsOfMotion, testing::ValuesIn(cases()), name_of);

TEST_P(EquationsOfMotion, MassMatrixIsTheDerivativeOfInverseDynamics) {
  Comparison torque("M a", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    const std::vector<double> with = trial.inverse_dynamics(trial.state.v, trial.state.a, {}),
                              without = trial.inverse_dynamics(trial.state.v, trial.zero(), {});
    torque.expect_equal(product(trial.mass_matrix(), vector(trial.state.a)),
                        VectorXd(vector(with) - vector(without)), std::max(largest(with), largest(without)));
  });
}

TEST_P(EquationsOfMotion, AreTheSumOfTheirTerms) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    Ask ask = trial.ask();
    ask.loads.joint_losses = seed % 2 == 0;
    const std::vector<double> Cv = trial.call("coriolis_vector", ask), g = trial.call("gravity_torques", ask),
                              Q = trial.call("generalized_loads", ask);
    const VectorXd sum =
        product(trial.mass_matrix(), vector(trial.state.a)) + vector(Cv) + vector(g) - vector(Q);
    torque.expect_equal(vector(trial.call("inverse_dynamics", ask)), sum,
                        std::max({largest(Cv), largest(g), largest(Q)}));
  });
}

/// The mass matrix M = Lᵀ D L and products M⁻¹ f from its sparse factors, computed in T.
struct ByFactors {
  MatrixXd L, DL;
  std::vector<double> solution;
};
template <class T>
ByFactors by_factors(const Model& model, const std::vector<double>& M, const VectorXd& force) {
  MassMatrixFactor<T> factor(model);
  EXPECT_TRUE(factor.factorize(cast<T>(M)).ok());
  const int nv = model.nv();
  ByFactors out{MatrixXd(nv, nv), MatrixXd(nv, nv), {}};
  for (int r = 0; r < nv; ++r)
    for (int c = 0; c < nv; ++c)
      out.L(r, c) = double(factor.L(r, c)), out.DL(r, c) = double(factor.D(r)) * out.L(r, c);
  std::vector<T> y = cast<T>(numbers(force));
  factor.solve(y);
  out.solution = cast<double>(y);
  return out;
}

TEST_P(EquationsOfMotion, InverseMassMatrixIsTheInverse) {
  Comparison inverse("M⁻¹ M x", GetParam().agreement()), sparse("M x by factors", GetParam().agreement());
  for_seeds(300, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, {.always_mass = true});
    const auto [entries_of_inverse, solvability] = trial.answer("inverse_mass_matrix", trial.ask());
    if (!solvability.ok()) return;
    const MatrixXd M_inverse = matrix(trial.model.nv(), entries_of_inverse), M = trial.mass_matrix();
    const VectorXd force = product(M, vector(trial.state.a));
    const double size = largest_entry(M) * largest_entry(M_inverse) * largest_entry(force);
    inverse.expect_equal(product(M, product(M_inverse, force)), force, size);
    const std::vector<double> entries_of_M = trial.call("mass_matrix");
    const auto [L, DL, y] = GetParam().single ? by_factors<float>(trial.model, entries_of_M, force)
                                              : by_factors<double>(trial.model, entries_of_M, force);
    sparse.expect_equal(product(L.transpose(), DL), M);
    sparse.expect_equal(product(M, vector(y)), force);
  });
}

TEST_P(EquationsOfMotion, AFrameAnswersAnImpulse) {
  const double agreement = GetParam().agreement();
  Comparison response("M Y", agreement), symmetry("mobility", agreement), unit("Λ Λ⁻¹ W", agreement);
  for_seeds(200, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, {.always_mass = true});
    Ask ask = trial.ask();
    ask.place = {trial.model.n_frames() - 1, Vec3<>{0.1, -0.2, 0.05}};
    const auto [columns_of_Y, solvability] = trial.answer("impulse_response", ask);
    if (!solvability.ok()) return;
    const MatrixXd J_transposed = matrix(trial.model.nv(), trial.call("jacobian", ask)),
                   Y_transposed = matrix(trial.model.nv(), columns_of_Y), M = trial.mass_matrix();
    response.expect_equal(product(M, Y_transposed), J_transposed,
                          largest_entry(M) * largest_entry(Y_transposed));
    const auto [rows, mobile] = trial.answer("inverse_operational_space_inertia", ask);
    EXPECT_TRUE(mobile.ok());
    const MatrixXd mobility = matrix(6, rows);
    symmetry.expect_equal(mobility, product(J_transposed.transpose(), Y_transposed));
    const auto [Lambda, moves] = trial.answer("operational_space_inertia", ask);
    if (!moves.ok()) {
      EXPECT_TRUE(std::all_of(Lambda.begin(), Lambda.end(), [](double x) { return std::isnan(x); }));
      return;
    }
    const VectorXd V = product(mobility, VectorXd(VectorXd::Ones(6)));
    unit.expect_equal(product(mobility, product(matrix(6, Lambda), V)), V,
                      largest_entry(mobility) * largest(Lambda));
  });
}

TEST_P(EquationsOfMotion, GravityIsTheGradientOfThePotentialEnergy) {
  Comparison work("g v", 1e-7);  // differences of the energy, computed in double
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(in_double(GetParam()), seed, {.most_bodies = 20});
    const double h = 1e-5;
    const auto energy = [&](double s) {
      std::vector<double> step = trial.state.v;
      for (double& x : step) x *= s;
      return trial.call("potential_energy", {.q = integrate(trial.model, trial.state.q, step)})[0];
    };
    double power = 0;
    const std::vector<double> g = trial.call("gravity_torques");
    for (std::size_t c = 0; c < g.size(); ++c) power += g[c] * trial.state.v[c];
    const double size = norm(trial.model.gravity()) * trial.model.total_mass() + std::abs(energy(0));
    work.expect_equal((energy(h) - energy(-h)) / (2 * h), power, size);
  });
}

// ----------------------------------------------------------------------------------------------- double only

class ClosedForms : public testing::Test {
 protected:
  const Case how = in(Representation::spatial, scalars()[0]);
};

MatrixXd coriolis_matrix(Trial& t, CoriolisForm form) {
  Ask ask = t.ask();
  ask.form = form;
  return matrix(t.model.nv(), t.call("coriolis_matrix", ask));
}

/// An estimate of the size of the terms of a Coriolis matrix, which may cancel each other.
double size_of_C(Trial& t) { return largest_entry(t.mass_matrix()) * largest(t.state.v); }

/// The rate of M along v, from its partial derivatives.
MatrixXd mass_matrix_rate(Trial& t) {
  const std::vector<double> dM = t.call("mass_matrix_partials");
  const std::size_t nv = t.state.v.size();
  std::vector<double> rate(nv * nv);
  for (std::size_t k = 0; k < nv; ++k)
    for (std::size_t ij = 0; ij < nv * nv; ++ij) rate[ij] += t.state.v[k] * dM[k * nv * nv + ij];
  return matrix(t.model.nv(), rate);
}

TEST_F(ClosedForms, PartialsOfTheMassMatrixAreItsDerivatives) {
  Comparison dM("dM", 1e-7);  // central differences
  for_seeds(200, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 20});
    const double h = 1e-5;
    const auto moved = [&](double s) {
      std::vector<double> step = trial.state.v;
      for (double& x : step) x *= s;
      return vector(trial.call("mass_matrix", {.q = integrate(trial.model, trial.state.q, step)}));
    };
    dM.expect_equal(mass_matrix_rate(trial),
                    matrix(trial.model.nv(), numbers((moved(h) - moved(-h)) / (2 * h))),
                    largest_entry(trial.mass_matrix()));
  });
}

TEST_F(ClosedForms, CoriolisMatricesMakeTheCoriolisVector) {
  Comparison forces("C v", 1e-11), closed("C in closed form", 1e-11);
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 30});
    const VectorXd Cv = vector(trial.call("coriolis_vector"));
    const double v_largest = largest(trial.state.v), size = size_of_C(trial);
    for (const CoriolisForm form :
         {CoriolisForm::paper, CoriolisForm::skew, CoriolisForm::spatial, CoriolisForm::christoffel}) {
      const MatrixXd C = coriolis_matrix(trial, form);
      forces.expect_equal(product(C, vector(trial.state.v)), Cv, size * v_largest);
      closed.expect_equal(closed_form::coriolis_matrix(trial.model, trial.state.q, trial.state.v, form), C,
                          size);
    }
  });
}

TEST_F(ClosedForms, MassMatrixRateMinusTwiceCIsSkewWhereItIsClaimed) {
  Comparison skew("M' - 2C", 1e-11);
  int not_skew = 0, trees = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 30});
    const MatrixXd dM = mass_matrix_rate(trial);
    const auto symmetric_part = [&](CoriolisForm form) {
      const MatrixXd difference = dM - 2 * coriolis_matrix(trial, form);
      return MatrixXd(difference + difference.transpose());
    };
    const double size = size_of_C(trial);
    for (const CoriolisForm form : {CoriolisForm::skew, CoriolisForm::spatial, CoriolisForm::christoffel}) {
      const MatrixXd part = symmetric_part(form);
      skew.expect_equal(part, MatrixXd(MatrixXd::Zero(part.rows(), part.cols())), size);
    }
    ++trees, not_skew += largest_entry(symmetric_part(CoriolisForm::paper)) > 1e-3 * size;
  });
  EXPECT_GT(not_skew, trees / 2) << "the paper's C";
}

TEST_F(ClosedForms, ChristoffelSymbolsAreTheMetricConnection) {
  Comparison metric("∂_k M_ij", 1e-11), contracted("C", 1e-11);
  for_seeds(300, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 15});
    const std::size_t n = trial.state.v.size();
    const std::vector<double> Gamma = trial.call("christoffel"), dM = trial.call("mass_matrix_partials");
    std::vector<double> sum;
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          sum.push_back(Gamma[(i * n + j) * n + k] + Gamma[(j * n + i) * n + k]);
    const double size = largest_entry(trial.mass_matrix());
    metric.expect_equal(sum, dM, size);
    std::vector<double> C;
    for (std::size_t ij = 0; ij < n * n; ++ij) {
      C.push_back(0);
      for (std::size_t k = 0; k < n; ++k) C.back() += Gamma[ij * n + k] * trial.state.v[k];
    }
    contracted.expect_equal(coriolis_matrix(trial, CoriolisForm::christoffel), matrix(trial.model.nv(), C),
                            size_of_C(trial));
    for (int i = 1; i <= trial.model.n_bodies(); ++i)
      if (trial.model.joint(i).dof.size() != 1) return;
    Comparison binet("Binet", 1e-11);
    binet.expect_equal(closed_form::christoffel(trial.model, trial.state.q), Gamma, size);
  });
}

TEST_F(ClosedForms, AgreeWithTheRecursions) {
  Comparison torque("torque", 1e-11), mass("M", 1e-11);
  for_seeds(300, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 30});
    Loads<double> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    const std::vector<double>&q = trial.state.q, &v = trial.state.v, &a = trial.state.a;
    const VectorXd tau = vector(trial.inverse_dynamics(v, a, loads));
    for (const Representation representation : representations) {
      const MatrixXd M = trial.by(representation).mass_matrix();
      with_representation(representation, [&](auto rep) {
        using Rep = decltype(rep);
        torque.expect_equal(closed_form::projection_equations<Rep>(trial.model, q, v, a, loads), tau);
        mass.expect_equal(closed_form::mass_matrix<Rep>(trial.model, q), M);
      });
    }
    torque.expect_equal(closed_form::momentum_balance(trial.model, q, v, a, loads), tau);
    torque.expect_equal(closed_form::lagrange_equations(trial.model, q, v, a, loads), tau);
  });
}

}  // namespace
}  // namespace axode::test
