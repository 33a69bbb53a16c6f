#include "axode/derivatives.hpp"
#include "axode/dynamics/generic_dynamics.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/dual.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/refused_arguments.hpp"

/// Derivatives of dynamics equal the limits of differences of the functions themselves. They also agree with
/// each other: matrices with their products with vectors, with the values, and with contracted second
/// derivatives.
namespace axode::test {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Numbers = Trial::Numbers;

class Derivatives : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, Derivatives, testing::ValuesIn(scalars()), name_of);
/// Laws that are tested in double only. In float the ill-conditioned mass matrices of random trees, or
/// differences, would leave no correct digits.
class DerivativesInDouble : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, DerivativesInDouble, testing::Values(scalars()[0]), name_of);

/// The state with losses counted, and with random forces, directions and weights.
Ask any(const Trial& trial, Random<double>& random) {
  Ask ask = trial.ask();
  ask.loads.joint_losses = true;
  for (Numbers* const x : {&ask.tau, &ask.dq, &ask.dv, &ask.da, &ask.dtau, &ask.w})
    *x = random_numbers(random, trial.model.nv());
  for (double& v : ask.v)  // friction jumps where a velocity is 0
    if (std::abs(v) < 1e-3) v = 1e-3;
  return ask;
}

/// An estimate of the size of the terms of the forces, which may cancel each other: the weight and the
/// inertia of all bodies at a distance of 1 m, and the loads.
double size_of_forces(const Trial& trial) {
  double mass = 0, loads = 0;
  for (const AppliedWrench<>& W : trial.state.wrenches) loads += norm(W.m) + norm(W.f);
  for (const Body& body : trial.model.bodies()) mass += body.M.m;
  return loads + mass * (10 + std::pow(largest(trial.state.v), 2) + largest(trial.state.a));
}

/// Matrix k of several that are stored one after the other.
MatrixXd part(const Trial& trial, const Numbers& all, std::size_t k) {
  const std::size_t size =
      static_cast<std::size_t>(trial.model.nv()) * static_cast<std::size_t>(trial.model.nv());
  return matrix(trial.model.nv(), Numbers(all.begin() + static_cast<std::ptrdiff_t>(k * size),
                                          all.begin() + static_cast<std::ptrdiff_t>((k + 1) * size)));
}
VectorXd row(const Trial& trial, const Numbers& all, std::size_t k) {
  return vector(all).segment(static_cast<Eigen::Index>(k) * trial.model.nv(), trial.model.nv());
}

/// The derivative of f along the direction (x, y, z) of q, v and a (or τ), by central differences of f at q ⊕
/// ε x, v + ε y, a + ε z.
template <class F> VectorXd difference(const Trial& trial, const Ask& at, const Ask& along, const F& f) {
  const double h = 1e-5;
  const auto moved = [&](double eps) {
    const auto plus = [&](const Numbers& x, const Numbers& dx) {
      return numbers(vector(x) + eps * vector(dx));
    };
    Ask ask = at;
    ask.q = integrate(trial.model, at.q, numbers(eps * vector(along.dq)));
    ask.v = plus(at.v, along.dv), ask.a = plus(at.a, along.da), ask.tau = plus(at.tau, along.dtau);
    return VectorXd(vector(f(ask)));
  };
  return (8 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12 * h);
}

TEST_P(Derivatives, OfInverseDynamicsAreLimitsOfDifferences) {
  Comparison direction("derivative", GetParam().single ? 1e-3 : 1e-8);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed);
    if (trial.model.nv() == 0) return;
    Trial exact = trial.by(in_double(GetParam()));
    const Ask ask = any(trial, random);
    const VectorXd jvp = vector(trial.call("inverse_dynamics_jvp", ask));
    direction.expect_equal(
        jvp, difference(trial, ask, ask, [&](const Ask& at) { return exact.call("inverse_dynamics", at); }),
        largest(exact.call("inverse_dynamics", ask)));
  });
}

