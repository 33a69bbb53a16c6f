#include "axode/derivatives.hpp"
#include "axode/derivatives/displacement/geometric_parameters.hpp"
#include "axode/dynamics/generic_dynamics.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/dual.hpp"
#include "tests/laws/law.hpp"

/// Derivatives with respect to geometric parameters equal those that the same recursions give on a tree whose
/// joints are displaced by dual numbers. Derivatives of single terms and of the motion of frames equal limits
/// of differences.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Numbers = Trial::Numbers;
using D6 = Dual<double, 6>;

class GeometryDerivatives : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, GeometryDerivatives, testing::ValuesIn(scalars()), name_of);

std::vector<D6> constant(const Numbers& x) { return {x.begin(), x.end()}; }

/// The tree with B_i replaced by B_i exp(Σ_u π_u e_u), to the first order in the parameters π_u.
Tree<D6> displaced(const Tree<double>& tree, int i) {
  Tree<D6> moved = cast<D6>(tree);
  const auto unit = [](std::size_t u) {
    D6 x(0.0);
    x.dx[u] = 1;
    return x;
  };
  const Vec3<D6> w{unit(0), unit(1), unit(2)}, v{unit(3), unit(4), unit(5)};
  const auto column = [&](const Vec3<D6>& axis) { return axis + cross(w, axis); };
  const SE3<D6> exp{{column({D6(1.0), D6(0.0), D6(0.0)}), column({D6(0.0), D6(1.0), D6(0.0)}),
                     column({D6(0.0), D6(0.0), D6(1.0)})},
                    v};
  const SE3<D6> O = cast<D6>(tree.frame_offset[static_cast<std::size_t>(i)]);
  moved.B[static_cast<std::size_t>(i)] = moved.B[static_cast<std::size_t>(i)] * O * exp * inverse(O);
  return moved;
}

/// A random tree with few bodies, a state of it and weights.
struct Displaced {
  Random<double> random;
  Trial trial;
  Ask ask;
  explicit Displaced(const Case& c, std::uint64_t seed)
      : random(seed), trial(c, seed, {.most_bodies = 12}), ask(trial.ask()) {
    ask.tau = random_numbers(random, trial.model.nv());
    ask.w = random_numbers(random, trial.model.nv());
    ask.place = static_cast<int>(random.number(0, trial.model.n_frames()));
  }
};

TEST_P(GeometryDerivatives, OfInverseDynamicsAreThoseOfDualNumbers) {
  Comparison comparison("dtau/dpi", GetParam().agreement());
  for_seeds(60, [&](std::uint64_t seed) {
    Displaced at(GetParam(), seed);
    const Model& model = at.trial.model;
    const std::size_t nv = static_cast<std::size_t>(model.nv()), n = at.trial.n_bodies();
    std::vector<AppliedWrench<D6>> wrenches;
    for (const AppliedWrench<>& W : at.ask.loads.wrenches)
      wrenches.emplace_back(W.frame, W.representation, axode::cast<D6>(W.m), axode::cast<D6>(W.f));
    const Loads<D6> loads{wrenches};
    const std::vector<D6> q = constant(at.ask.q), v = constant(at.ask.v), a = constant(at.ask.a);
    Numbers expected(nv * n * 6);
    for (std::size_t i = 1; i <= n; ++i) {
      GenericDynamics<D6> dynamics(model, displaced(model.tree<double>(), static_cast<int>(i)));
      std::vector<D6> tau(nv);
      dynamics.inverse_dynamics(q, v, a, tau, loads);
      for (std::size_t c = 0; c < nv; ++c)
        for (std::size_t u = 0; u < 6; ++u) expected[(c * n + i - 1) * 6 + u] = tau[c].dx[u];
    }
    comparison.expect_equal(at.trial.call("inverse_dynamics_geometry_derivatives", at.ask), expected,
                            std::max(largest(expected), largest(at.trial.inverse_dynamics())));
  });
}

