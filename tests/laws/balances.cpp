#include "axode/dynamics/newton_euler.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/any_scalar.hpp"

/// What physics conserves: power, momentum, and the balance of wrenches on every body.
namespace axode::test {
namespace {

template <class C> class Balances : public testing::Test {};
TYPED_TEST_SUITE(Balances, Cases, CaseNames);

/// T + U of a tree, with the twists in any representation. Rotors count by their armature.
template <class Rep, class S>
S energy(const Tree<S>& tree, const std::vector<S>& q, const std::vector<S>& v) {
  const std::vector<SE3<S>> C = frame_poses(tree, q);
  const std::vector<Twist<Rep, S>> V = frame_twists<Rep>(tree, q, v);
  S E(0.0);
  for (int i = 1; i <= tree.n; ++i) {
    const std::size_t f = static_cast<std::size_t>(i);
    const Inertia<S> M = transform(inverse(tree.frame_offset[i]), tree.M[i]);  // in the frame of the user
    E += S(0.5) * (M * change<BodyFixed>(C[f], V[f]) | change<BodyFixed>(C[f], V[f]));
    E -= dot(tree.g, M.m * C[f].r + C[f].R * M.h);
  }
  for (std::size_t k = 0; k < v.size(); ++k) E += S(0.5) * tree.armature[k] * v[k] * v[k];
  return E;
}

TYPED_TEST(Balances, DrivesAndLoadsFeedTheEnergy) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison power("power", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const auto tree = cast<Taylor<T, 3>>(trial.model.template tree<T>());
    const auto q = moving(tree, trial.state.q, trial.state.v, trial.state.a);
    const auto v = moving<3>(trial.state.v, trial.state.a);
    const double dE = energy<Rep>(tree, q, v).c[1];

    const std::vector<T> tau = trial.template inverse_dynamics<Rep>();
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
    double fed = 0, scale = 0;
    const auto feed = [&](double P) { fed += P, scale = std::max(scale, std::abs(P)); };
    for (std::size_t k = 0; k < tau.size(); ++k) feed(double(tau[k]) * double(trial.state.v[k]));
    for (const AppliedWrench<T>& load : trial.state.wrenches) {
      const std::size_t f = static_cast<std::size_t>(load.frame);
      with_representation(load.representation, [&](auto rep) {
        feed(Wrench<decltype(rep), T>{load.m, load.f} | change<decltype(rep)>(C[f], V[f]));
      });
    }
    power.expect_equal(fed, dE, scale);
  });
}

/// The loads on each body, in the spatial representation.
template <class T>
std::vector<Wrench<Spatial, T>> loads_on_bodies(const Trial<T>& trial, const std::vector<SE3<T>>& C) {
  std::vector<Wrench<Spatial, T>> W(static_cast<std::size_t>(trial.model.n_bodies() + 1));
  for (const AppliedWrench<T>& load : trial.state.wrenches) {
    const std::size_t body = static_cast<std::size_t>(trial.model.frame(load.frame).body);
    with_representation(load.representation, [&](auto rep) {
      W[body] +=
          change<Spatial>(C[static_cast<std::size_t>(load.frame)], Wrench<decltype(rep), T>{load.m, load.f});
    });
  }
  return W;
}
template <class T> Wrench<Spatial, T> weight(const Vec3<>& g, const SE3<T>& C, const Inertia<T>& M) {
  const Vec3<T> g_T = axode::cast<T>(g), h = M.m * C.r + C.R * M.h;
  return {cross(h, g_T), M.m * g_T};
}