using D = Dual<double, 1>;
std::vector<D> dual(const Numbers& x, const Numbers& dx) {
  std::vector<D> out(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) out[k] = D(x[k], {dx[k]});
  return out;
}
Numbers slopes(const std::vector<D>& x) {
  Numbers out;
  for (const D& entry : x) out.push_back(entry.dx[0]);
  return out;
}
/// The state as dual numbers whose dual parts are its direction, and dynamics that compute with them.
struct OnDualNumbers {
  OnDualNumbers(const Trial& trial, const Ask& ask)
      : dynamics(trial.model), q(ask.q.size()), v(dual(ask.v, ask.dv)), result(v.size()) {
    dynamics.integrate(dual(ask.q, Numbers(q.size())), dual(trial.zero(), ask.dq), q);
    for (const AppliedWrench<>& W : ask.loads.wrenches)
      wrenches.emplace_back(W.frame, W.representation, axode::cast<D>(W.m), axode::cast<D>(W.f));
  }
  GenericDynamics<D> dynamics;
  std::vector<D> q, v, result;
  std::vector<AppliedWrench<D>> wrenches;
};

TEST_P(DerivativesInDouble, OfInverseDynamicsAreThoseOfDualNumbers) {
  Comparison direction("derivative", 1e-12);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed);
    const Ask ask = any(trial, random);
    OnDualNumbers on(trial, ask);
    on.dynamics.inverse_dynamics(on.q, on.v, dual(ask.a, ask.da), on.result, {on.wrenches, true});
    direction.expect_equal(trial.call("inverse_dynamics_jvp", ask), slopes(on.result),
                           largest(trial.call("inverse_dynamics", ask)));
  });
}

TEST_P(DerivativesInDouble, OfForwardDynamicsAreThoseOfDualNumbers) {
  Comparison direction("derivative", 1e-8);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 12, .always_mass = true});
    const Ask ask = any(trial, random);
    const auto [expected, solvability] = trial.answer("forward_dynamics_jvp", ask);
    OnDualNumbers on(trial, ask);
    EXPECT_EQ(
        on.dynamics.forward_dynamics(on.q, on.v, dual(ask.tau, ask.dtau), on.result, {on.wrenches, true})
            .ok(),
        solvability.ok());
    if (solvability.ok())
      direction.expect_equal(expected, slopes(on.result), largest(trial.call("forward_dynamics", ask)));
  });
}

TEST_P(DerivativesInDouble, OfTheMassMatrixAreThoseOfDualNumbers) {
  Comparison direction("derivative", 1e-12);
  for_seeds(50, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 12});
    const Ask ask = any(trial, random);
    OnDualNumbers on(trial, ask);
    std::vector<D> M(on.v.size() * on.v.size());
    on.dynamics.mass_matrix(on.q, M);
    const Numbers partials = trial.call("mass_matrix_partials", ask);
    Numbers expected(M.size());
    for (std::size_t k = 0; k < on.v.size(); ++k)
      for (std::size_t e = 0; e < M.size(); ++e) expected[e] += partials[k * M.size() + e] * ask.dq[k];
    direction.expect_equal(slopes(M), expected, largest_entry(trial.mass_matrix()));
  });
}

TEST(GenericDynamicsOfDualNumbers, RefuseWrongSizesAndFrames) {
  Random<double> random;
  Trial trial(scalars()[0], 1);
  GenericDynamics<D> dynamics(trial.model);
  const std::vector<D> q(trial.state.q.size()), v(trial.state.v.size());
  std::vector<D> tau(v.size()), more(v.size() + 1);
  EXPECT_THROW(dynamics.inverse_dynamics(q, v, v, more), std::invalid_argument);
  EXPECT_THROW(dynamics.inverse_dynamics(q, more, v, tau), std::invalid_argument);
  EXPECT_THROW(dynamics.mass_matrix(q, more), std::invalid_argument);
  const Vec3<D> none = axode::cast<D>(Vec3<>{});
  const std::vector<AppliedWrench<D>> nowhere(1, {trial.model.n_frames(), Representation::body, none, none});
  EXPECT_THROW(dynamics.inverse_dynamics(q, v, v, tau, {nowhere}), std::invalid_argument);
}

