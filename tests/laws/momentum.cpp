#include "tests/laws/law.hpp"

/// The momentum form is Lagrange's in other variables; momenta, energies and powers balance.
namespace axode::test {
namespace {

template <class T> class MomentumForm : public testing::Test {};
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(MomentumForm, Scalars, ScalarNames);

template <class T> std::vector<T> momenta(Trial<T>& t, const std::vector<T>& v) {
  std::vector<T> p = t.zero();
  generalized_momenta(t.model, t.workspace, t.state.q, v, p);
  return p;
}

TYPED_TEST(MomentumForm, MomentaAreMTimesV) {
  using T = TypeParam;
  Comparison momentum("p", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<T> with = trial.template inverse_dynamics<Spatial>(trial.zero(), trial.state.v, {}),
                         without = trial.template inverse_dynamics<Spatial>(trial.zero(), trial.zero(), {});
    std::vector<T> Mv = with;
    for (std::size_t c = 0; c < Mv.size(); ++c) Mv[c] -= without[c];
    momentum.expect_equal(momenta(trial, trial.state.v), Mv, largest(entries(with)));
  });
}

/// p' = M a + M' v by differences of p along the motion, in double.
std::vector<double> momentum_rate(Trial<double>& t) {
  const double h = 1e-5;
  const auto at = [&](double s) {
    Trial<double> there(t.model, t.exact);
    std::vector<double> step = t.zero(), v = t.state.v;
    for (std::size_t c = 0; c < v.size(); ++c) {
      step[c] = s * t.state.v[c] + s * s / 2 * t.state.a[c];
      v[c] += s * t.state.a[c];
    }
    there.state.q = integrate(t.model, t.state.q, step);
    return momenta(there, v);
  };
  std::vector<double> rate = at(h);
  const std::vector<double> before = at(-h);
  for (std::size_t c = 0; c < rate.size(); ++c) rate[c] = (rate[c] - before[c]) / (2 * h);
  return rate;
}

TYPED_TEST(MomentumForm, GivesBackTheVelocitiesAndTheRateOfTheMomenta) {
  using T = TypeParam;
  Comparison velocity("M v", agreement<T>), rate("p'", 1e-6), again("p'", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.most_bodies = 25}};
    Loads<T> loads = trial.state.loads();
    loads.joint_losses = seed % 2 == 0;
    const std::vector<T> tau = trial.template inverse_dynamics<Spatial>(trial.state.v, trial.state.a, loads),
                         p = momenta(trial, trial.state.v);
    std::vector<T> v = trial.zero(), dp = trial.zero();
    if (!momentum_form(trial.model, trial.workspace, trial.state.q, p, tau, v, dp, loads).ok()) return;
    velocity.expect_equal(momenta(trial, v), p);
    if constexpr (std::same_as<T, double>) {
      const double size = std::max(largest(entries(tau)), largest(dp));
      if (!loads.joint_losses) rate.expect_equal(dp, momentum_rate(trial), size);
      // The same rate from the drives that (v, a) take: τ - p' does not depend on the accelerations.
      std::vector<double> other = trial.state.a, dp_other = trial.zero();
      for (double& x : other) x = -2 * x;
      const std::vector<double> tau_other =
          trial.template inverse_dynamics<Spatial>(trial.state.v, other, loads);
      ASSERT_TRUE(
          momentum_form(trial.model, trial.workspace, trial.state.q, p, tau_other, v, dp_other, loads).ok());
      for (std::size_t c = 0; c < dp.size(); ++c) dp_other[c] += tau[c] - tau_other[c];
      again.expect_equal(dp_other, dp, std::max(size, largest(entries(tau_other))));
    }
  });
}

