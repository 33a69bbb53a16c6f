#include "tests/kinematics/derivatives.hpp"

/// The centre of mass, how it moves, and the momentum about it.
namespace axode::test {
namespace {

template <class T> class CenterOfMass : public testing::Test {};
using Scalars = testing::Types<double, float>;
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};
TYPED_TEST_SUITE(CenterOfMass, Scalars, ScalarNames);

const TreeRecipe trees{.most_bodies = 20, .always_mass = true};

/// Mass-weighted mean of the bodies' centres of mass, in the frames that the user placed.
template <class S> Vec3<S> mean_position(const Model& model, const std::vector<SE3<S>>& frames) {
  Vec3<S> h;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Inertia<S> M = axode::cast<S>(model.body(i).M);
    h += M.m * frames[static_cast<std::size_t>(i)].r + frames[static_cast<std::size_t>(i)].R * M.h;
  }
  return S(1 / model.total_mass()) * h;
}

/// Σ M_i V_i of all bodies, with moments about the centre of mass.
template <class S>
Momentum<Hybrid, S> momentum_about_com(const Model& model, const Tree<S>& tree, const std::vector<S>& q,
                                       const std::vector<S>& v) {
  const std::vector<SE3<S>> C = frame_poses(tree, q);
  const std::vector<Twist<BodyFixed, S>> V = frame_twists<BodyFixed>(tree, q, v);
  const Vec3<S> c = mean_position(model, C);
  Momentum<Spatial, S> sum;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    SE3<S> from_com = C[static_cast<std::size_t>(i)];
    from_com.r -= c;
    sum += change<Spatial>(from_com, axode::cast<S>(model.body(i).M) * V[static_cast<std::size_t>(i)]);
  }
  return {sum.l, sum.p};
}

/// A random tree that moves, as series in time.
template <class T> struct MovingTree {
  using S = Taylor<T, 2>;
  Trial<T> trial;
  Tree<S> tree;
  std::vector<S> q;

  explicit MovingTree(std::uint64_t seed)
      : trial(Random<double>(seed), trees),
        tree(axode::cast<S>(trial.model.template tree<T>())),
        q(moving<2>(tree, trial.state.q, trial.state.v, trial.zero())) {}
  int nv() const { return trial.model.nv(); }
  std::vector<S> unit_velocity(int c) const { return on<S>(unit(nv(), c)); }
};

TYPED_TEST(CenterOfMass, MovesWithItsJacobianTimesTheVelocities) {
  using T = TypeParam;
  Comparison velocity("velocity", agreement<T>);
  for_seeds(200, [&](std::uint64_t seed) {
    MovingTree<T> at(seed);
    Trial<T>& trial = at.trial;
    std::vector<Vec3<T>> J(static_cast<std::size_t>(at.nv()));
    center_of_mass_jacobian(trial.model, trial.workspace, trial.state.q, J);
    Vec3<T> dc;
    for (int c = 0; c < at.nv(); ++c) dc += trial.state.v[c] * J[c];
    velocity.expect_equal(dc, time_derivative(mean_position(trial.model, frame_poses(at.tree, at.q)), 1),
                          0.1);
  });
}

TYPED_TEST(CenterOfMass, JacobianColumnsArePartialDerivatives) {
  using T = TypeParam;
  using S = Taylor<T, 2>;
  Comparison column("column", agreement<T>);
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree<T> at(seed);
    Trial<T>& trial = at.trial;
    std::vector<Vec3<T>> J(static_cast<std::size_t>(at.nv())), expected;
    center_of_mass_jacobian(trial.model, trial.workspace, trial.state.q, J);
    for (int c = 0; c < at.nv(); ++c) {
      std::vector<T> e = trial.zero();
      e[c] = T(1);
      const std::vector<S> q = moving<2>(at.tree, trial.state.q, e, trial.zero());
      expected.push_back(time_derivative(mean_position(trial.model, frame_poses(at.tree, q)), 1));
    }
    column.expect_equal(J, expected);
  });
}

TYPED_TEST(CenterOfMass, MomentumMatrixHasTheMomentaOfUnitVelocities) {
  using T = TypeParam;
  Comparison column("column", agreement<T>), linear("linear", agreement<T>);
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree<T> at(seed);
    Trial<T>& trial = at.trial;
    std::vector<Momentum<Hybrid, T>> A(static_cast<std::size_t>(at.nv())), expected;
    std::vector<Vec3<T>> J(A.size()), p, m_J;
    centroidal_momentum_matrix(trial.model, trial.workspace, trial.state.q, A);
    center_of_mass_jacobian(trial.model, trial.workspace, trial.state.q, J);
    for (int c = 0; c < at.nv(); ++c) {
      const auto Pi = momentum_about_com(trial.model, at.tree, at.q, at.unit_velocity(c));
      expected.push_back(time_derivative(Pi, 0));
      p.push_back(A[c].p);
      m_J.push_back(static_cast<T>(trial.model.total_mass()) * J[c]);
    }
    column.expect_equal(A, expected);
    linear.expect_equal(p, m_J);
  });
}

TYPED_TEST(CenterOfMass, MomentumMatrixRateIsItsTimeDerivative) {
  using T = TypeParam;
  Comparison column("column", agreement<T>);
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree<T> at(seed);
    Trial<T>& trial = at.trial;
    std::vector<Wrench<Hybrid, T>> dA(static_cast<std::size_t>(at.nv())), expected;
    centroidal_momentum_matrix_rate(trial.model, trial.workspace, trial.state.q, trial.state.v, dA);
    for (int c = 0; c < at.nv(); ++c) {
      const auto dPi =
          time_derivative(momentum_about_com(trial.model, at.tree, at.q, at.unit_velocity(c)), 1);
      expected.push_back({dPi.l, dPi.p});
    }
    column.expect_equal(dA, expected, 1);
  });
}

TEST(CenterOfMassErrors, AMasslessModelIsNamed) {
  const Model model =
      ModelBuilder("ghost").add({.name = "link", .joint = {.kind = JointKind::revolute}}).build();
  Workspace<> workspace(model);
  const std::vector<double> q(1), v(1);
  std::vector<Vec3<>> J(1);
  std::vector<Momentum<Hybrid>> A(1);
  std::vector<Wrench<Hybrid>> dA(1);
  EXPECT_THROW(center_of_mass(model, workspace, q), std::domain_error);
  EXPECT_THROW(center_of_mass_jacobian(model, workspace, q, J), std::domain_error);
  EXPECT_THROW(centroidal_momentum_matrix_rate(model, workspace, q, v, dA), std::domain_error);
  try {
    centroidal_momentum_matrix(model, workspace, q, A);
    FAIL() << "no error";
  } catch (const std::domain_error& error) {
    EXPECT_STREQ(error.what(), "model \"ghost\" has no mass that moves, so no centre of mass");
  }
}

}  // namespace
}  // namespace axode::test
