#include "axode/kinematics/system_matrices.hpp"
#include "tests/vectors/reference_state.hpp"

/// Jacobians, their rates and partials, motion of higher order and system matrices of every reference system.
namespace axode::test {
namespace {

class KinematicsOfReferenceSystems : public ReferenceStates {
 protected:
  template <class Check> static void each_state_with(const char* quantity, const Check& check) {
    ReferenceStates::each_state_with("kinematics", quantity, check);
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, KinematicsOfReferenceSystems, testing::ValuesIn(systems()), name_of);

TEST_P(KinematicsOfReferenceSystems, TwistsUpToSnap) {
  const char* const keys[] = {"V", "Vdot", "Vddot", "Vdddot"};
  Comparison twist("twist", bound);
  each_state_with("Vdddot", [&](ReferenceState& at) {
    HigherOrderMotion<> motion(at.model, 3);
    motion.evaluate(at.q, at.rates);
    each_representation([&](auto rep, const char* letter) {
      for (int k = 0; k <= 3; ++k) {
        std::vector<TwistRate<decltype(rep)>> V;
        for (int i = 1; i <= at.model.n_bodies(); ++i)
          V.push_back(motion.twist_derivative<decltype(rep)>(at.frame(i), k));
        twist.expect_equal(entries(V), numbers(at.kinematics.at(keys[k]).at(letter)));
      }
    });
  });
}

/// Returns the columns of the pairs (body, joint) that the file lists. Expects that all other columns are
/// zero.
template <class Column>
std::vector<double> listed_columns(const ReferenceState& at,
                                   const std::vector<std::vector<Column>>& J_of_bodies) {
  std::vector<std::vector<double>> others;  // ordered by body and then by joint of the file
  for (const auto& J : J_of_bodies)
    for (std::size_t j = 1; j <= at.n(); ++j) others.push_back(entries(J[at.place[j]]));
  std::vector<double> listed;
  for (const Json& pair : at.kinematics.at("pairs")) {
    const std::size_t i = pair.at(0), j = pair.at(1);
    std::vector<double>& column = others[(i - 1) * at.n() + j - 1];
    listed.insert(listed.end(), column.begin(), column.end());
    column.assign(6, 0.0);
  }
  EXPECT_EQ(largest(entries(others)), 0) << "columns that are not listed are zero";
  return listed;
}

TEST_P(KinematicsOfReferenceSystems, Jacobians) {
  Comparison column("J", bound);
  each_state_with("J", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      std::vector<std::vector<Twist<Rep>>> J(at.n(), std::vector<Twist<Rep>>(at.n()));
      for (int i = 1; i <= at.model.n_bodies(); ++i)
        jacobian<Rep>(at.model, at.workspace, at.q, at.frame(i), J[i - 1]);
      column.expect_equal(listed_columns(at, J), numbers(at.kinematics.at("J").at(letter)));
    });
  });
}

TEST_P(KinematicsOfReferenceSystems, TimeDerivativesOfJacobians) {
  const char* const keys[] = {"J", "Jdot", "Jddot"};
  Comparison column("J", bound);
  each_state_with("Jddot", [&](ReferenceState& at) {
    HigherOrderMotion<> motion(at.model, 3);
    motion.evaluate(at.q, at.rates);
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      for (int k = 0; k <= 2; ++k) {
        std::vector<std::vector<TwistRate<Rep>>> J(at.n(), std::vector<TwistRate<Rep>>(at.n()));
        for (int i = 1; i <= at.model.n_bodies(); ++i)
          motion.jacobian_derivative<Rep>(at.frame(i), k, J[i - 1]);
        column.expect_equal(listed_columns(at, J), numbers(at.kinematics.at(keys[k]).at(letter)));
      }
    });
  });
}