TYPED_TEST(MomentumForm, OfBodiesAddUpToThatOfTheSystem) {
  using T = TypeParam;
  Comparison total("Π", agreement<T>), energy("T", agreement<T>), centroidal("A v", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<SE3<T>> C = trial.poses();
    Momentum<Spatial, T> sum{};
    T twice(0);
    const auto add = [&](auto rep) {
      using Rep = decltype(rep);
      std::vector<Momentum<Rep, T>> Pi(static_cast<std::size_t>(trial.model.n_bodies()));
      body_momenta<Rep>(trial.model, trial.workspace, trial.state.q, trial.state.v, Pi);
      const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
      sum = {}, twice = T(0);
      for (std::size_t i = 0; i < Pi.size(); ++i) {
        sum += change<Spatial>(C[i + 1], change<BodyFixed>(C[i + 1], Pi[i]));
        twice += Pi[i] | V[i + 1];
      }
      const Tree<T>& tree = trial.model.template tree<T>();
      for (std::size_t c = 0; c < trial.state.v.size(); ++c)
        twice += tree.armature[c] * trial.state.v[c] * trial.state.v[c];
      total.expect_equal(spatial_momentum(trial.model, trial.workspace, trial.state.q, trial.state.v), sum);
      energy.expect_equal(kinetic_energy(trial.model, trial.workspace, trial.state.q, trial.state.v),
                          T(0.5) * twice);
    };
    add(BodyFixed{}), add(Spatial{}), add(Hybrid{}), add(Mixed{});
    if (!(trial.model.total_mass() > 0)) return;
    std::vector<Momentum<Hybrid, T>> A(trial.state.v.size());
    centroidal_momentum_matrix(trial.model, trial.workspace, trial.state.q, A);
    Momentum<Hybrid, T> Av{};
    for (std::size_t c = 0; c < A.size(); ++c) Av += trial.state.v[c] * A[c];
    centroidal.expect_equal(centroidal_momentum(trial.model, trial.workspace, trial.state.q, trial.state.v),
                            Av);
  });
}

TEST(EnergyBalance, EnergyChangesWithThePowerOfDrivesAndLoads) {
  Comparison power("power", 1e-6);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), {.most_bodies = 25}};
    const Loads<double> loads{.wrenches = trial.exact.wrenches};
    const auto energy = [&](double s) {
      std::vector<double> step = trial.zero(), v = trial.exact.v;
      for (std::size_t c = 0; c < v.size(); ++c) {
        step[c] = s * trial.exact.v[c] + s * s / 2 * trial.exact.a[c];
        v[c] += s * trial.exact.a[c];
      }
      const std::vector<double> q = integrate(trial.model, trial.exact.q, step);
      return kinetic_energy(trial.model, trial.workspace, q, v) +
             potential_energy(trial.model, trial.workspace, q);
    };
    const double h = 1e-5, rate = (energy(h) - energy(-h)) / (2 * h);
    Trial<double> exact(trial.model, trial.exact);
    const std::vector<double> tau = exact.inverse_dynamics<Spatial>(trial.exact.v, trial.exact.a, loads);
    std::vector<double> of_loads(loads.wrenches.size());
    load_powers(trial.model, trial.workspace, trial.exact.q, trial.exact.v, loads, of_loads);
    double sum = 0, size = std::abs(energy(0));
    for (std::size_t c = 0; c < tau.size(); ++c)
      sum += tau[c] * trial.exact.v[c], size += std::abs(tau[c] * trial.exact.v[c]);
    for (const double x : of_loads) sum += x, size += std::abs(x);
    power.expect_equal(rate, sum, size);
  });
}

TYPED_TEST(MomentumForm, StatesInTwistsAndInSpatialMomentaMoveAlike) {
  using T = TypeParam;
  Comparison velocity("v", agreement<T>), twist("V'", agreement<T>), momentum("Π'", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.most_bodies = 25, .always_mass = true}};
    const std::size_t n = static_cast<std::size_t>(trial.model.n_bodies());
    const Loads<T> loads = trial.state.loads();
    const std::vector<T> tau = trial.template inverse_dynamics<Spatial>();
    std::vector<T> a = trial.zero();
    if (!forward_dynamics<Spatial>(trial.model, trial.workspace, trial.state.q, trial.state.v, tau, a, loads)
             .ok())
      return;
    trial.state.a = a;
    const auto check = [&](auto rep) {
      using Rep = decltype(rep);
      std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
      std::vector<TwistRate<Rep, T>> dV(n), expected = trial.template accelerations<Rep>();
      std::vector<T> v = trial.zero();
      const std::span<const Twist<Rep, T>> bodies = std::span<const Twist<Rep, T>>(V).subspan(1, n);
      EXPECT_TRUE(
          twist_form<Rep>(trial.model, trial.workspace, trial.state.q, bodies, tau, v, dV, loads).ok());
      expected.erase(expected.begin()), expected.resize(n);
      velocity.expect_equal(v, trial.state.v);
      // Accelerations are as good as M is far from singular: compared by what they ask of the drives in
      // another test.
      if (largest(entries(a)) < 1e4) twist.expect_equal(dV, expected, 1e3 * largest(entries(a)));
    };
    check(BodyFixed{}), check(Spatial{}), check(Hybrid{}), check(Mixed{});

    std::vector<Momentum<Spatial, T>> Pi(n);
    body_momenta<Spatial>(trial.model, trial.workspace, trial.state.q, trial.state.v, Pi);
    std::vector<Wrench<Spatial, T>> dPi(n);
    std::vector<T> v = trial.zero();
    if (!spatial_momentum_form(trial.model, trial.workspace, trial.state.q, Pi, tau, v, dPi, loads).ok())
      return;
    velocity.expect_equal(momenta(trial, v), momenta(trial, trial.state.v));
    // Π' of all bodies is what loads, gravity and the ground's joints do to the system.
    Wrench<Spatial, T> sum{}, external{};
    for (const Wrench<Spatial, T>& x : dPi) sum += x;
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Wrench<Spatial, T>> W = trial.template joint_wrenches<Spatial>();
    double size = 0;
    for (std::size_t i = 1; i <= n; ++i) {
      const Body& body = trial.model.body(static_cast<int>(i));
      if (body.predecessor == 0) external += W[i - 1];
      const Inertia<T> M = transform(C[i], axode::cast<T>(body.M));
      external += M * TwistRate<Spatial, T>{{}, trial.model.template tree<T>().g};
      size = std::max(size, largest(entries(W[i - 1])));
    }
    for (const AppliedWrench<T>& load : trial.state.wrenches)
      if (trial.model.frame(load.frame).body > 0) {
        const SE3<T> C_f = C[static_cast<std::size_t>(load.frame)];
        with_representation(load.representation, [&](auto rep) {
          external += change<Spatial>(C_f, change<BodyFixed>(C_f, Wrench<decltype(rep), T>{load.m, load.f}));
        });
      }
    momentum.expect_equal(sum, external, 10 * std::max(size, largest(entries(dPi))));
  });
}

