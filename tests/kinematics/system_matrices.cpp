#include "axode/kinematics/system_matrices.hpp"

#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// The kinematics of the whole system as matrices: factorisations of the Jacobian, and velocities from
/// twists.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

const TreeRecipe medium_trees{.most_bodies = 15};

/// The matrices of the library in a representation, as dense matrices.
struct DenseSystem {
  MatrixXd A, D, X;
  Eigen::Index stored_in_D, stored_in_X;
};
DenseSystem system_matrices_in(Representation in, const Model& model, const std::vector<double>& q) {
  const auto [A, D, X] =
      with_representation(in, [&](auto rep) { return system_matrices<decltype(rep)>(model, q); });
  return {A, D, X, D.nonZeros(), X.nonZeros()};
}
VectorXd system_twist_in(Representation in, const Model& model, const State<double>& at) {
  return with_representation(in, [&](auto rep) { return system_twist<decltype(rep)>(model, at.q, at.v); });
}
VectorXd system_acceleration_in(Representation in, const Model& model, const State<double>& at) {
  return with_representation(
      in, [&](auto rep) { return system_acceleration<decltype(rep)>(model, at.q, at.v, at.a); });
}
VectorXd joint_velocities_in(Representation in, const Model& model, const std::vector<double>& q,
                             const VectorXd& V) {
  return with_representation(in, [&](auto rep) { return joint_velocities<decltype(rep)>(model, q, V); });
}
VectorXd joint_accelerations_in(Representation in, const Model& model, const std::vector<double>& q,
                                const VectorXd& V, const VectorXd& dV) {
  return with_representation(in,
                             [&](auto rep) { return joint_accelerations<decltype(rep)>(model, q, V, dV); });
}

Trial random_trial(const Case& c, std::uint64_t seed) { return {c, seed, medium_trees}; }

/// Quantities of the bodies 1..n, one below the other.
VectorXd stacked(const Model& model, const std::vector<Six>& frames) {
  return vector(entries(std::vector<Six>(frames.begin() + 1, frames.begin() + 1 + model.n_bodies())));
}
/// The Jacobians of the bodies 1..n, one below the other.
MatrixXd stacked_jacobian(Trial& trial) {
  MatrixXd out(6 * trial.model.n_bodies(), trial.model.nv());
  Ask ask = trial.ask();
  for (int i = 1; i <= trial.model.n_bodies(); ++i) {
    ask.place = i;
    out.middleRows(6 * (i - 1), 6) = matrix(trial.model.nv(), trial.call("jacobian", ask)).transpose();
  }
  return out;
}
MatrixXd identity(const Model& model) {
  return MatrixXd::Identity(6 * model.n_bodies(), 6 * model.n_bodies());
}

class System : public Law {
 protected:
  const Representation in = GetParam().representation;
};
INSTANTIATE_TEST_SUITE_P(Kinematics, System, representations_in_double(), name_of);

bool is_ancestor_or_self(const Model& model, int j, int i) {
  while (i > j) i = model.body(i).predecessor;
  return i == j;
}

TEST_P(System, JacobianIsTheProductOfItsFactors) {
  Comparison jacobian_of("J", agreement<double>), twist("V", agreement<double>),
      inverse("(I - D) A", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial = random_trial(GetParam(), seed);
    const Model& model = trial.model;
    const auto [A, D, X, stored_in_D, stored_in_X] = system_matrices_in(in, model, trial.state.q);
    inverse.expect_equal(product(identity(model) - D, A), identity(model));
    jacobian_of.expect_equal(product(A, X), stacked_jacobian(trial));
    const VectorXd V = stacked(model, trial.twists());
    twist.expect_equal(product(A, product(X, vector(trial.state.v))), V);
    twist.expect_equal(system_twist_in(in, model, trial.state), V);
  });
}

TEST_P(System, BlocksLieOnThePathsOnly) {
  for_seeds(30, [&](std::uint64_t seed) {
    const Trial trial = random_trial(GetParam(), seed);
    const Model& model = trial.model;
    const auto [A, D, X, stored_in_D, stored_in_X] = system_matrices_in(in, model, trial.state.q);
    for (int i = 1; i <= model.n_bodies(); ++i)
      for (int j = 1; j <= model.n_bodies(); ++j) {
        const auto block = [&](const MatrixXd& M) {
          return largest_entry(M.block<6, 6>(6 * (i - 1), 6 * (j - 1)));
        };
        EXPECT_EQ(block(A) == 0, !is_ancestor_or_self(model, j, i));
        EXPECT_EQ(block(D) == 0, model.body(i).predecessor != j);
      }
    EXPECT_LE(stored_in_D, 36 * model.n_bodies());
    EXPECT_LE(stored_in_X, 6 * model.n_screws());
  });
}

TEST_P(System, VelocitiesAndAccelerationsAreRecoveredFromTheMotionOfTheBodies) {
  Comparison velocity("v", 1e-10), acceleration("a", 1e-10), rate("dV", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial = random_trial(GetParam(), seed);
    const Model& model = trial.model;
    const State<double>& at = trial.state;
    const VectorXd V = system_twist_in(in, model, at), dV = system_acceleration_in(in, model, at);
    rate.expect_equal(dV, stacked(model, trial.accelerations()));
    velocity.expect_equal(joint_velocities_in(in, model, at.q, V), vector(at.v));
    acceleration.expect_equal(joint_accelerations_in(in, model, at.q, V, dV), vector(at.a));
  });
}