TEST_P(Derivatives, ProductsAreMatricesTimesVectors) {
  const double agreement = GetParam().agreement();
  Comparison jvp("jvp", agreement), vjp("vjp", agreement), mass("mass matrix", agreement);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed);
    const Ask ask = any(trial, random);
    const Numbers all = trial.call("inverse_dynamics_derivatives", ask);
    const MatrixXd dq = part(trial, all, 0), dv = part(trial, all, 1), da = part(trial, all, 2);
    const double scale =
        std::max({largest_entry(dq), largest_entry(dv), largest_entry(da), size_of_forces(trial)});
    jvp.expect_equal(
        vector(trial.call("inverse_dynamics_jvp", ask)),
        VectorXd(product(dq, vector(ask.dq)) + product(dv, vector(ask.dv)) + product(da, vector(ask.da))),
        scale);
    const Numbers gradient = trial.call("inverse_dynamics_vjp", ask);
    const VectorXd w = vector(ask.w);
    vjp.expect_equal(row(trial, gradient, 0), VectorXd(product(MatrixXd(dq.transpose()), w)), scale);
    vjp.expect_equal(row(trial, gradient, 1), VectorXd(product(MatrixXd(dv.transpose()), w)), scale);
    vjp.expect_equal(row(trial, gradient, 2), VectorXd(product(MatrixXd(da.transpose()), w)), scale);
    mass.expect_equal(da, trial.mass_matrix());
  });
}

TEST_P(DerivativesInDouble, OfForwardDynamicsSolveThoseOfInverseDynamics) {
  Comparison residual("residual", 1e-9), jvp("jvp", 1e-9), vjp("vjp", 1e-9);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.always_mass = true});
    if (trial.model.nv() == 0) return;
    Ask ask = any(trial, random);
    const Answer accelerations = trial.answer("forward_dynamics", ask);
    ASSERT_TRUE(accelerations.solvability.ok());
    ask.a = accelerations.numbers;
    const Numbers inverse = trial.call("inverse_dynamics_derivatives", ask);
    const Answer forward = trial.answer("forward_dynamics_derivatives", ask);
    ASSERT_TRUE(forward.solvability.ok());
    const MatrixXd M = part(trial, inverse, 2);
    for (std::size_t k = 0; k < 2; ++k) {
      const MatrixXd x = part(trial, forward.numbers, k);
      residual.expect_equal(MatrixXd(-product(M, x)), part(trial, inverse, k),
                            largest_entry(M) * largest_entry(x));
    }
    const MatrixXd M_inverse = part(trial, forward.numbers, 2);
    residual.expect_equal(product(M, M_inverse), MatrixXd(MatrixXd::Identity(M.rows(), M.rows())),
                          largest_entry(M) * largest_entry(M_inverse));
    const MatrixXd da_dq = part(trial, forward.numbers, 0), da_dv = part(trial, forward.numbers, 1);
    const double scale = std::max({largest_entry(da_dq), largest_entry(da_dv), largest_entry(M_inverse)});
    jvp.expect_equal(vector(trial.call("forward_dynamics_jvp", ask)),
                     VectorXd(product(da_dq, vector(ask.dq)) + product(da_dv, vector(ask.dv)) +
                              product(M_inverse, vector(ask.dtau))),
                     scale);
    const Numbers gradient = trial.call("forward_dynamics_vjp", ask);
    const VectorXd w = vector(ask.w);
    for (std::size_t k = 0; k < 3; ++k)
      vjp.expect_equal(row(trial, gradient, k),
                       VectorXd(product(MatrixXd(part(trial, forward.numbers, k).transpose()), w)), scale);
  });
}

