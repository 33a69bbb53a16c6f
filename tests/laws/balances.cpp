#include "axode/lie/newton_euler.hpp"
#include "tests/laws/law.hpp"
#include "tests/support/series.hpp"

/// Conservation laws: power, momentum, and the balance of the wrenches on every body.
namespace axode::test {
namespace {

class Balances : public Law {
 protected:
  const Representation own = GetParam().representation;
  Six spatial(const SE3<>& C, const Six& W) const {
    return changed_wrench(Representation::spatial, own, C, W);
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, Balances, testing::ValuesIn(cases()), name_of);

TEST_P(Balances, DrivesAndLoadsFeedTheEnergyAndLossesTakeIt) {
  Comparison power("power", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    const bool losses = seed % 2 == 0;
    Trial trial(GetParam(), seed, {.friction = losses});
    const Tree<double>& tree = trial.model.tree<double>();
    const Trial::Numbers& v = trial.state.v;
    const std::vector<double> tau =
        trial.inverse_dynamics(v, trial.state.a, {.wrenches = trial.state.wrenches, .joint_losses = losses});
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> V = trial.twists();
    double fed = 0, scale = 0;
    const auto feed = [&](double P) { fed += P, scale = std::max(scale, std::abs(P)); };
    for (std::size_t k = 0; k < tau.size(); ++k) feed(tau[k] * v[k]);
    for (std::size_t k = 0; k < tau.size() && losses; ++k)
      feed(-tree.damping[k] * v[k] * v[k] - tree.friction[k] * std::abs(v[k]));
    for (const AppliedWrench<>& load : trial.state.wrenches) {
      const std::size_t f = static_cast<std::size_t>(load.frame);
      feed(Six{load.m, load.f} | changed_twist(load.representation, own, C[f], V[f]));
    }
    power.expect_equal(fed, rate_of_energy(own, trial.model, trial.state), scale);
  });
}

/// The loads on each body, in the spatial representation.
std::vector<Six> loads_on_bodies(const Trial& trial, const std::vector<SE3<>>& C) {
  std::vector<Six> W(trial.n_bodies() + 1);
  for (const AppliedWrench<>& load : trial.state.wrenches) {
    Six& on_body = W[static_cast<std::size_t>(trial.model.frame(load.frame).body)];
    on_body = on_body + changed_wrench(Representation::spatial, load.representation,
                                       C[static_cast<std::size_t>(load.frame)], {load.m, load.f});
  }
  return W;
}
Six weight(const Vec3<>& g, const SE3<>& C, const Inertia<>& M) {
  return {cross(M.m * C.r + C.R * M.h, g), M.m * g};
}

TEST_P(Balances, RootJointsWeightAndLoadsChangeTheMomentum) {
  Comparison wrench("wrench", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> W = trial.joint_wrenches(), loads = loads_on_bodies(trial, C);
    Six sum{};
    double scale = 0;
    const auto act = [&](const Six& W_i) { sum = sum + W_i, scale = std::max(scale, largest(entries(W_i))); };
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Body& body = trial.model.body(i);
      act(loads[f]), act(weight(trial.model.gravity(), C[f], body.M));
      if (body.predecessor == 0) act(spatial(C[f], W[f - 1]));
    }
    wrench.expect_equal(sum, rate_of_momentum(own, trial.model, trial.state), scale);
  });
}

/// The resultant wrench on a body that has this twist and twist rate.
Six resultant(Representation representation, const SE3<>& C, const Inertia<>& M, const Six& V,
              const Six& dV) {
  return with_representation(representation, [&](auto rep) {
    using Rep = decltype(rep);
    return six(wrench(C, M, twist_of<Rep>(V), rate_of<Rep>(dV)));
  });
}

TEST_P(Balances, WrenchesOnEveryBodyAccelerateIt) {
  Comparison balance("balance", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> V = trial.twists(), dV = trial.accelerations(), W = trial.joint_wrenches();
    std::vector<Six> acting = loads_on_bodies(trial, C), accelerating(acting.size());
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Body& body = trial.model.body(i);
      const Six transmitted = spatial(C[f], W[f - 1]);
      Six& reaction = acting[static_cast<std::size_t>(body.predecessor)];
      acting[f] = acting[f] + transmitted + weight(trial.model.gravity(), C[f], body.M);
      reaction = reaction - transmitted;
      accelerating[f] = spatial(C[f], resultant(own, C[f], body.M, V[f], dV[f]));
    }
    acting[0] = {};  // the ground stays where it is
    balance.expect_equal(acting, accelerating, largest(entries(W)));
  });
}

TEST_P(Balances, DriveForcesAreTheSharesOfJointWrenchesAlongTheJoints) {
  Comparison torque("torque", GetParam().agreement());
  for_seeds(250, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> W = trial.joint_wrenches();
    std::vector<double> tau = trial.zero();
    double scale = 0;
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const std::size_t f = static_cast<std::size_t>(i);
      const Joint& joint = trial.model.joint(i);
      const double ratio = joint.leader ? joint.leader->ratio : 1;
      const Six W_b = changed_wrench(Representation::body, own, C[f], W[f - 1]);
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const Screw<>& X = trial.model.body(i).X[d];
        const std::size_t k = static_cast<std::size_t>(joint.iv) + d;
        const double share = W_b | Six{X.w, X.v};
        scale = std::max(scale, std::abs(share));
        tau[k] += ratio * share + ratio * ratio * joint.dof[d].armature * trial.state.a[k];
      }
    }
    torque.expect_equal(trial.inverse_dynamics(), tau, scale);
  });
}

}  // namespace
}  // namespace axode::test
