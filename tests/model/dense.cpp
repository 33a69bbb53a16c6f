#include "axode/dense.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/lie/relative_error.hpp"
#include "tests/support/random_tree.hpp"

/// The functions that take Eigen's vectors and return its matrices. They take frames by name, and several
/// frames at once.
namespace axode::test {
namespace {

class Dense : public testing::Test {
 protected:
  Random<double> random{11};
  Model model = ModelBuilder(described(random_mechanism(random, {.most_bodies = 15}), random)).build();
  State<double> state = random_state(model, random);
  Workspace<double> workspace{model};
  Eigen::VectorXd q = as_eigen(std::span<const double>(state.q)),
                  v = as_eigen(std::span<const double>(state.v)),
                  a = as_eigen(std::span<const double>(state.a));
  int last = model.n_frames() - 1;
  std::string name = model.frame(last).name;
};

TEST_F(Dense, EigenVectorsAreTakenAsTheyAre) {
  std::vector<double> tau(model.nv());
  inverse_dynamics(model, workspace, state.q, state.v, state.a, tau);
  Eigen::VectorXd same(model.nv());
  inverse_dynamics(model, workspace, q, v, a, as_span(same));
  EXPECT_EQ(same, as_eigen(std::span<const double>(tau)));
  EXPECT_EQ(inverse_dynamics(model, workspace, q, v, a), same);
  EXPECT_EQ(inverse_dynamics<Hybrid>(model, workspace, q.head(model.nq()), v, a).size(), model.nv());
}

template <class Rep> void expect_same_jacobian(const Model& model, const std::vector<double>& q) {
  Workspace<double> workspace(model);
  const int f = model.n_frames() - 1;
  std::vector<Twist<Rep>> columns(model.nv());
  jacobian<Rep>(model, workspace, q, f, columns);
  const Matrix6X<double> J = jacobian<Rep>(model, workspace, q, model.frame(f).name);
  for (int c = 0; c < model.nv(); ++c) EXPECT_EQ(J.col(c), to_eigen(columns[c]));
  std::vector<Twist<Rep>> relative(model.nv());
  relative_jacobian<Rep>(model, workspace, q, f, 1, relative);
  const Matrix6X<double> J_1 =
      relative_jacobian<Rep>(model, workspace, q, model.frame(f).name, model.frame(1).name);
  for (int c = 0; c < model.nv(); ++c) EXPECT_EQ(J_1.col(c), to_eigen(relative[c]));
}

TEST_F(Dense, JacobiansAreMatricesInEveryRepresentation) {
  expect_same_jacobian<BodyFixed>(model, state.q);
  expect_same_jacobian<Spatial>(model, state.q);
  expect_same_jacobian<Hybrid>(model, state.q);
  expect_same_jacobian<Mixed>(model, state.q);
}

TEST_F(Dense, MatricesAreNotOnTheirSide) {
  const Eigen::MatrixXd M = mass_matrix(model, workspace, q);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model.nv());
  const Eigen::VectorXd difference =
      inverse_dynamics(model, workspace, q, v, a) - inverse_dynamics(model, workspace, q, v, zero);
  EXPECT_LE((M * a - difference).norm(), 1e-10 * difference.norm());
  Description bare = model.description();
  for (BodyDescription& body : bare.bodies)
    for (Dof& dof : body.joint.dof) dof.armature = 0;
  const Model without = ModelBuilder(bare).build();
  Workspace<double> own(without);
  const Eigen::MatrixXd Y = regressor(without, own, q, v, a);
  const std::vector<double> pi = inertial_parameters(without);
  const Eigen::VectorXd tau = inverse_dynamics(without, own, q, v, a);
  EXPECT_LE((Y * as_eigen(std::span<const double>(pi)) - tau).norm(), 1e-10 * tau.norm());
}

TEST_F(Dense, SeveralPlacesInOneCall) {
  const std::array<Place<>, 3> places{Place<>(name), Place<>(1, Vec3<>{0.1, 0.2, 0.3}), Place<>(0)};
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  const Eigen::MatrixXd J = jacobians<Spatial>(model, workspace, q, places);
  std::vector<Twist<Spatial>> columns(3 * nv);
  jacobians<Spatial>(model, workspace, q, places, columns);
  std::vector<SE3<>> all(model.n_frames()), C(3);
  poses(model, workspace, q, all);
  poses(model, workspace, q, places, C);
  EXPECT_EQ(distance(C[0], all[last]), 0);
  EXPECT_LT(distance(C[1], all[1] * places[1].offset),
            1e-15);  // the product may be made by other instructions
  for (std::size_t k = 0; k < 3; ++k) {
    const Matrix6X<double> alone = jacobian<Spatial>(model, workspace, q, places[k]);
    const auto together = J.middleRows<6>(6 * static_cast<int>(k));
    EXPECT_LE((together - alone).norm(), 1e-14 * J.norm());
    for (std::size_t c = 0; c < nv; ++c)
      EXPECT_EQ(to_eigen(columns[k * nv + c]), together.col(static_cast<int>(c)));
  }
}

TEST_F(Dense, UnknownNamesAndWrongSizesAreNamed) {
  const auto refuses = [](const std::string& part) {
    return testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(part));
  };
  EXPECT_THAT([&] { jacobian(model, workspace, q, "nowhere at all"); },
              refuses("has no frame \"nowhere at all\""));
  EXPECT_THAT([&] { jacobian(model, workspace, q.head(1), name); }, refuses("q has 1 entries"));
  std::vector<SE3<>> C(1);
  const std::array<Place<>, 2> places{0, "nobody"};
  EXPECT_THAT([&] { poses(model, workspace, q, places, C); }, refuses("C has 1 entries"));
  C.resize(2);
  EXPECT_THAT([&] { poses(model, workspace, q, places, C); }, refuses("has no frame \"nobody\""));
}

TEST_F(Dense, PlacesByNameReachEveryFunctionOfAPlace) {
  std::vector<Twist<BodyFixed>> by_number(model.nv()), by_name(model.nv());
  const auto expect_same = [&] {
    for (int c = 0; c < model.nv(); ++c) EXPECT_EQ(to_eigen(by_name[c]), to_eigen(by_number[c]));
  };
  jacobian_derivative_along(model, workspace, q, last, 1, v, by_number);
  jacobian_derivative_along(model, workspace, q, name, 1, v, by_name);
  expect_same();
  jacobian_partials(model, workspace, q, last, 0, by_number);
  jacobian_partials(model, workspace, q, name, 0, by_name);
  expect_same();
  EXPECT_EQ(impulse_response(model, workspace, q, last, by_number).ok(),
            impulse_response(model, workspace, q, name, by_name).ok());
  HigherOrderMotion<> motion(model, 0);
  motion.evaluate(q, v);
  EXPECT_EQ(to_eigen(motion.twist_derivative(name, 0)), to_eigen(motion.twist_derivative(last, 0)));
  const std::array<PoseTarget, 1> number{{{.place = last}}}, names{{{.place = name}}};
  EXPECT_EQ(inverse_kinematics(model, names, state.q, {.iterations = 2, .restarts = 0}).q,
            inverse_kinematics(model, number, state.q, {.iterations = 2, .restarts = 0}).q);
}

}  // namespace
}  // namespace axode::test