/// The matrix whose row c is the derivative of a gradient along component c of one of the arguments.
template <class F>
MatrixXd differences(const Trial& trial, const Ask& ask, Numbers Ask::*along, const F& gradient) {
  MatrixXd out(trial.model.nv(), trial.model.nv());
  for (int c = 0; c < trial.model.nv(); ++c) {
    Ask direction;
    direction.dq = direction.dv = direction.da = direction.dtau = trial.zero();
    (direction.*along)[static_cast<std::size_t>(c)] = 1;
    out.row(c) = difference(trial, ask, direction, gradient).transpose();
  }
  return out;
}

TEST_P(Derivatives, HessianOfInverseDynamicsIsTheDerivativeOfTheGradient) {
  Comparison second("second derivatives", GetParam().single ? 1e-3 : 1e-8);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 12});
    Trial exact = trial.by(in_double(GetParam()));
    if (trial.model.nv() == 0) return;
    const Ask ask = any(trial, random);
    const auto gradient = [&](std::size_t k) {
      return [&exact, k](const Ask& at) {
        return numbers(row(exact, exact.call("inverse_dynamics_vjp", at), k));
      };
    };
    const Numbers all = trial.call("inverse_dynamics_hessian", ask);
    const double scale = std::max(largest(exact.call("inverse_dynamics_vjp", ask)), size_of_forces(trial));
    second.expect_equal(part(trial, all, 0), differences(trial, ask, &Ask::dq, gradient(0)), scale);
    second.expect_equal(part(trial, all, 1), differences(trial, ask, &Ask::dq, gradient(1)), scale);
    second.expect_equal(part(trial, all, 2), differences(trial, ask, &Ask::dv, gradient(1)), scale);
    second.expect_equal(part(trial, all, 3), differences(trial, ask, &Ask::da, gradient(0)), scale);
  });
}

TEST_P(DerivativesInDouble, HessianOfForwardDynamicsIsTheDerivativeOfTheGradient) {
  Comparison second("second derivatives", 1e-6);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 8, .always_mass = true});
    if (trial.model.nv() == 0) return;
    const Ask ask = any(trial, random);
    const auto gradient = [&](std::size_t k) {
      return [&trial, k](const Ask& at) {
        return numbers(row(trial, trial.call("forward_dynamics_vjp", at), k));
      };
    };
    const Answer all = trial.answer("forward_dynamics_hessian", ask);
    ASSERT_TRUE(all.solvability.ok());
    const double scale = largest(all.numbers);
    second.expect_equal(part(trial, all.numbers, 0), differences(trial, ask, &Ask::dq, gradient(0)), scale);
    second.expect_equal(part(trial, all.numbers, 1), differences(trial, ask, &Ask::dq, gradient(1)), scale);
    second.expect_equal(part(trial, all.numbers, 2), differences(trial, ask, &Ask::dv, gradient(1)), scale);
    second.expect_equal(part(trial, all.numbers, 3), differences(trial, ask, &Ask::dtau, gradient(0)), scale);
  });
}

TEST_P(DerivativesInDouble, InTimeAreThoseAlongTheMotion) {
  Comparison force("force", 1e-11), rate("rate", 1e-11);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed);
    Ask ask = any(trial, random);
    const std::size_t nv = ask.v.size();
    Numbers motion(ask.v);
    for (const Numbers* const next : {&ask.a, &ask.da})
      motion.insert(motion.end(), next->begin(), next->end());
    Numbers tau(2 * nv);
    InverseDynamicsRates<>(trial.model, 1).evaluate(ask.q, motion, tau, ask.loads);
    const double scale = size_of_forces(trial);
    force.expect_equal(Numbers(tau.begin(), tau.begin() + static_cast<std::ptrdiff_t>(nv)),
                       trial.call("inverse_dynamics", ask), scale);
    ask.dq = ask.v, ask.dv = ask.a;
    const Numbers along = trial.call("inverse_dynamics_jvp", ask);
    rate.expect_equal(Numbers(tau.begin() + static_cast<std::ptrdiff_t>(nv), tau.end()), along,
                      std::max(scale, largest(along)));
  });
}

