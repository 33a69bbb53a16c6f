#include "axode/dynamics/closed_form/closed_form.hpp"
#include "tests/vectors/reference_state.hpp"

/// Mass matrix, Coriolis matrices, forward dynamics, momenta, energies and regressors of every reference
/// system.
namespace axode::test {
namespace {

class EquationsOfMotion : public ReferenceStates {
 protected:
  template <class Check> static void each_state_with(const char* quantity, const Check& check) {
    ReferenceStates::each_state_with("dynamics", quantity, check);
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, EquationsOfMotion, testing::ValuesIn(systems()), name_of);

/// An array over pairs or triples of velocities that f(array) fills, brought into the order of the files.
template <class F> std::vector<double> filled(const ReferenceState& at, int dimensions, const F& f) {
  std::size_t size = 1;
  for (int k = 0; k < dimensions; ++k) size *= at.n();
  std::vector<double> out(size);
  f(out);
  return at.in_file_order(out, dimensions);
}
/// The entries of a matrix, row by row.
std::vector<double> rows(const Eigen::MatrixXd& M) { return entries(Eigen::MatrixXd(M.transpose())); }

TEST_P(EquationsOfMotion, MassMatrixAndItsInverse) {
  Comparison M("M", bound), closed("M in closed form", bound), inverse("M_inverse", bound),
      sparse("LDL", bound);
  each_state_with("M", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char*) {
      using Rep = decltype(rep);
      const auto mass = [&](auto& out) { mass_matrix<Rep>(at.model, at.workspace, at.q, out); };
      M.expect_equal(filled(at, 2, mass), numbers(at.dynamics.at("M")));
      closed.expect_equal(at.in_file_order(rows(closed_form::mass_matrix<Rep>(at.model, at.q)), 2),
                          numbers(at.dynamics.at("M")));
      if (!at.dynamics.contains("M_inverse")) return;
      const auto inverted = [&](auto& out) {
        EXPECT_TRUE(inverse_mass_matrix<Rep>(at.model, at.workspace, at.q, out).ok());
      };
      inverse.expect_equal(filled(at, 2, inverted), numbers(at.dynamics.at("M_inverse")));
      const auto factored = [&](auto& out) {
        MassMatrixFactor<> factor(at.model);
        mass_matrix<Rep>(at.model, at.workspace, at.q, out);
        EXPECT_TRUE(factor.factorize(out).ok());
        factor.inverse(out);
      };
      sparse.expect_equal(filled(at, 2, factored), numbers(at.dynamics.at("M_inverse")));
    });
  });
}

TEST_P(EquationsOfMotion, PartialsOfTheMassMatrix) {
  Comparison dM("dM_dq", bound);
  each_state_with("dM_dq", [&](ReferenceState& at) {
    const auto partials = [&](auto& out) { mass_matrix_partials(at.model, at.workspace, at.q, out); };
    dM.expect_equal(filled(at, 3, partials), numbers(at.dynamics.at("dM_dq")));
  });
}

TEST_P(EquationsOfMotion, PartialsOfTheInverseMassMatrix) {
  Comparison dM("dMinv_dq", bound);
  each_state_with("dMinv_dq", [&](ReferenceState& at) {
    const auto partials = [&](auto& out) {
      EXPECT_TRUE(inverse_mass_matrix_partials(at.model, at.workspace, at.q, out).ok());
    };
    dM.expect_equal(filled(at, 3, partials), numbers(at.dynamics.at("dMinv_dq")));
  });
}

TEST_P(EquationsOfMotion, ForwardDynamics) {
  Comparison qdd("qdd", bound);
  each_state_with("forward", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char*) {
      std::vector<double> a(at.n());
      EXPECT_TRUE(forward_dynamics<decltype(rep)>(at.model, at.workspace, at.q, at.v(), at.tau, a,
                                                  {.wrenches = at.wrenches})
                      .ok());
      qdd.expect_equal(at.in_file_order(a, 1), numbers(at.dynamics.at("forward").at("qdd")));
    });
  });
}

