#include "axode/lie/newton_euler.hpp"
#include "tests/laws/law.hpp"

/// The momentum form gives the same motion as Lagrange's equations, in other variables. Momenta, energies and
/// powers balance. The momentum form leaves springs out, and it refuses loops; momenta and energies are of
/// the tree.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

class MomentumForm : public Law {
 protected:
  const Case how = in(Representation::spatial, GetParam());
  const double agreement = how.agreement();
};
INSTANTIATE_TEST_SUITE_P(Laws, MomentumForm, testing::ValuesIn(scalars()), name_of);

Numbers momenta(Trial& t, const Numbers& v) { return t.call("momenta", {.q = t.state.q, .v = v}); }

Numbers minus(Numbers x, const Numbers& y) {
  for (std::size_t c = 0; c < x.size(); ++c) x[c] -= y[c];
  return x;
}

TEST_P(MomentumForm, MomentaAreMTimesVAndEnergiesHalfOfThemTimesV) {
  Comparison momentum("p", agreement), energy("T", agreement);
  for_seeds(1000, [&](std::uint64_t seed) {
    const TreeRecipe recipe = elsewhere(seed);
    Trial trial(how, seed, recipe);
    const Numbers with = trial.inverse_dynamics(trial.zero(), trial.state.v, {}),
                  without = trial.inverse_dynamics(trial.zero(), trial.zero(), {});
    const Numbers p = momenta(trial, trial.state.v);
    momentum.expect_equal(p, minus(with, without),
                          std::max(largest(with), terms_far_away(trial, recipe.far)));
    double twice = 0, size = 0;
    for (std::size_t c = 0; c < p.size(); ++c) {
      twice += p[c] * trial.state.v[c];
      size += std::abs(p[c] * trial.state.v[c]);
    }
    energy.expect_equal(trial.call("kinetic_energy")[0], twice / 2, size);
  });
}

/// The state that a motion with constant accelerations reaches after the time s.
State<double> after(double s, const Trial& t) {
  Numbers step = t.zero(), v = t.state.v;
  for (std::size_t c = 0; c < v.size(); ++c) {
    step[c] = s * t.state.v[c] + s * s / 2 * t.state.a[c];
    v[c] += s * t.state.a[c];
  }
  return {integrate(t.model, t.state.q, step), v, t.state.a};
}

/// The rate of the momenta, M a + Ṁ v, by differences of p along the motion.
Numbers momentum_rate(Trial& t) {
  const double h = 1e-5;
  const auto at = [&](double s) {
    const State<double> there = after(s, t);
    return t.call("momenta", {.q = there.q, .v = there.v});
  };
  Numbers rate = minus(at(h), at(-h));
  for (double& x : rate) x /= 2 * h;
  return rate;
}

TEST_P(MomentumForm, GivesBackTheVelocitiesAndTheRateOfTheMomenta) {
  Comparison velocity("M v", agreement), rate("p'", 1e-6), again("p'", agreement);
  for_seeds(1000, [&](std::uint64_t seed) {
    const TreeRecipe recipe = elsewhere(seed, {.most_bodies = 25});
    Trial trial(how, seed, recipe);
    Ask ask = trial.ask();
    ask.loads.joint_losses = seed % 2 == 0;
    ask.tau = trial.call("inverse_dynamics", ask), ask.p = momenta(trial, ask.v);
    const auto [v_and_dp, solvability] = trial.answer("momentum_form", ask);
    if (!solvability.ok()) return;
    const auto middle = v_and_dp.begin() + trial.model.nv();
    const Numbers v(v_and_dp.begin(), middle), dp(middle, v_and_dp.end());
    velocity.expect_equal(momenta(trial, v), ask.p);
    if (how.single) return;
    const double size = std::max(largest(ask.tau), largest(dp));
    if (!ask.loads.joint_losses) rate.expect_equal(dp, momentum_rate(trial), size);
    // Other accelerations with the drives that they need give the same rate again, because τ - ṗ does not
    // depend on the accelerations.
    Ask other = ask;
    for (double& x : other.a) x = -2 * x;
    other.tau = trial.call("inverse_dynamics", other);
    const auto [other_rates, other_solvability] = trial.answer("momentum_form", other);
    ASSERT_TRUE(other_solvability.ok());
    const Numbers dp_other(other_rates.begin() + trial.model.nv(), other_rates.end());
    again.expect_equal(minus(dp_other, minus(other.tau, ask.tau)), dp, std::max(size, largest(other.tau)));
  });
}