TEST_P(DerivativesInDouble, OfTheSecondOrderRecursionsAreThoseOfPowerSeries) {
  Comparison body_fixed("body-fixed", 1e-11), spatial("spatial", 1e-11), hybrid("hybrid", 1e-11),
      mixed("mixed", 1e-11);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Trial trial(GetParam(), seed);
    const Ask ask = any(trial, random);
    Workspace<> workspace(trial.model);
    Numbers motion(ask.v);
    for (const Numbers* const next : {&ask.a, &ask.da, &ask.dv})
      motion.insert(motion.end(), next->begin(), next->end());
    Numbers tau(3 * ask.v.size()), expected(tau.size());
    InverseDynamicsRates<>(trial.model, 2).evaluate(ask.q, motion, expected, ask.loads);
    const double scale = std::max(largest(expected), size_of_forces(trial));
    const auto compare = [&]<class Rep>(Rep, Comparison& same) {
      second_order_inverse_dynamics<Rep, double>(trial.model, workspace, ask.q, motion, tau, ask.loads);
      same.expect_equal(tau, expected, scale);
    };
    compare(BodyFixed{}, body_fixed);
    compare(Spatial{}, spatial);
    compare(Hybrid{}, hybrid);
    compare(Mixed{}, mixed);
  });
}

TEST_P(DerivativesInDouble, OfTheMomentumFormAreLimitsOfDifferences) {
  Comparison by_q("by q", 1e-7), by_p("by p", 1e-7);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.always_mass = true});
    if (trial.model.nv() == 0) return;
    Ask ask = any(trial, random);
    ask.p = trial.call("momenta", ask);
    const Answer found = trial.answer("momentum_form_derivatives", ask);
    ASSERT_TRUE(found.solvability.ok());
    const auto matrix_of = [&](std::size_t k) { return part(trial, found.numbers, k); };
    const auto rates = [&](const Ask& at) { return trial.call("momentum_form", at); };
    const auto of = [&](const VectorXd& rates_of, std::size_t k) { return row(trial, numbers(rates_of), k); };
    ask.dv = ask.da = ask.dtau = trial.zero();
    const VectorXd v_moves = product(matrix_of(0), vector(ask.dq)), v = vector(ask.v);
    for (Eigen::Index k = 0; k < v.size(); ++k)
      if (std::abs(v[k]) < 4e-5 * std::abs(v_moves[k]))
        return;  // this joint changes its direction in
                 // between, where friction jumps
    const VectorXd along_q = difference(trial, ask, ask, rates);
    const double scale = std::max({largest_entry(matrix_of(0)), largest_entry(matrix_of(2)),
                                   size_of_forces(trial), largest(rates(ask))});
    by_q.expect_equal(VectorXd(product(matrix_of(0), vector(ask.dq))), of(along_q, 0), scale);
    by_q.expect_equal(VectorXd(product(matrix_of(2), vector(ask.dq))), of(along_q, 1), scale);
    // The result is quadratic in p, so that one central difference is exact.
    const auto moved = [&](double step) {
      Ask at = ask;
      at.p = numbers(vector(ask.p) + step * vector(ask.w));
      return vector(rates(at));
    };
    ask.loads.joint_losses = false;  // friction would jump
    const Numbers lossless = trial.call("momentum_form_derivatives", ask);
    const VectorXd along_p = (moved(1) - moved(-1)) / 2;
    const double scale_p =
        std::max({scale, largest(numbers(along_p)), largest_entry(part(trial, lossless, 1))});
    by_p.expect_equal(VectorXd(product(part(trial, lossless, 1), vector(ask.w))), of(along_p, 0), scale_p);
    by_p.expect_equal(VectorXd(product(part(trial, lossless, 3), vector(ask.w))), of(along_p, 1), scale_p);
  });
}