TEST_P(GeometryDerivatives, OfForwardDynamicsAndGradientsFollowFromThem) {
  const double agreement = GetParam().agreement();
  Comparison forward("da/dpi", agreement), inverse_gradient("w dtau/dpi", agreement),
      forward_gradient("w da/dpi", agreement);
  for_seeds(60, [&](std::uint64_t seed) {
    Displaced at(GetParam(), seed);
    const Eigen::Index nv = at.trial.model.nv(), columns = at.trial.model.n_bodies() * 6;
    const auto solved = at.trial.answer("forward_dynamics", at.ask);
    if (!solved.solvability.ok()) return;
    const auto dense = [&](const Numbers& x) {
      return MatrixXd(
          Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(x.data(), nv, columns));
    };
    Ask there = at.ask;
    there.a = solved.numbers;
    const MatrixXd dtau = dense(at.trial.call("inverse_dynamics_geometry_derivatives", there)),
                   M_inverse = matrix(at.trial.model.nv(), at.trial.call("inverse_mass_matrix", at.ask)),
                   da = dense(at.trial.call("forward_dynamics_geometry_derivatives", at.ask));
    const double scale = std::max(largest_entry(MatrixXd(M_inverse.cwiseAbs() * dtau.cwiseAbs())), 1e-300);
    forward.expect_equal(da, MatrixXd(-product(M_inverse, dtau)), scale);
    const VectorXd w = vector(at.ask.w);
    inverse_gradient.expect_equal(vector(at.trial.call("inverse_dynamics_geometry_vjp", there)),
                                  VectorXd(product(MatrixXd(dtau.transpose()), w)),
                                  std::max(largest_entry(dtau), largest(at.trial.inverse_dynamics())));
    forward_gradient.expect_equal(vector(at.trial.call("forward_dynamics_geometry_vjp", at.ask)),
                                  VectorXd(product(MatrixXd(da.transpose()), w)), scale);
  });
}

TEST_P(GeometryDerivatives, OfPosesAndJacobiansAreThoseOfDualNumbers) {
  Comparison pose("pose", GetParam().agreement()), columns("Jacobian", GetParam().agreement());
  for_seeds(60, [&](std::uint64_t seed) {
    Displaced at(GetParam(), seed);
    const Model& model = at.trial.model;
    const std::size_t nv = static_cast<std::size_t>(model.nv()), n = at.trial.n_bodies();
    const std::vector<D6> q = constant(at.ask.q);
    Numbers twists(6 * n * 6), jacobian(n * 6 * nv * 6);
    for (std::size_t i = 1; i <= n; ++i) {
      const Tree<D6> tree = displaced(model.tree<double>(), static_cast<int>(i));
      const SE3<D6> C = each_body_fixed_column(
          tree, q.data(), Place<D6>(at.ask.place.frame), [&](int, int c, const Screw<D6>& X) {
            const D6 entries[]{X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z};
            for (std::size_t u = 0; u < 6; ++u)
              for (std::size_t k = 0; k < 6; ++k)
                jacobian[(((i - 1) * 6 + u) * nv + static_cast<std::size_t>(c)) * 6 + k] += entries[k].dx[u];
          });
      for (std::size_t u = 0; u < 6; ++u) {
        const auto derivative = [&](const Vec3<D6>& x) { return Vec3<>{x.x.dx[u], x.y.dx[u], x.z.dx[u]}; };
        const auto value = [](const Vec3<D6>& x) { return Vec3<>{x.x.x, x.y.x, x.z.x}; };
        const SO3<> R{value(C.R.x), value(C.R.y), value(C.R.z)};
        const Vec3<> v = transpose(R) * derivative(C.r);
        const Vec3<> w{dot(R.z, derivative(C.R.y)), dot(R.x, derivative(C.R.z)), dot(R.y, derivative(C.R.x))};
        const double entries[]{w.x, w.y, w.z, v.x, v.y, v.z};
        for (std::size_t k = 0; k < 6; ++k) twists[(k * n + i - 1) * 6 + u] = entries[k];
      }
    }
    pose.expect_equal(at.trial.call("frame_geometry_jacobian", at.ask), twists,
                      std::max(1.0, largest(twists)));
    columns.expect_equal(at.trial.call("jacobian_geometry_derivatives", at.ask), jacobian,
                         std::max(1.0, largest(jacobian)));
  });
}