TEST_P(EquationsOfMotion, VectorsOfForces) {
  Comparison coriolis("coriolis_vector", bound), gravity("gravity_vector", bound),
      loads("applied_generalized", bound), Q("Q", bound);
  each_state_with("Q", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char*) {
      using Rep = decltype(rep);
      std::vector<double> x(at.n());
      coriolis_vector<Rep>(at.model, at.workspace, at.q, at.v(), x);
      coriolis.expect_equal(at.in_file_order(x, 1), numbers(at.dynamics.at("coriolis_vector")));
      gravity_torques<Rep>(at.model, at.workspace, at.q, x);
      gravity.expect_equal(at.in_file_order(x, 1), numbers(at.dynamics.at("gravity_vector")));
      generalized_loads<Rep>(at.model, at.workspace, at.q, at.v(), {.wrenches = at.wrenches}, x);
      loads.expect_equal(at.in_file_order(x, 1), numbers(at.dynamics.at("applied_generalized")));
      const Eigen::VectorXd tau =
          closed_form::projection_equations<Rep>(at.model, at.q, at.v(), at.a(), {.wrenches = at.wrenches});
      Q.expect_equal(at.in_file_order(entries(tau), 1), numbers(at.dynamics.at("Q")));
    });
    const Loads<> applied{.wrenches = at.wrenches};
    for (const Eigen::VectorXd& tau :
         {closed_form::momentum_balance(at.model, at.q, at.v(), at.a(), applied),
          closed_form::lagrange_equations(at.model, at.q, at.v(), at.a(), applied)})
      Q.expect_equal(at.in_file_order(entries(tau), 1), numbers(at.dynamics.at("Q")));
  });
}

TEST_P(EquationsOfMotion, CoriolisMatrices) {
  Comparison C("C", bound), closed("C in closed form", bound);
  each_state_with("C_matrix", [&](ReferenceState& at) {
    const std::pair<CoriolisForm, const char*> forms[] = {{CoriolisForm::paper, "paper_body"},
                                                          {CoriolisForm::spatial, "spatial"},
                                                          {CoriolisForm::skew, "spatial"},
                                                          {CoriolisForm::christoffel, "christoffel"}};
    for (const auto& pair : forms) {
      const CoriolisForm form = pair.first;
      const std::vector<double> reference = numbers(at.dynamics.at("C_matrix").at(pair.second));
      const auto matrix = [&](auto& out) {
        coriolis_matrix(at.model, at.workspace, at.q, at.v(), form, out);
      };
      C.expect_equal(filled(at, 2, matrix), reference);
      closed.expect_equal(
          at.in_file_order(rows(closed_form::coriolis_matrix(at.model, at.q, at.v(), form)), 2), reference);
    }
  });
}

TEST_P(EquationsOfMotion, ChristoffelSymbols) {
  Comparison Gamma("Gamma", bound), Binet("Gamma by Binet", bound);
  each_state_with("Gamma", [&](ReferenceState& at) {
    const std::vector<double> reference = numbers(at.dynamics.at("Gamma"));
    const auto symbols = [&](auto& out) { christoffel(at.model, at.workspace, at.q, out); };
    Gamma.expect_equal(filled(at, 3, symbols), reference);
    Binet.expect_equal(at.in_file_order(closed_form::christoffel(at.model, at.q), 3), reference);
  });
}

TEST_P(EquationsOfMotion, MomentaAndEnergies) {
  Comparison Pi("Pi", bound), total("Pi_s_total", bound), kinetic("T", bound), potential("U", bound);
  each_state_with("Pi", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char* letter) {
      std::vector<Momentum<decltype(rep)>> bodies(at.n());
      body_momenta<decltype(rep)>(at.model, at.workspace, at.q, at.v(), bodies);
      std::vector<Momentum<decltype(rep)>> listed;
      for (int i = 1; i <= at.model.n_bodies(); ++i)
        listed.push_back(bodies[static_cast<std::size_t>(at.frame(i) - 1)]);
      Pi.expect_equal(entries(listed), numbers(at.dynamics.at("Pi").at(letter)));
    });
    total.expect_equal(entries(spatial_momentum(at.model, at.workspace, at.q, at.v())),
                       numbers(at.dynamics.at("Pi_s_total")));
    kinetic.expect_equal(kinetic_energy(at.model, at.workspace, at.q, at.v()),
                         number(at.dynamics.at("kinetic_energy")));
    potential.expect_equal(potential_energy(at.model, at.workspace, at.q),
                           number(at.dynamics.at("potential_energy")));
  });
}

TEST_P(EquationsOfMotion, Regressor) {
  Comparison Y("regressor", bound);
  each_state_with("regressor", [&](ReferenceState& at) {
    const std::size_t n = at.n(), width = 10 * n;
    std::vector<double> y(n * width), listed;
    regressor(at.model, at.workspace, at.q, at.v(), at.a(), y);
    for (std::size_t j = 1; j <= n; ++j)
      for (int i = 1; i <= at.model.n_bodies(); ++i)
        for (std::size_t k = 0; k < 10; ++k)
          listed.push_back(y[at.place[j] * width + 10 * static_cast<std::size_t>(at.frame(i) - 1) + k]);
    Y.expect_equal(listed, numbers(at.dynamics.at("regressor")));
  });
}

}  // namespace
}  // namespace axode::test