TYPED_TEST(Balances, RootJointsWeightAndLoadsChangeTheMomentum) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison wrench("wrench", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    using S = Taylor<T, 3>;
    const auto tree = cast<S>(trial.model.template tree<T>());
    const auto q = moving(tree, trial.state.q, trial.state.v, trial.state.a);
    const std::vector<SE3<S>> C_t = frame_poses(tree, q);
    const auto V_t = frame_twists<Rep>(tree, q, moving<3>(trial.state.v, trial.state.a));
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Wrench<Rep, T>> W = trial.template joint_wrenches<Rep>();
    const std::vector<Wrench<Spatial, T>> loads = loads_on_bodies(trial, C);

    Momentum<Spatial, S> Pi{};
    Wrench<Spatial, T> sum{};
    double scale = 0;
    const auto act = [&](const Wrench<Spatial, T>& W_i) {
      sum += W_i, scale = std::max(scale, largest(entries(W_i)));
    };
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Body& body = trial.model.body(i);
      Pi += change<Spatial>(C_t[f], axode::cast<S>(body.M) * change<BodyFixed>(C_t[f], V_t[f]));
      act(loads[f]), act(weight(trial.model.gravity(), C[f], axode::cast<T>(body.M)));
      if (body.predecessor == 0) act(change<Spatial>(C[f], W[f - 1]));
    }
    const Wrench<Spatial, T> rate{{Pi.l.x.c[1], Pi.l.y.c[1], Pi.l.z.c[1]},
                                  {Pi.p.x.c[1], Pi.p.y.c[1], Pi.p.z.c[1]}};
    wrench.expect_equal(sum, rate, scale);
  });
}

TYPED_TEST(Balances, WrenchesOnEveryBodyAccelerateIt) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison balance("balance", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
    const std::vector<TwistRate<Rep, T>> dV = trial.template accelerations<Rep>();
    const std::vector<Wrench<Rep, T>> W = trial.template joint_wrenches<Rep>();
    std::vector<Wrench<Spatial, T>> acting = loads_on_bodies(trial, C), accelerating(acting.size());
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Inertia<T> M = axode::cast<T>(trial.model.body(i).M);
      const Wrench<Spatial, T> transmitted = change<Spatial>(C[f], W[f - 1]);
      acting[f] += transmitted + weight(trial.model.gravity(), C[f], M);
      acting[static_cast<std::size_t>(trial.model.body(i).predecessor)] -= transmitted;
      accelerating[f] = change<Spatial>(C[f], wrench(C[f], M, V[f], dV[f]));
    }
    acting[0] = {};  // the ground stays where it is
    balance.expect_equal(acting, accelerating, largest(entries(W)));
  });
}

TYPED_TEST(Balances, DriveForcesAreTheSharesOfJointWrenchesAlongTheJoints) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison torque("torque", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Wrench<Rep, T>> W = trial.template joint_wrenches<Rep>();
    std::vector<double> tau(static_cast<std::size_t>(trial.model.nv()));
    double scale = 0;
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Joint& joint = trial.model.joint(i);
      const double ratio = joint.leader ? joint.leader->ratio : 1;
      const Wrench<BodyFixed, T> W_b = change<BodyFixed>(C[f], W[f - 1]);
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const Screw<T> X{axode::cast<T>(trial.model.body(i).X[d].w),
                         axode::cast<T>(trial.model.body(i).X[d].v)};
        const std::size_t k = static_cast<std::size_t>(joint.iv) + d;
        const double share = W_b | twist<BodyFixed>(X);
        scale = std::max(scale, std::abs(share));
        tau[k] += ratio * share + ratio * ratio * joint.dof[d].armature * double(trial.state.a[k]);
      }
    }
    torque.expect_equal(cast<double>(trial.template inverse_dynamics<Rep>()), tau, scale);
  });
}

TYPED_TEST(Balances, KineticEnergyIsTheQuadraticFormOfTheMassMatrix) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison kinetic("kinetic", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial<T> trial(ModelBuilder(told(random_mechanism(random), random)).gravity({}).build(), random);
    const std::vector<T> momenta = trial.template inverse_dynamics<Rep>(trial.zero(), trial.state.v, {});
    double twice = 0, scale = 0;
    for (std::size_t k = 0; k < momenta.size(); ++k) {
      const double part = double(momenta[k]) * double(trial.state.v[k]);
      twice += part, scale = std::max(scale, std::abs(part));
    }
    kinetic.expect_equal(
        2.0 * double(energy<Rep>(trial.model.template tree<T>(), trial.state.q, trial.state.v)), twice,
        scale);
  });
}

}  // namespace
}  // namespace axode::test
