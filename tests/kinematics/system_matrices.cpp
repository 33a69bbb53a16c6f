#include "axode/kinematics/system_matrices.hpp"

#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// The kinematics of the whole system as matrices: factorisations, and what they are good for backwards.
namespace axode::test {
namespace {

template <class R> class System : public testing::Test {};
TYPED_TEST_SUITE(System, Representations, RepresentationNames);

const TreeRecipe trees{.most_bodies = 15};
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

Trial<double> random_trial(std::uint64_t seed) { return Trial<double>{Random<double>(seed), trees}; }

Vector vector(const std::vector<double>& x) { return as_eigen(std::span(x)); }

/// Quantities of the bodies 1..n, one below the other.
template <class Quantity> Vector stacked(const Model& model, const std::vector<Quantity>& frames) {
  Vector out(6 * model.n_bodies());
  for (int i = 1; i <= model.n_bodies(); ++i) out.segment<6>(6 * (i - 1)) = to_eigen(frames[i]);
  return out;
}
/// The Jacobians of the bodies 1..n, one below the other.
template <class Rep> Matrix stacked_jacobian(Trial<double>& trial) {
  Matrix out(6 * trial.model.n_bodies(), trial.model.nv());
  std::vector<Twist<Rep>> J(static_cast<std::size_t>(trial.model.nv()));
  for (int i = 1; i <= trial.model.n_bodies(); ++i) {
    jacobian<Rep>(trial.model, trial.workspace, trial.state.q, i, J);
    for (int c = 0; c < trial.model.nv(); ++c) out.block<6, 1>(6 * (i - 1), c) = to_eigen(J[c]);
  }
  return out;
}
Matrix identity(const Model& model) { return Matrix::Identity(6 * model.n_bodies(), 6 * model.n_bodies()); }

bool is_ancestor_or_self(const Model& model, int j, int i) {
  while (i > j) i = model.body(i).predecessor;
  return i == j;
}

TYPED_TEST(System, JacobianIsTheProductOfItsFactors) {
  using Rep = TypeParam;
  Comparison jacobian_of("J", agreement<double>), twist("V", agreement<double>),
      inverse("(I - D) A", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    const SystemMatrices system = system_matrices<Rep>(model, trial.state.q);
    inverse.expect_equal(Matrix((identity(model) - Matrix(system.D)) * Matrix(system.A)), identity(model));
    jacobian_of.expect_equal(Matrix(system.A * system.X), stacked_jacobian<Rep>(trial));
    const Vector V = stacked(model, trial.template twists<Rep>());
    twist.expect_equal(Vector(system.A * (system.X * vector(trial.state.v))), V);
    twist.expect_equal(system_twist<Rep>(model, trial.state.q, trial.state.v), V);
  });
}

TYPED_TEST(System, BlocksLieOnThePathsOnly) {
  using Rep = TypeParam;
  for_seeds(30, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    const SystemMatrices system = system_matrices<Rep>(model, trial.state.q);
    const Matrix A = system.A, D = system.D;
    for (int i = 1; i <= model.n_bodies(); ++i)
      for (int j = 1; j <= model.n_bodies(); ++j) {
        const auto block = [&](const Matrix& M) {
          return M.block<6, 6>(6 * (i - 1), 6 * (j - 1)).cwiseAbs().maxCoeff();
        };
        EXPECT_EQ(block(A) == 0, !is_ancestor_or_self(model, j, i));
        EXPECT_EQ(block(D) == 0, model.body(i).predecessor != j);
      }
    EXPECT_LE(system.D.nonZeros(), 36 * model.n_bodies()) << "stored";
    EXPECT_LE(system.X.nonZeros(), 6 * model.n_screws()) << "stored";
  });
}

TYPED_TEST(System, VelocitiesAndAccelerationsAreRecoveredFromTheMotionOfTheBodies) {
  using Rep = TypeParam;
  Comparison velocity("v", 1e-10), acceleration("a", 1e-10), rate("dV", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    const auto& [q, v, a, wrenches] = trial.state;
    const Vector V = system_twist<Rep>(model, q, v), dV = system_acceleration<Rep>(model, q, v, a);
    rate.expect_equal(dV, stacked(model, trial.template accelerations<Rep>()));
    velocity.expect_equal(joint_velocities<Rep>(model, q, V), vector(v));
    acceleration.expect_equal(joint_accelerations<Rep>(model, q, V, dV), vector(a));
  });
}