TEST_P(DerivativesInDouble, OfTheMomentumFormAreHamiltonian) {
  Comparison symplectic("p'_p + (v_q)^T", 1e-9), symmetric("p'_q", 1e-9);
  int checked = 0;
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.always_mass = true});
    const Topology& topology = trial.model.topology();
    for (int i = 1; i <= topology.n; ++i)
      if (topology.first_screw[i + 1] - topology.first_screw[i] > 1)
        return;  // some velocities are not the rates of coordinates
    if (trial.model.nv() == 0) return;
    ++checked;
    Ask ask = any(trial, random);
    ask.p = trial.call("momenta", ask);
    ask.loads = {};
    const Numbers all = trial.call("momentum_form_derivatives", ask);
    const MatrixXd v_q = part(trial, all, 0), dp_q = part(trial, all, 2), dp_p = part(trial, all, 3);
    symplectic.expect_equal(dp_p, MatrixXd(-v_q.transpose()), std::max(largest_entry(v_q), largest(ask.v)));
    symmetric.expect_equal(dp_q, MatrixXd(dp_q.transpose()),
                           std::max(largest_entry(dp_q), size_of_forces(trial)));
  });
  EXPECT_GT(checked, 2);
}

TEST_P(Derivatives, OfMotionAreMatricesTimesVectors) {
  const double agreement = GetParam().agreement();
  Comparison forward("jvp", agreement), backward("vjp", agreement);
  for_seeds(200, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed);
    const Ask ask = any(trial, random);
    const int frame = static_cast<int>(seed % static_cast<std::uint64_t>(trial.model.n_frames()));
    const auto check = [&]<class Rep>(Rep) {
      using T = double;
      Workspace<T> workspace(trial.model);
      const std::size_t nv = ask.v.size();
      std::vector<Twist<Rep>> V_q(nv), V_v(nv), dV_q(nv), dV_v(nv);
      motion_derivatives<Rep, T>(trial.model, workspace, ask.q, ask.v, ask.a, frame, {V_q, V_v, dV_q, dV_v});
      std::vector<Twist<BodyFixed>> J(nv);
      jacobian<BodyFixed, T>(trial.model, workspace, ask.q, frame, J);
      MotionChange<Rep, T> sum{};
      double scale = 1;
      for (std::size_t c = 0; c < nv; ++c) {
        sum.X += ask.dq[c] * J[c];
        sum.V += ask.dq[c] * V_q[c] + ask.dv[c] * V_v[c];
        sum.dV += ask.dq[c] * dV_q[c] + ask.dv[c] * dV_v[c] + ask.da[c] * V_v[c];
        for (const Twist<Rep>& X : {V_q[c], V_v[c], dV_q[c], dV_v[c]})
          scale = std::max({scale, norm(X.w), norm(X.v)});
      }
      const auto change =
          motion_jvp<Rep, T>(trial.model, workspace, ask.q, ask.v, ask.a, frame, ask.dq, ask.dv, ask.da);
      const auto six = [](const auto& X) { return Numbers{X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z}; };
      forward.expect_equal(six(change.X), six(sum.X), scale);
      forward.expect_equal(six(change.V), six(sum.V), scale);
      forward.expect_equal(six(change.dV), six(sum.dV), scale);

      // The weighted sum of the changes along a direction equals the product of the gradient with that
      // direction.
      const auto any3 = [&] {
        const Numbers x = random_numbers(random, 3);
        return Vec3<>{x[0], x[1], x[2]};
      };
      const MotionWeights<Rep, T> w{{any3(), any3()}, {any3(), any3()}, {any3(), any3()}};
      Numbers q(nv), v(nv), a(nv);
      motion_vjp<Rep, T>(trial.model, workspace, ask.q, ask.v, ask.a, frame, w, {q, v, a});
      Numbers by_q, by_v, by_a;
      for (std::size_t c = 0; c < nv; ++c) {
        by_q.push_back((w.X | J[c]) + (w.V | V_q[c]) + (w.dV | dV_q[c]));
        by_v.push_back((w.V | V_v[c]) + (w.dV | dV_v[c]));
        by_a.push_back(w.dV | V_v[c]);
      }
      backward.expect_equal(q, by_q, scale), backward.expect_equal(v, by_v, scale);
      backward.expect_equal(a, by_a, scale);
    };
    check(BodyFixed{}), check(Spatial{}), check(Hybrid{}), check(Mixed{});
  });
}