/// The rates of (q, p) by the recursion in Rep: v, then p'.
template <class Rep, class T> Numbers rates_in(const Trial& t, const Ask& ask) {
  Workspace<T> workspace(t.model);
  const State<T> at = cast<T>(t.state);
  Loads<T> loads = at.loads();
  loads.joint_losses = ask.loads.joint_losses;
  std::vector<T> v(at.v.size()), dp(at.v.size());
  const Solvability solvability =
      momentum_form<Rep>(t.model, workspace, at.q, cast<T>(ask.p), cast<T>(ask.tau), v, dp, loads);
  EXPECT_TRUE(solvability.ok());
  v.insert(v.end(), dp.begin(), dp.end());
  return cast<double>(v);
}

TEST_P(MomentumForm, DoesNotDependOnTheRepresentation) {
  Comparison momentum("M v", agreement), rate("p'", agreement);
  int compared = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    TreeRecipe recipe = elsewhere(seed, {.most_bodies = 25});
    recipe.far = 0;  // velocities must be as accurate as the rates that are computed from them
    Trial trial(how, seed, recipe);
    if (definiteness(trial.mass_matrix()) < 1e-2)
      return;  // M must be well conditioned, because the rates are computed from the velocities
    ++compared;
    Ask ask = trial.ask();
    ask.loads.joint_losses = seed % 2 == 0;
    ask.tau = trial.call("inverse_dynamics", ask), ask.p = momenta(trial, ask.v);
    const Numbers expected = trial.call("momentum_form", ask);
    const std::ptrdiff_t nv = trial.model.nv();
    for (const Representation representation : representations)
      with_representation(representation, [&]<class Rep>(Rep) {
        const Numbers found = (how.single ? rates_in<Rep, float> : rates_in<Rep, double>)(trial, ask);
        momentum.expect_equal(momenta(trial, {found.begin(), found.begin() + nv}), ask.p);
        rate.expect_equal(Numbers(found.begin() + nv, found.end()),
                          Numbers(expected.begin() + nv, expected.end()), largest(ask.tau));
      });
  });
  EXPECT_GE(compared, 10);
}

TEST_P(MomentumForm, OfBodiesAddUpToThatOfTheSystem) {
  Comparison total("Π", agreement), energy("T", agreement), centroidal("A v", agreement);
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(how, seed, elsewhere(seed));
    const std::vector<SE3<>> C = trial.poses();
    const Numbers &v = trial.state.v, armature = trial.model.tree<double>().armature;
    for (const Representation representation : representations) {
      Trial in_this = trial.by(representation);
      const std::vector<Six> Pi = sixes_of(in_this.call("body_momenta")), V = in_this.twists();
      Six sum{};
      double twice = 0;
      for (std::size_t i = 0; i < Pi.size(); ++i) {
        sum = sum + changed_wrench(Representation::spatial, representation, C[i + 1], Pi[i]);
        twice += Pi[i] | V[i + 1];
      }
      for (std::size_t c = 0; c < v.size(); ++c) twice += armature[c] * v[c] * v[c];
      total.expect_equal(sixes_of(trial.call("spatial_momentum"))[0], sum);
      energy.expect_equal(trial.call("kinetic_energy")[0], 0.5 * twice);
    }
    if (!(trial.model.total_mass() > 0)) return;
    Six Av{};
    const std::vector<Six> A = sixes_of(trial.call("centroidal_momentum_matrix"));
    for (std::size_t c = 0; c < A.size(); ++c) Av = Av + Six{v[c] * A[c].a, v[c] * A[c].b};
    centroidal.expect_equal(sixes_of(trial.call("centroidal_momentum"))[0], Av);
  });
}

/// The results of a form of the state: velocities, and six numbers for each body.
struct Rates {
  Numbers v, bodies;
  bool solved;
};
template <class Quantity, class T> std::span<Quantity> as(std::vector<T>& numbers) {
  return {reinterpret_cast<Quantity*>(numbers.data()), numbers.size() / 6};
}
/// The form of the state in the twists of the bodies, and the one in their momenta about the inertial origin.
template <class T> Rates by_twists(const Trial& t, Representation in, const Numbers& V, const Numbers& tau) {
  Workspace<T> workspace(t.model);
  const State<T> at = cast<T>(t.state);
  std::vector<T> V_T = cast<T>(V), tau_T = cast<T>(tau), v(at.v.size()), dV(V.size());
  const bool solved = with_representation(in, [&](auto rep) {
    using Rep = decltype(rep);
    return twist_form<Rep>(t.model, workspace, at.q, as<Twist<Rep, T>>(V_T), tau_T, v,
                           as<TwistRate<Rep, T>>(dV), at.loads())
        .ok();
  });
  return {cast<double>(v), cast<double>(dV), solved};
}
template <class T> Rates by_momenta(const Trial& t, const Numbers& Pi, const Numbers& tau) {
  Workspace<T> workspace(t.model);
  const State<T> at = cast<T>(t.state);
  std::vector<T> Pi_T = cast<T>(Pi), tau_T = cast<T>(tau), v(at.v.size()), dPi(Pi.size());
  const bool solved = spatial_momentum_form(t.model, workspace, at.q, as<Momentum<Spatial, T>>(Pi_T), tau_T,
                                            v, as<Wrench<Spatial, T>>(dPi), at.loads())
                          .ok();
  return {cast<double>(v), cast<double>(dPi), solved};
}

