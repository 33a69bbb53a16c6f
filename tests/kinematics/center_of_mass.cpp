#include "tests/kinematics/derivatives.hpp"

/// The centre of mass, its motion, and the momentum about it.
namespace axode::test {
namespace {

using S = Taylor<double, 2>;

class CenterOfMass : public Law {};
INSTANTIATE_TEST_SUITE_P(Kinematics, CenterOfMass, testing::ValuesIn(scalars()), name_of);

const TreeRecipe trees_with_mass{.most_bodies = 20, .always_mass = true};

/// The mean of the centres of mass of the bodies, weighted with their masses, from their frames.
Vec3<S> mean_position(const Model& model, const std::vector<SE3<S>>& frames) {
  Vec3<S> h;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Inertia<S> M = axode::cast<S>(model.body(i).M);
    h += M.m * frames[static_cast<std::size_t>(i)].r + frames[static_cast<std::size_t>(i)].R * M.h;
  }
  return S(1 / model.total_mass()) * h;
}

/// The total momentum Σ M_i V_i of all bodies, with moments about the centre of mass.
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

/// A random tree in motion, as series in time.
struct MovingTree {
  Trial trial;
  Tree<S> tree;
  std::vector<S> q;

  MovingTree(const Case& c, std::uint64_t seed)
      : trial(c, seed, trees_with_mass),
        tree(on<S>(trial.model)),
        q(moving<2>(tree, trial.state.q, trial.state.v, trial.zero())) {}
  int nv() const { return trial.model.nv(); }
  /// The momentum if velocity c is 1 and all others are 0.
  Momentum<Hybrid, S> momentum(int c) const {
    return momentum_about_com(trial.model, tree, q, on<S>(unit(nv(), c)));
  }
};

TEST_P(CenterOfMass, IsTheMeanOfTheMatterWeightedByMass) {
  Comparison position("position", GetParam().agreement());
  for_seeds(500, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Mechanism drawn = random_mechanism(random, {.couplings = false});
    Trial trial(GetParam(), ModelBuilder(described(drawn, random)).build(), random);
    const std::vector<SE3<>> C = trial.poses();
    double mass = 0, reach = 0;
    Vec3<> h;
    for (const DrawnBody& body : drawn.bodies) {
      const int frame = trial.model.frame_index(body.name);
      if (!body.matter || trial.model.frame(frame).body == 0)
        continue;  // bodies that are fixed to the ground do not move
      const double m = body.matter->mass;
      const Vec3<> c = C[static_cast<std::size_t>(frame)] * (inverse(body.A) * body.matter->com);
      mass += m, h += m * c, reach = std::max(reach, norm(c));
    }
    if (mass > 0) position.expect_equal(vectors_of(trial.call("center_of_mass"))[0], (1 / mass) * h, reach);
  });
}

TEST_P(CenterOfMass, JacobianColumnsArePartialDerivatives) {
  Comparison column("column", GetParam().agreement());
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree at(GetParam(), seed);
    Trial& trial = at.trial;
    std::vector<Vec3<>> expected;
    for (int c = 0; c < at.nv(); ++c) {
      const std::vector<S> q = moving<2>(at.tree, trial.state.q, unit(at.nv(), c), trial.zero());
      expected.push_back(time_derivative(mean_position(trial.model, frame_poses(at.tree, q)), 1));
    }
    column.expect_equal(vectors_of(trial.call("center_of_mass_jacobian")), expected);
  });
}

TEST_P(CenterOfMass, MomentumMatrixHasTheMomentaOfUnitVelocities) {
  Comparison column("column", GetParam().agreement()), linear("linear", GetParam().agreement());
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree at(GetParam(), seed);
    const std::vector<Six> A = sixes_of(at.trial.call("centroidal_momentum_matrix"));
    const std::vector<Vec3<>> J = vectors_of(at.trial.call("center_of_mass_jacobian"));
    std::vector<Six> expected;
    std::vector<Vec3<>> p, m_J;
    for (int c = 0; c < at.nv(); ++c) {
      expected.push_back(six(time_derivative(at.momentum(c), 0)));
      p.push_back(A[static_cast<std::size_t>(c)].b);
      m_J.push_back(at.trial.model.total_mass() * J[static_cast<std::size_t>(c)]);
    }
    column.expect_equal(A, expected);
    linear.expect_equal(p, m_J);
  });
}

TEST_P(CenterOfMass, MomentumMatrixRateIsItsTimeDerivative) {
  Comparison column("column", GetParam().agreement());
  for_seeds(60, [&](std::uint64_t seed) {
    MovingTree at(GetParam(), seed);
    std::vector<Six> expected;
    for (int c = 0; c < at.nv(); ++c) expected.push_back(six(time_derivative(at.momentum(c), 1)));
    column.expect_equal(sixes_of(at.trial.call("centroidal_momentum_matrix_rate")), expected, 1);
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
  const auto message = [](const auto& f) -> std::string {
    try {
      f();
    } catch (const std::domain_error& error) {
      return error.what();
    }
    return "";
  };
  const std::string no_mass = "model \"ghost\" has no mass that moves, so no centre of mass";
  EXPECT_EQ(message([&] { center_of_mass(model, workspace, q); }), no_mass);
  EXPECT_EQ(message([&] { center_of_mass_jacobian(model, workspace, q, J); }), no_mass);
  EXPECT_EQ(message([&] { centroidal_momentum_matrix(model, workspace, q, A); }), no_mass);
  EXPECT_EQ(message([&] { centroidal_momentum_matrix_rate(model, workspace, q, v, dA); }), no_mass);
}

}  // namespace
}  // namespace axode::test