TEST_P(Derivatives, SecondOnesOfEveryComponentAreHessians) {
  const double agreement = GetParam().agreement();
  Comparison second("second derivatives", agreement);
  for_seeds(30, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial trial(GetParam(), seed, {.most_bodies = 12});
    Ask ask = any(trial, random);
    ask.loads = {};
    const Eigen::Index nv = trial.model.nv();
    const VectorXd all = vector(trial.call("inverse_dynamics_second_derivatives", ask));
    const double scale = std::max(all.size() > 0 ? all.cwiseAbs().maxCoeff() : 0.0, size_of_forces(trial));
    for (Eigen::Index i = 0; i < nv; ++i) {
      ask.w = trial.zero();
      ask.w[static_cast<std::size_t>(i)] = 1;
      const VectorXd hessian = vector(trial.call("inverse_dynamics_hessian", ask));
      for (Eigen::Index block = 0; block < 4; ++block)
        second.expect_equal(VectorXd(all.segment((block * nv + i) * nv * nv, nv * nv)),
                            VectorXd(hessian.segment(block * nv * nv, nv * nv)), scale);
    }
  });
}

TEST(DerivativeResults, ThatShareMemoryAreRefused) {
  const Model model = shoulder();
  Workspace<> workspace(model);
  const std::vector<double> q = neutral(model), x(4);
  std::vector<double> memory(64 * 4);
  const std::span<double> all(memory);
  const auto matrix = [&](std::size_t from) { return all.subspan(from, 16); };
  const auto shared = [](const char* result, const char* other) {
    return testing::StartsWith(std::string(result) + " shares memory with " + other);
  };
  EXPECT_THAT(message_of([&] {
                inverse_dynamics_derivatives(model, workspace, q, x, x,
                                             {matrix(0), matrix(20), matrix(35), all.subspan(60, 4)});
              }),
              shared("dtau/da", "dtau/dv"));
  EXPECT_THAT(message_of([&] {
                (void)forward_dynamics_derivatives(model, workspace, q, x, x,
                                                   {matrix(0), matrix(20), matrix(40), all.subspan(15, 4)});
              }),
              shared("da.q", "da.a"));
  EXPECT_THAT(message_of([&] {
                inverse_dynamics_vjp(model, workspace, q, x, x, x,
                                     {all.subspan(0, 4), all.subspan(3, 4), all.subspan(8, 4)});
              }),
              shared("gradient by v", "by q"));
  EXPECT_THAT(message_of([&] {
                inverse_dynamics_hessian(model, workspace, q, x, x, x,
                                         {matrix(0), matrix(16), matrix(32), matrix(47)});
              }),
              shared("hessian by a, q", "by v, v"));
  EXPECT_THAT(message_of([&] {
                (void)forward_dynamics_second_derivatives(
                    model, workspace, q, x, x,
                    {all.subspan(0, 64), all.subspan(64, 64), all.subspan(64, 64), all.subspan(192, 64)});
              }),
              shared("result by v, v", "by q, v"));
}

}  // namespace
}  // namespace axode::test