/// J̇ is the derivative of J along v, D_v J. J̈ is D_v D_v J + D_v̇ J.
TEST_P(KinematicsOfReferenceSystems, TimeDerivativesOfJacobiansAlongVelocities) {
  Comparison dJ("Jdot", bound), ddJ("Jddot", bound);
  each_state_with("Jddot", [&](ReferenceState& at) {
    std::vector<double> v = at.rate(0), a = at.rate(1), v_v = v;
    v_v.insert(v_v.end(), v.begin(), v.end());
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      std::vector<std::vector<Twist<Rep>>> J_1(at.n(), std::vector<Twist<Rep>>(at.n())), J_2 = J_1;
      for (int i = 1; i <= at.model.n_bodies(); ++i) {
        std::vector<Twist<Rep>> D_a(at.n());
        jacobian_derivative_along<Rep>(at.model, at.workspace, at.q, at.frame(i), 1, v, J_1[i - 1]);
        jacobian_derivative_along<Rep>(at.model, at.workspace, at.q, at.frame(i), 2, v_v, J_2[i - 1]);
        jacobian_derivative_along<Rep>(at.model, at.workspace, at.q, at.frame(i), 1, a, D_a);
        for (std::size_t c = 0; c < at.n(); ++c) J_2[i - 1][c] += D_a[c];
      }
      dJ.expect_equal(listed_columns(at, J_1), numbers(at.kinematics.at("Jdot").at(letter)));
      ddJ.expect_equal(listed_columns(at, J_2), numbers(at.kinematics.at("Jddot").at(letter)));
    });
  });
}

template <class Rep> std::vector<Twist<Rep>> partials(ReferenceState& at, int index, int order) {
  std::vector<Twist<Rep>> J(order == 1 ? at.n() * at.n() : at.n() * at.n() * at.n());
  jacobian_partials<Rep>(at.model, at.workspace, at.q, at.frame(index), order, J);
  return J;
}

TEST_P(KinematicsOfReferenceSystems, FirstPartialsOfJacobians) {
  Comparison partial("dJ", bound);
  each_state_with("dJ", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      std::vector<std::vector<Twist<Rep>>> dJ;
      for (int i = 1; i <= at.model.n_bodies(); ++i) dJ.push_back(partials<Rep>(at, i, 1));
      std::vector<Twist<Rep>> listed;
      for (const Json& triple : at.kinematics.at("dJ_triples")) {
        const std::size_t i = triple.at(0), j = triple.at(1), k = triple.at(2);
        Twist<Rep>& column = dJ[i - 1][at.place[k] * at.n() + at.place[j]];
        listed.push_back(column);
        column = {};
      }
      partial.expect_equal(entries(listed), numbers(at.kinematics.at("dJ").at(letter)));
      EXPECT_EQ(largest(entries(dJ)), 0) << "partials that are not listed are zero";
    });
  });
}

TEST_P(KinematicsOfReferenceSystems, SecondPartialsOfJacobians) {
  Comparison partial("ddJ", bound), along("ddJ along units", bound);
  each_state_with("ddJ", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char* letter) {
      using Rep = decltype(rep);
      std::vector<std::vector<Twist<Rep>>> ddJ;
      for (int i = 1; i <= at.model.n_bodies(); ++i) ddJ.push_back(partials<Rep>(at, i, 2));
      std::vector<Twist<Rep>> listed, contracted;
      for (const Json& quad : at.kinematics.at("ddJ_quads")) {
        const std::size_t i = quad.at(0), j = at.place[quad.at(1)], k = at.place[quad.at(2)],
                          r = at.place[quad.at(3)];
        listed.push_back(ddJ[i - 1][(k * at.n() + r) * at.n() + j]);
        std::vector<double> units(2 * at.n());
        units[r] = 1, units[at.n() + k] = 1;
        std::vector<Twist<Rep>> J(at.n());
        jacobian_derivative_along<Rep>(at.model, at.workspace, at.q, at.frame(static_cast<int>(i)), 2, units,
                                       J);
        contracted.push_back(J[j]);
      }
      partial.expect_equal(entries(listed), numbers(at.kinematics.at("ddJ").at(letter)));
      along.expect_equal(entries(contracted), numbers(at.kinematics.at("ddJ").at(letter)));
    });
  });
}