/// Twists that no velocities make: the residual X v - (I - D) V is orthogonal to every joint screw.
TYPED_TEST(System, VelocitiesOfImpossibleTwistsLeaveTheLeastResidual) {
  using Rep = TypeParam;
  Comparison normal("normal equations", 1e-10);
  for_seeds(50, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    Random<double> random(seed);
    const Vector V = vector(random_numbers(random, 6 * model.n_bodies()));
    const SystemMatrices system = system_matrices<Rep>(model, trial.state.q);
    const Matrix X = system.X;
    const Vector right = V - system.D * V;
    normal.expect_equal(Vector(X.transpose() * (X * joint_velocities<Rep>(model, trial.state.q, V))),
                        Vector(X.transpose() * right));
  });
}

/// J^b' = -A a D J, which is -A a J (eq. u:Jb_dot matrix) where every joint has one degree of freedom, and
/// V' = J a - A a V (eq. VbdotMat).
TEST(BodyFixedSystem, JacobianChangesByTheMatrixOfJointTwists) {
  Comparison rate("rate", agreement<double>), acceleration("acceleration", agreement<double>);
  int singles = 0;
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    const auto& [q, v, a, wrenches] = trial.state;
    const SystemMatrices system = system_matrices<BodyFixed>(model, q);
    const Matrix J = system.A * system.X, a_b = a_matrix(model, v);
    std::vector<double> rates(v);
    rates.insert(rates.end(), a.begin(), a.end());
    HigherOrderMotion<> motion(model, 1);
    motion.evaluate(q, rates);
    Matrix dJ(J.rows(), J.cols());
    std::vector<TwistRate<BodyFixed>> columns(v.size());
    for (int i = 1; i <= model.n_bodies(); ++i) {
      motion.jacobian_derivative<BodyFixed>(i, 1, columns);
      for (int c = 0; c < model.nv(); ++c) dJ.block<6, 1>(6 * (i - 1), c) = to_eigen(columns[c]);
    }
    rate.expect_equal(Matrix(-(system.A * (a_b * (system.D * J)))), dJ, 1);
    const bool single = std::ranges::all_of(model.joints(), [](const Joint& joint) { return joint.nv == 1; });
    if (single) rate.expect_equal(Matrix(-(system.A * (a_b * J))), dJ, 1);
    singles += single;
    acceleration.expect_equal(Vector(J * vector(a) - system.A * (a_b * system_twist<BodyFixed>(model, q, v))),
                              system_acceleration<BodyFixed>(model, q, v, a));
  });
  if (std::getenv("AXODE_RANDOM_TREES") == nullptr) {
    EXPECT_GT(singles, 10);
  }
}

/// J^s = A^s Y^s = A^sb X^b (eq. JbSys) and V^s' = J^s a + L b^s diag(J_1, ..., J_n) v (eq. VsdotMat).
TEST(SpatialSystem, JacobianHasThreeFactorisations) {
  Comparison jacobian_of("J", agreement<double>), acceleration("acceleration", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<double> trial = random_trial(seed);
    const Model& model = trial.model;
    const auto& [q, v, a, wrenches] = trial.state;
    const SpatialFactors factors = spatial_factors(model, q);
    const SystemMatrices spatial = system_matrices<Spatial>(model, q),
                         body = system_matrices<BodyFixed>(model, q);
    const Matrix J = stacked_jacobian<Spatial>(trial);
    jacobian_of.expect_equal(Matrix(factors.A_s * factors.Y_s), J);
    jacobian_of.expect_equal(Matrix(factors.A_sb * body.X), J);
    const SystemMatrix b_s = b_matrix(model, system_twist<Spatial>(model, q, v));
    acceleration.expect_equal(Vector(J * vector(a) + spatial.A * (b_s * (spatial.X * vector(v)))),
                              system_acceleration<Spatial>(model, q, v, a));
  });
}

TEST(SystemErrors, NameTheArgumentAndItsSize) {
  Trial<double> trial = random_trial(2);
  const Model& model = trial.model;
  const std::vector<double>& q = trial.state.q;
  const Vector V = Vector::Zero(6 * model.n_bodies()), longer = Vector::Zero(6 * model.n_bodies() + 1);
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