TEST_P(MomentumForm, StatesInTwistsAndInSpatialMomentaMoveAlike) {
  Comparison velocity("v", agreement), twist("V'", agreement), momentum("Π'", agreement),
      balance("M V' - ad_Vᵀ M V", agreement);
  int compared = 0, trees = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 25, .always_mass = true});
    ++trees;
    const std::size_t n = trial.n_bodies();
    Ask ask = trial.ask();
    ask.tau = trial.inverse_dynamics();
    const auto [a, solvability] = trial.answer("forward_dynamics", ask);
    if (!solvability.ok()) return;
    trial.state.a = a;
    const double condition = largest(trial.call("mass_matrix")) * largest(trial.call("inverse_mass_matrix")),
                 loss = std::clamp(1e-2 * condition, 20.0, 1e3);
    for (const Representation representation : representations) {
      Trial in_this = trial.by(representation);
      const auto of_bodies = [&](const Numbers& frames) {
        const auto begin = frames.begin() + 6;
        return Numbers(begin, begin + 6 * trial.model.n_bodies());
      };
      const Numbers V = of_bodies(in_this.call("twists")), dV = of_bodies(in_this.call("accelerations"));
      const auto [v, dV_found, solved] =
          (how.single ? by_twists<float> : by_twists<double>)(trial, representation, V, ask.tau);
      EXPECT_TRUE(solved);
      velocity.expect_equal(v, trial.state.v);
      if (largest(a) < 1e4) {  // for larger accelerations M is nearly singular
        ++compared;
        twist.expect_equal(dV_found, dV, loss * largest(a));
      }
    }

    const auto [v, dPi, solved] =
        (how.single ? by_momenta<float> : by_momenta<double>)(trial, trial.call("body_momenta"), ask.tau);
    if (!solved) return;
    velocity.expect_equal(momenta(trial, v), momenta(trial, trial.state.v));
    // Each body has the momentum balance M V' - ad_Vᵀ M V = Π̇.
    Trial in_spatial = trial.by(Representation::spatial);
    const std::vector<Six> twists = in_spatial.twists(), rates = sixes_of(in_spatial.call("accelerations")),
                           found = sixes_of(dPi);
    for (std::size_t i = 1; i <= n && largest(a) < 1e4; ++i) {
      const Inertia<> M = transform(trial.poses()[i], trial.model.body(static_cast<int>(i)).M);
      const Wrench<Spatial> W = newton_euler(M, Twist<Spatial>{twists[i].a, twists[i].b},
                                             TwistRate<Spatial>{rates[i].a, rates[i].b});
      balance.expect_equal(found[i - 1], six(W), loss * std::max(largest(dPi), largest(a)));
    }
    // The sum of Π̇ of all bodies equals the wrenches on the whole system by loads, by gravity and by the
    // joints on the ground.
    Six sum{}, external{};
    for (const Six& x : sixes_of(dPi)) sum = sum + x;
    const std::vector<SE3<>> C = trial.poses();
    const std::vector<Six> W = trial.joint_wrenches();
    double size = 0;
    for (std::size_t i = 1; i <= n; ++i) {
      const Body& body = trial.model.body(static_cast<int>(i));
      if (body.predecessor == 0) external = external + W[i - 1];
      external = external + six(transform(C[i], body.M) * TwistRate<Spatial>{{}, trial.model.gravity()});
      size = std::max(size, largest(entries(W[i - 1])));
    }
    for (const AppliedWrench<>& load : trial.state.wrenches)
      if (trial.model.frame(load.frame).body > 0)
        external = external + changed_wrench(Representation::spatial, load.representation,
                                             C[static_cast<std::size_t>(load.frame)], {load.m, load.f});
    momentum.expect_equal(sum, external, 10 * std::max(size, largest(dPi)));
  });
  EXPECT_GE(compared, how.single ? trees / 100 : trees);
}