/// For twists that no velocities cause, the residual X v - (I - D) V is orthogonal to every joint screw.
TEST_P(System, VelocitiesOfImpossibleTwistsLeaveTheLeastResidual) {
  Comparison normal("normal equations", 1e-10);
  for_seeds(50, [&](std::uint64_t seed) {
    const Trial trial = random_trial(GetParam(), seed);
    const Model& model = trial.model;
    Random<double> random(seed);
    const VectorXd V = vector(random_numbers(random, 6 * model.n_bodies()));
    const auto [A, D, X, stored_in_D, stored_in_X] = system_matrices_in(in, model, trial.state.q);
    const MatrixXd X_transposed = X.transpose();
    const VectorXd v = joint_velocities_in(in, model, trial.state.q, V);
    normal.expect_equal(product(X_transposed, product(X, v)),
                        product(X_transposed, product(identity(model) - D, V)));
  });
}

/// J̇^b = -A a D J; if every joint has one degree of freedom, this is -A a J (Müller, eq. u:Jb_dot matrix).
/// And V̇ = J a - A a V (Müller, eq. VbdotMat).
TEST(BodyFixedSystem, JacobianChangesByTheMatrixOfJointTwists) {
  Comparison rate("rate", agreement<double>), acceleration("acceleration", agreement<double>);
  int singles = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    const Trial trial = random_trial(scalars()[0], seed);
    const Model& model = trial.model;
    const State<double>& at = trial.state;
    const DenseSystem system = system_matrices_in(Representation::body, model, at.q);
    const MatrixXd J = product(system.A, system.X), a_b = a_matrix(model, at.v), A_a = product(system.A, a_b);
    std::vector<double> rates(at.v);
    rates.insert(rates.end(), at.a.begin(), at.a.end());
    HigherOrderMotion<> motion(model, 1);
    motion.evaluate(at.q, rates);
    MatrixXd dJ(J.rows(), J.cols());
    std::vector<TwistRate<BodyFixed>> columns(at.v.size());
    for (int i = 1; i <= model.n_bodies(); ++i) {
      motion.jacobian_derivative<BodyFixed>(i, 1, columns);
      for (int c = 0; c < model.nv(); ++c)
        dJ.block<6, 1>(6 * (i - 1), c) = to_eigen(columns[static_cast<std::size_t>(c)]);
    }
    rate.expect_equal(product(-A_a, product(system.D, J)), dJ, 1);
    const bool single = std::ranges::all_of(model.joints(), [](const Joint& joint) { return joint.nv == 1; });
    if (single) rate.expect_equal(product(-A_a, J), dJ, 1);
    singles += single;
    const VectorXd V = system_twist_in(Representation::body, model, at);
    acceleration.expect_equal(VectorXd(product(J, vector(at.a)) - product(A_a, V)),
                              system_acceleration_in(Representation::body, model, at));
  });
  if (std::getenv("AXODE_RANDOM_TREES") == nullptr) {
    EXPECT_GT(singles, 10);
  }
}

/// J^s = A^s Y^s = A^sb X^b (Müller, eq. JbSys) and V^s' = J^s a + L b^s diag(J_1, ..., J_n) v (Müller,
/// eq. VsdotMat).
TEST(SpatialSystem, JacobianHasThreeFactorisations) {
  Comparison jacobian_of("J", agreement<double>), acceleration("acceleration", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial = random_trial(test::in(Representation::spatial, scalars()[0]), seed);
    const Model& model = trial.model;
    const State<double>& at = trial.state;
    const SpatialFactors factors = spatial_factors(model, at.q);
    const DenseSystem spatial = system_matrices_in(Representation::spatial, model, at.q),
                      body = system_matrices_in(Representation::body, model, at.q);
    const MatrixXd J = stacked_jacobian(trial);
    jacobian_of.expect_equal(product(MatrixXd(factors.A_s), MatrixXd(factors.Y_s)), J);
    jacobian_of.expect_equal(product(MatrixXd(factors.A_sb), body.X), J);
    const MatrixXd b_s = b_matrix(model, system_twist_in(Representation::spatial, model, at));
    acceleration.expect_equal(VectorXd(product(J, vector(at.a)) +
                                       product(spatial.A, product(b_s, product(spatial.X, vector(at.v))))),
                              system_acceleration_in(Representation::spatial, model, at));
  });
}

TEST(SystemErrors, NameTheArgumentAndItsSize) {
  const Trial trial = random_trial(scalars()[0], 2);
  const Model& model = trial.model;
  const std::vector<double>& q = trial.state.q;
  const VectorXd V = VectorXd::Zero(6 * model.n_bodies()), longer = VectorXd::Zero(6 * model.n_bodies() + 1);
  const std::string expected =
      " has " + std::to_string(longer.size()) + " entries; expected 6 n_bodies = " + std::to_string(V.size());
  EXPECT_EQ(message_of([&] { joint_velocities(model, q, longer); }), "V" + expected);
  EXPECT_EQ(message_of([&] { joint_accelerations(model, q, V, longer); }), "dV" + expected);
  EXPECT_EQ(message_of([&] { b_matrix(model, longer); }), "V" + expected);
  EXPECT_EQ(message_of([&] { a_matrix(model, std::vector<double>(3 + q.size())); }).substr(0, 6), "v has ");
  EXPECT_EQ(message_of([&] { system_matrices(model, std::vector<double>(3 + q.size())); }).substr(0, 6),
            "q has ");
}

}  // namespace
}  // namespace axode::test