TEST_P(GeometryDerivatives, TermsAddUpToThoseOfInverseDynamics) {
  Comparison by_q("by q", GetParam().agreement()), by_v("by v", GetParam().agreement()),
      energy("kinetic energy", GetParam().agreement());
  for_seeds(100, [&](std::uint64_t seed) {
    Displaced at(GetParam(), seed);
    Ask ask = at.ask;
    ask.loads.joint_losses = true;
    ask.a = at.trial.zero();
    const Eigen::Index size = static_cast<Eigen::Index>(at.trial.model.nv()) * at.trial.model.nv();
    const VectorXd whole = vector(at.trial.call("inverse_dynamics_derivatives", ask)),
                   gravity = vector(at.trial.call("gravity_derivatives", ask)),
                   coriolis = vector(at.trial.call("coriolis_derivatives", ask)),
                   loads = vector(at.trial.call("generalized_load_derivatives", ask));
    const double scale = std::max(
        {largest_entry(whole), largest_entry(gravity), largest_entry(coriolis), largest_entry(loads), 1e-3});
    by_q.expect_equal(VectorXd(gravity + coriolis.head(size) - loads.head(size)), VectorXd(whole.head(size)),
                      scale);
    by_v.expect_equal(VectorXd(coriolis.tail(size) - loads.tail(size)), VectorXd(whole.segment(size, size)),
                      scale);
    // v·(∂T/∂v) = 2 T, and ∂T/∂q_k = vᵀ (∂M/∂q_k) v / 2.
    const Numbers dT = at.trial.call("kinetic_energy_gradient", ask);
    const Numbers dM = at.trial.call("mass_matrix_partials", ask);
    const Eigen::Index nv = at.trial.model.nv();
    const VectorXd v = vector(ask.v), gradient = vector(dT);
    VectorXd expected(2 * nv);
    double size_of_T = 1e-3;
    for (Eigen::Index k = 0; k < nv; ++k) {
      const MatrixXd dM_k =
          matrix(at.trial.model.nv(), Numbers(dM.begin() + k * size, dM.begin() + (k + 1) * size));
      expected[k] = 0.5 * v.dot(dM_k * v);
      size_of_T = std::max(size_of_T, largest_entry(dM_k) * v.squaredNorm());
    }
    expected.tail(nv) = vector(at.trial.call("momenta", ask));
    energy.expect_equal(gradient, expected, std::max(size_of_T, largest_entry(VectorXd(expected.tail(nv)))));
  });
}

class MotionDerivativesOfFrames : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, MotionDerivativesOfFrames, testing::ValuesIn(cases()), name_of);

TEST_P(MotionDerivativesOfFrames, AreLimitsOfDifferences) {
  Comparison comparison("derivative", GetParam().single ? 1e-3 : 1e-8);
  for_seeds(60, [&](std::uint64_t seed) {
    Displaced at(GetParam(), seed);
    const std::size_t nv = static_cast<std::size_t>(at.trial.model.nv());
    if (nv == 0) return;
    Trial exact = at.trial.by(in_double(GetParam()));
    const Numbers all = at.trial.call("motion_derivatives", at.ask);
    const Numbers direction = random_numbers(at.random, at.trial.model.nv());
    const auto along = [&](std::size_t block) {
      VectorXd sum = VectorXd::Zero(6);
      for (std::size_t c = 0; c < nv; ++c)
        sum += direction[c] * Eigen::Map<const VectorXd>(all.data() + (block * nv + c) * 6, 6);
      return sum;
    };
    const auto difference = [&](const char* function, bool by_q) {
      const double h = 1e-4;
      const auto moved = [&](double eps) {
        Ask ask = at.ask;
        const VectorXd step = eps * vector(direction);
        if (by_q)
          ask.q = integrate(at.trial.model, at.ask.q, numbers(step));
        else
          ask.v = numbers(vector(at.ask.v) + step);
        return VectorXd(vector(exact.call(function, ask)).segment(at.ask.place.frame * 6, 6));
      };
      return VectorXd((8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h));
    };
    const double scale = std::max({1.0, largest(exact.call("accelerations", at.ask)), largest(all)});
    comparison.expect_equal(along(0), difference("twists", true), scale);
    comparison.expect_equal(along(1), difference("twists", false), scale);
    comparison.expect_equal(along(2), difference("accelerations", true), scale);
    comparison.expect_equal(along(3), difference("accelerations", false), scale);
  });
}

}  // namespace
}  // namespace axode::test