bool is_on_path(const Model& model, int i, int j) {
  while (j > i) j = model.body(j).predecessor;
  return j == i;
}

/// Momenta Π of bodies that no velocities have are replaced by M J v with (JᵀMJ) v = JᵀΠ.
TEST_P(MomentumForm, TakesTheProjectionOfMomentaThatNoMotionHas) {
  Comparison projection("JᵀΠ", agreement);
  int compared = 0;
  for_seeds(300, [&](std::uint64_t seed) {
    Trial trial(how, seed, {.most_bodies = 12, .couplings = false, .always_mass = true});
    if (definiteness(trial.mass_matrix()) < 1e-2) return;
    const auto form = how.single ? by_momenta<float> : by_momenta<double>;
    const Numbers tau = trial.inverse_dynamics();
    Numbers Pi = trial.call("body_momenta");
    for (std::size_t k = 0; k < Pi.size(); ++k) Pi[k] += std::sin(static_cast<double>(k));
    const Rates given = form(trial, Pi, tau);
    if (!given.solved) return;
    ++compared;
    trial.state.v = given.v;
    const Numbers consistent = trial.call("body_momenta");
    const std::vector<Six> J = sixes_of(trial.call("joint_screws"));
    Numbers expected, found;
    for (int i = 1; i <= trial.model.n_bodies(); ++i)
      for (int s = trial.model.first_screw(i); s < trial.model.first_screw(i) + trial.model.joint(i).nv;
           ++s) {
        Six sum{}, sum_found{};
        for (int j = i; j <= trial.model.n_bodies(); ++j) {
          if (!is_on_path(trial.model, i, j)) continue;
          sum = sum + sixes_of(Pi)[static_cast<std::size_t>(j - 1)];
          sum_found = sum_found + sixes_of(consistent)[static_cast<std::size_t>(j - 1)];
        }
        expected.push_back(sum | J[static_cast<std::size_t>(s)]);
        found.push_back(sum_found | J[static_cast<std::size_t>(s)]);
      }
    projection.expect_equal(found, expected, largest(Pi));
  });
  EXPECT_GE(compared, 10);
}

TEST_P(MomentumForm, RegressorsAreLinearInTheInertialParameters) {
  Comparison torque("Y π", agreement), kinetic("T", agreement), potential("U", agreement);
  for_seeds(1000, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const TreeRecipe recipe = elsewhere(seed);
    MechanismAtAState drawn = mechanism_at_a_state(random, recipe);
    for (BodyDescription& body : drawn.description.bodies)
      for (Dof& dof : body.joint.dof) dof.armature = 0;
    Trial trial(how, ModelBuilder(std::move(drawn.description)).build(), drawn.state);
    const Numbers pi = inertial_parameters(trial.model);
    const auto times_pi = [&](const Numbers& rows) {
      Numbers sums;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        if (k % pi.size() == 0) sums.push_back(0);
        sums.back() += rows[k] * pi[k % pi.size()];
      }
      return sums;
    };
    torque.expect_equal(times_pi(trial.call("regressor")),
                        trial.inverse_dynamics(trial.state.v, trial.state.a, {}),
                        terms_far_away(trial, recipe.far));
    kinetic.expect_equal(times_pi(trial.call("kinetic_energy_regressor")), trial.call("kinetic_energy"));
    potential.expect_equal(times_pi(trial.call("potential_energy_regressor")), trial.call("potential_energy"),
                           10 * std::pow(recipe.scale, 2) * trial.model.total_mass());
  });
}

TEST_P(MomentumForm, CentroidalInertiaIsWhatALockedSystemHas) {
  Comparison inertia("I v", agreement);
  for_seeds(1000, [&](std::uint64_t seed) {
    Trial trial(how, seed, elsewhere(seed, {.couplings = false, .one_free_root = true}));
    if (!(trial.model.total_mass() > 0)) return;
    Numbers v = trial.zero();  // the base moves, the joints do not
    std::copy_n(trial.state.v.begin(), 6, v.begin());
    const Numbers M = trial.call("centroidal_inertia");  // m, h, Θ
    const Sym3<> Theta{M[4], M[5], M[6], M[7], M[8], M[9]};
    const Vec3<> c = vectors_of(trial.call("center_of_mass"))[0];
    const Six V = trial.twists(v)[1],
              Pi = sixes_of(trial.call("centroidal_momentum", {.q = trial.state.q, .v = v}))[0];
    inertia.expect_equal(Pi, Six{Theta * V.a, M[0] * (V.b + cross(V.a, c))});
  });
}

}  // namespace
}  // namespace axode::test