/// The entries of a matrix over the bodies, row by row, with rows and columns brought into the order of the
/// files.
std::vector<double> in_file_order(const ReferenceState& at, const Eigen::MatrixXd& M) {
  const bool square = M.cols() == M.rows();
  std::vector<double> out;
  for (Eigen::Index r = 0; r < M.rows(); ++r)
    for (Eigen::Index c = 0; c < M.cols(); ++c) {
      const auto row = 6 * (at.frame(static_cast<int>(r) / 6 + 1) - 1) + r % 6;
      const auto column = square ? 6 * (at.frame(static_cast<int>(c) / 6 + 1) - 1) + c % 6
                                 : static_cast<Eigen::Index>(at.place[static_cast<std::size_t>(c) + 1]);
      out.push_back(M(row, column));
    }
  return out;
}

TEST_P(KinematicsOfReferenceSystems, SystemMatrices) {
  Comparison matrix("system matrix", bound);
  each_state_with("system_matrices", [&](ReferenceState& at) {
    const std::vector<double> v = at.rate(0);
    const axode::SystemMatrices b = system_matrices<BodyFixed>(at.model, at.q),
                                h = system_matrices<Hybrid>(at.model, at.q);
    const SpatialFactors s = spatial_factors(at.model, at.q);
    const std::pair<const char*, Eigen::MatrixXd> matrices[] = {
        {"A_b", b.A},
        {"D_b", b.D},
        {"X_b", b.X},
        {"A_s", s.A_s},
        {"Y_s", s.Y_s},
        {"A_sb", s.A_sb},
        {"A_h", h.A},
        {"D_h", h.D},
        {"X_h", h.X},
        {"a_b", a_matrix(at.model, v)},
        {"b_b", b_matrix(at.model, system_twist<BodyFixed>(at.model, at.q, v))},
        {"b_s", b_matrix(at.model, system_twist<Spatial>(at.model, at.q, v))}};
    EXPECT_EQ(at.kinematics.at("system_matrices").size(), std::size(matrices));
    for (const auto& [key, value] : matrices) {
      SCOPED_TRACE(key);
      matrix.expect_equal(in_file_order(at, value), numbers(at.kinematics.at("system_matrices").at(key)));
    }
  });
}

TEST_P(KinematicsOfReferenceSystems, VelocitiesAndAccelerationsAreRecoveredFromTheBodies) {
  Comparison velocity("qd", 1e-11), acceleration("qdd", 1e-11);  // the library solves normal equations for
                                                                 // these
  each_state_with("Vdot", [&](ReferenceState& at) {
    each_representation([&](auto rep, const char* letter) {
      const auto in_model_order = [&](const char* key) {
        const std::vector<double> V = numbers(at.kinematics.at(key).at(letter));
        Eigen::VectorXd out(static_cast<Eigen::Index>(V.size()));
        for (std::size_t k = 0; k < V.size(); ++k)
          out[6 * (at.frame(static_cast<int>(k) / 6 + 1) - 1) + static_cast<Eigen::Index>(k) % 6] = V[k];
        return out;
      };
      const Eigen::VectorXd V = in_model_order("V"), dV = in_model_order("Vdot");
      const std::vector<double> v = at.rate(0), a = at.rate(1);
      velocity.expect_equal(joint_velocities<decltype(rep)>(at.model, at.q, V),
                            Eigen::VectorXd(as_eigen(std::span(v))));
      acceleration.expect_equal(joint_accelerations<decltype(rep)>(at.model, at.q, V, dV),
                                Eigen::VectorXd(as_eigen(std::span(a))));
    });
  });
}

}  // namespace
}  // namespace axode::test