TYPED_TEST(MomentumForm, RegressorsAreLinearInTheInertialParameters) {
  using T = TypeParam;
  Comparison torque("Y π", agreement<T>), kinetic("T", agreement<T>), potential("U", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Description description = told(random_mechanism(random), random);
    for (BodyDescription& body : description.bodies)
      for (Dof& dof : body.joint.dof) dof.armature = 0;
    Trial<T> trial(ModelBuilder(std::move(description)).build(), random);
    const std::vector<double> pi = inertial_parameters(trial.model);
    const std::size_t nv = trial.state.v.size(), width = pi.size();
    std::vector<T> Y(nv * width), y(width);
    torque_regressor(trial.model, trial.workspace, trial.state.q, trial.state.v, trial.state.a, Y);
    const auto times_pi = [&](const T* row) {
      double sum = 0;
      for (std::size_t k = 0; k < width; ++k) sum += double(row[k]) * pi[k];
      return static_cast<T>(sum);
    };
    std::vector<T> tau;
    for (std::size_t c = 0; c < nv; ++c) tau.push_back(times_pi(Y.data() + c * width));
    torque.expect_equal(tau, trial.template inverse_dynamics<Spatial>(trial.state.v, trial.state.a, {}));
    kinetic_energy_regressor(trial.model, trial.workspace, trial.state.q, trial.state.v, y);
    kinetic.expect_equal(times_pi(y.data()),
                         kinetic_energy(trial.model, trial.workspace, trial.state.q, trial.state.v));
    potential_energy_regressor(trial.model, trial.workspace, trial.state.q, y);
    potential.expect_equal(times_pi(y.data()), potential_energy(trial.model, trial.workspace, trial.state.q),
                           10 * trial.model.total_mass());
  });
}

TYPED_TEST(MomentumForm, CentroidalInertiaIsWhatALockedSystemHas) {
  using T = TypeParam;
  Comparison inertia("I v", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), {.couplings = false, .one_free_root = true}};
    if (!(trial.model.total_mass() > 0)) return;
    std::vector<T> v = trial.zero();  // the base moves, the joints do not
    for (std::size_t c = 0; c < 6; ++c) v[c] = trial.state.v[c];
    const Inertia<T> M = centroidal_inertia(trial.model, trial.workspace, trial.state.q);
    const Vec3<T> c = center_of_mass(trial.model, trial.workspace, trial.state.q);
    const Twist<Spatial, T> V = trial.template twists<Spatial>(v)[1];
    const Vec3<T> dc = V.v + cross(V.w, c);
    const Momentum<Hybrid, T> Pi = centroidal_momentum(trial.model, trial.workspace, trial.state.q, v);
    inertia.expect_equal(Pi, Momentum<Hybrid, T>{M.Theta * V.w, M.m * dc});
  });
}

}  // namespace
}  // namespace axode::test
