#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// Jerk, snap and beyond: the recursion on coefficients agrees with the kernels of every representation run
/// on power series, and with the explicit formulas.
namespace axode::test {
namespace {

template <class R> class HigherOrder : public testing::Test {};
TYPED_TEST_SUITE(HigherOrder, Representations, RepresentationNames);

constexpr int highest = 6;
constexpr std::size_t N = highest + 2;
using Series = Taylor<double, N>;
const TreeRecipe trees{.most_bodies = 10};

/// A tree in a motion of which the velocities and their first `highest` derivatives are drawn.
struct Motion {
  Random<double> random;
  Model model;
  std::vector<double> q, rates;
  Tree<Series> tree;
  std::vector<Series> q_t, v_t;

  explicit Motion(std::uint64_t seed)
      : random(seed),
        model(random_model(random, trees)),
        q(random_configuration(model, seed)),
        rates(random_numbers(random, (highest + 1) * model.nv())),
        tree(on<Series>(model)),
        v_t(static_cast<std::size_t>(model.nv())) {
    double factorial = 1;
    for (int k = 0; k <= highest; ++k) {
      if (k > 1) factorial *= k;
      for (int c = 0; c < model.nv(); ++c) v_t[c].c[k] = rate(k)[c] / factorial;
    }
    q_t = flow(model, q, v_t);
  }
  std::span<const double> rate(int k) const {
    return std::span(rates).subspan(static_cast<std::size_t>(k * model.nv()),
                                    static_cast<std::size_t>(model.nv()));
  }
  HigherOrderMotion<> evaluated(int order = highest) const {
    HigherOrderMotion<> motion(model, order);
    motion.evaluate(q, std::span(rates).first(static_cast<std::size_t>((order + 1) * model.nv())));
    return motion;
  }
};

template <class Rep> std::vector<TwistRate<Rep>> rates_of(const std::vector<Twist<Rep>>& J) {
  std::vector<TwistRate<Rep>> out;
  for (const auto& [w, v] : J) out.push_back({w, v});
  return out;
}
template <class Rep>
std::vector<TwistRate<Rep>> twist_derivatives(const HigherOrderMotion<>& motion, int frames, int k) {
  std::vector<TwistRate<Rep>> V_k;
  for (int f = 0; f < frames; ++f) V_k.push_back(motion.twist_derivative<Rep>(f, k));
  return V_k;
}
template <class Rep>
std::vector<TwistRate<Rep>> jacobian_derivative(const HigherOrderMotion<>& motion, const Place<>& place,
                                                int nv, int k) {
  std::vector<TwistRate<Rep>> J_k(static_cast<std::size_t>(nv), {{9, 9, 9}, {9, 9, 9}});
  motion.jacobian_derivative<Rep>(place, k, J_k);
  return J_k;
}

TYPED_TEST(HigherOrder, TwistsAreThoseOfTheRecursionOnSeries) {
  using Rep = TypeParam;
  Comparison derivative_of("derivative", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const auto V = frame_twists<Rep>(at.tree, at.q_t, at.v_t);
    for (int k = 0; k <= highest; ++k) {
      SCOPED_TRACE("order " + std::to_string(k));
      derivative_of.expect_equal(twist_derivatives<Rep>(motion, at.model.n_frames(), k),
                                 rates_of(time_derivative(V, static_cast<std::size_t>(k))), 1);
    }
  });
}

TYPED_TEST(HigherOrder, JacobiansAreThoseOfTheRecursionOnSeriesForUnitVelocities) {
  using Rep = TypeParam;
  Comparison derivative_of("derivative", agreement<double>);
  for_seeds(40, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const int frame = at.model.n_frames() - 1;
    std::vector<Twist<Rep, Series>> J;
    for (int c = 0; c < at.model.nv(); ++c)
      J.push_back(frame_twists<Rep>(at.tree, at.q_t, on<Series>(unit(at.model.nv(), c))).back());
    for (int k = 0; k <= highest; ++k) {
      SCOPED_TRACE("order " + std::to_string(k));
      derivative_of.expect_equal(jacobian_derivative<Rep>(motion, frame, at.model.nv(), k),
                                 rates_of(time_derivative(J, static_cast<std::size_t>(k))), 1);
    }
  });
}

TYPED_TEST(HigherOrder, PlacesBesideAFrameMoveWithIt) {
  using Rep = TypeParam;
  Comparison column("column", agreement<double>), twist("twist", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const Place<> place = random_place(at.model, at.random);
    const auto J = jacobian_on<Rep>(at.tree, at.q_t, on<Series>(place));
    Twist<Rep, Series> V{};
    for (std::size_t c = 0; c < J.size(); ++c) V += at.v_t[c] * J[c];
    for (int k = highest; k >= 0; --k) {
      column.expect_equal(jacobian_derivative<Rep>(motion, place, at.model.nv(), k),
                          rates_of(time_derivative(J, static_cast<std::size_t>(k))), 1);
      const Twist<Rep> V_k = time_derivative(V, static_cast<std::size_t>(k));
      twist.expect_equal(motion.twist_derivative<Rep>(place, k), TwistRate<Rep>{V_k.w, V_k.v}, 1);
    }
  });
}

TYPED_TEST(HigherOrder, TwistsFollowFromJacobiansByTheProductRule) {
  using Rep = TypeParam;
  Comparison sum("sum", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const int frame = at.model.n_frames() - 1;
    for (int k = 0; k <= highest; ++k) {
      TwistRate<Rep> V_k{};
      double binomial = 1;
      for (int l = 0; l <= k; ++l) {
        const auto J_l = jacobian_derivative<Rep>(motion, frame, at.model.nv(), l);
        for (int c = 0; c < at.model.nv(); ++c) V_k += (binomial * at.rate(k - l)[c]) * J_l[c];
        binomial = binomial * (k - l) / (l + 1);
      }
      sum.expect_equal(motion.twist_derivative<Rep>(frame, k), V_k, 1);
    }
  });
}

TYPED_TEST(HigherOrder, OrdersZeroAndOneAreTheTwistTheJacobianAndTheAcceleration) {
  using Rep = TypeParam;
  Comparison V("V", agreement<double>), dV("dV", agreement<double>), J("J", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<double> trial{Random<double>(seed), trees};
    const Model& model = trial.model;
    HigherOrderMotion<> motion(model, 0), next(model, 1);
    motion.evaluate(trial.state.q, trial.state.v);
    V.expect_equal(twist_derivatives<Rep>(motion, model.n_frames(), 0),
                   rates_of(trial.template twists<Rep>()));
    std::vector<Twist<Rep>> J_f(static_cast<std::size_t>(model.nv()));
    jacobian<Rep>(model, trial.workspace, trial.state.q, model.n_frames() - 1, J_f);
    J.expect_equal(jacobian_derivative<Rep>(motion, model.n_frames() - 1, model.nv(), 0), rates_of(J_f));

    std::vector<double> rates = trial.state.v;
    rates.insert(rates.end(), trial.state.a.begin(), trial.state.a.end());
    next.evaluate(trial.state.q, rates);
    dV.expect_equal(twist_derivatives<Rep>(next, model.n_frames(), 1), trial.template accelerations<Rep>());
  });
}

TYPED_TEST(HigherOrder, AnEvaluationDoesNotDependOnAnEarlierOne) {
  using Rep = TypeParam;
  const Motion at(8);
  HigherOrderMotion<> motion(at.model, highest);
  motion.evaluate(random_configuration(at.model, 99), std::vector<double>(at.rates.size(), 3.0));
  static_cast<void>(motion.twist_derivative<Rep>(at.model.n_frames() - 1, highest));
  motion.evaluate(at.q, at.rates);
  const HigherOrderMotion<> fresh = at.evaluated();
  for (int k = 0; k <= highest; ++k)
    EXPECT_EQ(entries(twist_derivatives<Rep>(motion, at.model.n_frames(), k)),
              entries(twist_derivatives<Rep>(fresh, at.model.n_frames(), k)));
}

TYPED_TEST(HigherOrder, InSinglePrecisionAgreesToItsDigits) {
  using Rep = TypeParam;
  Comparison derivative_of("derivative", agreement<float>);
  for_seeds(50, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    HigherOrderMotion<float> single(at.model, highest);
    single.evaluate(cast<float>(at.q), cast<float>(at.rates));
    const int frame = at.model.n_frames() - 1;
    for (int k = 0; k <= highest; ++k) {
      const TwistRate<Rep, float> V_k = single.twist_derivative<Rep>(Place<float>(frame), k);
      derivative_of.expect_equal(each_number(V_k, [](float x) { return static_cast<double>(x); }),
                                 motion.twist_derivative<Rep>(frame, k));
    }
  });
}

// ------------------------------------------------------------------------------------- explicit formulas of the jerk

/// Joint screws on the path to a body, from the root outwards.
struct Column {
  int joint, c;
  double ratio;
};
std::vector<Column> path_columns(const Model& model, int body) {
  std::vector<Column> columns;
  std::vector<int> path;
  for (int i = body; i > 0; i = model.body(i).predecessor) path.insert(path.begin(), i);
  for (const int i : path)
    for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k)
      columns.push_back(
          {i, model.joint(i).iv + k, model.joint(i).leader ? model.joint(i).leader->ratio : 1.0});
  return columns;
}

/// A tree in a motion, with what the formulas for the jerk of one body are made of.
struct JerkOf {
  Motion at;
  HigherOrderMotion<> motion;
  Trial<double> trial;
  std::vector<SE3<>> C;
  std::vector<Column> columns;
  std::vector<Screw<>> X;  ///< of each column, in the frame of its body, for a unit velocity
  int body;

  explicit JerkOf(std::uint64_t seed)
      : at(seed),
        motion(at.evaluated(2)),
        trial(at.model,
              {at.q, {at.rate(0).begin(), at.rate(0).end()}, {at.rate(1).begin(), at.rate(1).end()}}),
        C(trial.poses()),
        body(at.model.n_bodies()) {
    columns = path_columns(at.model, body);
    int joint = 0, k = 0;
    for (const Column& column : columns) {
      k = column.joint == joint ? k + 1 : 0;
      joint = column.joint;
      X.push_back(column.ratio * at.model.body(joint).X[k]);
    }
  }
  Screw<> spatial(std::size_t a) const { return Ad(C[columns[a].joint], X[a]); }
  Screw<> body_fixed(std::size_t a) const { return Ad_inv(C[body], spatial(a)); }
  double v(std::size_t a, int k) const { return at.rate(k)[columns[a].c]; }
};

/// The bracket sums of eq. Vbddot: pairs of joints j < k <= i, and triples j < k < r <= i and j < k = r <= i
/// (erratum 4). Screws of one joint act as one: [[J_j, J_k], J_r] over all its pairs.
TEST(Jerk, BodyFixedIsASumOfNestedScrewProducts) {
  Comparison jerk("jerk", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    const JerkOf at(seed);
    const std::size_t m = at.columns.size();
    const auto joint = [&](std::size_t a) { return at.columns[a].joint; };
    Screw<> sum;
    for (std::size_t j = 0; j < m; ++j) {
      const Screw<> J_j = at.body_fixed(j);
      sum = sum + at.v(j, 2) * J_j;
      for (std::size_t k = j + 1; k < m; ++k) {
        if (joint(k) == joint(j)) continue;
        const Screw<> J_jk = ad(J_j, at.body_fixed(k));
        sum = sum + (2 * at.v(j, 1) * at.v(k, 0) + at.v(j, 0) * at.v(k, 1)) * J_jk;
        for (std::size_t r = j + 1; r < m; ++r) {
          if (joint(r) == joint(j) || joint(r) < joint(k)) continue;
          const double times = joint(r) == joint(k) ? 1 : 2;
          sum = sum + (times * at.v(j, 0) * at.v(k, 0) * at.v(r, 0)) * ad(J_jk, at.body_fixed(r));
        }
      }
    }
    const auto V = at.motion.twist_derivative<BodyFixed>(at.body, 2);
    jerk.expect_equal(Screw<>{V.w, V.v}, sum);
  });
}

/// J_j'' = [V_j', J_j] + [V_j, [V_j, J_j]] from eq. timeDerJs.
TEST(Jerk, SpatialFollowsFromTheTwistsAndAccelerationsOfTheBodies) {
  Comparison jerk("jerk", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    JerkOf at(seed);
    const auto V = at.trial.twists<Spatial>();
    const auto dV = at.trial.accelerations<Spatial>();
    Screw<> sum;
    for (std::size_t j = 0; j < at.columns.size(); ++j) {
      const int i = at.columns[j].joint;
      const Screw<> J = at.spatial(j), V_j = screw(V[i]), dV_j{dV[i].w, dV[i].v}, dJ = ad(V_j, J);
      sum = sum + at.v(j, 2) * J + (2 * at.v(j, 1)) * dJ + at.v(j, 0) * (ad(dV_j, J) + ad(V_j, dJ));
    }
    const auto V_2 = at.motion.twist_derivative<Spatial>(at.body, 2);
    jerk.expect_equal(Screw<>{V_2.w, V_2.v}, sum);
  });
}

/// The hybrid jerk with erratum 10, in the joint screws ⁰X_j^j at the bodies that they move; r_ij points from
/// i to j.
Screw<> hybrid_jerk(JerkOf& at) {
  const auto V = at.trial.twists<Hybrid>();
  const auto dV = at.trial.accelerations<Hybrid>();
  const auto ad_r = [](const Vec3<>& r, const Screw<>& X) { return Screw<>{{}, cross(r, X.w)}; };
  const auto ad_w = [](const Vec3<>& w, const Screw<>& X) { return Screw<>{cross(w, X.w), cross(w, X.v)}; };
  Screw<> sum;
  for (std::size_t a = 0; a < at.columns.size(); ++a) {
    const int j = at.columns[a].joint, i = at.body;
    const Screw<> X = Ad(at.C[j].R, at.X[a]);
    const Vec3<> r = at.C[j].r - at.C[i].r, dr = V[j].v - V[i].v, ddr = dV[j].v - dV[i].v, w = V[j].w;
    const Screw<> wX = ad_w(w, X);
    const Screw<> J = Ad(r, X), dJ = ad_r(dr, X) + Ad(r, wX),
                  ddJ = ad_r(ddr, X) + 2.0 * ad_r(dr, wX) + Ad(r, ad_w(dV[j].w, X) + ad_w(w, wX));
    sum = sum + at.v(a, 2) * J + (2 * at.v(a, 1)) * dJ + at.v(a, 0) * ddJ;
  }
  return sum;
}

TEST(Jerk, HybridFollowsFromThePositionsAndAngularVelocitiesOfTheBodies) {
  Comparison jerk("jerk", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    JerkOf at(seed);
    const auto V_2 = at.motion.twist_derivative<Hybrid>(at.body, 2);
    jerk.expect_equal(Screw<>{V_2.w, V_2.v}, hybrid_jerk(at));
  });
}

/// V^m'' = diag(Rᵀ, I) (V^h'' - (ω × ω', 0)), erratum 12.
TEST(Jerk, MixedIsTheHybridOneWithItsAngularPartInTheBody) {
  Comparison jerk("jerk", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    JerkOf at(seed);
    const Screw<> h = hybrid_jerk(at);
    const Vec3<> w = at.trial.twists<Hybrid>()[at.body].w, dw = at.trial.accelerations<Hybrid>()[at.body].w;
    const auto V_2 = at.motion.twist_derivative<Mixed>(at.body, 2);
    jerk.expect_equal(Screw<>{V_2.w, V_2.v}, Screw<>{transpose(at.C[at.body].R) * (h.w - cross(w, dw)), h.v});
  });
}

TEST(HigherOrderErrors, NameTheValueAndTheRule) {
  const Motion at(4);
  const Model& model = at.model;
  EXPECT_EQ(message_of([&] { HigherOrderMotion<>(model, -1); }),
            "order is -1; it must not be negative (0 is velocity)");
  HigherOrderMotion<> motion(model, 2);
  EXPECT_EQ(motion.order(), 2);
  EXPECT_EQ(message_of([&] { motion.evaluate(at.q, std::vector<double>(2)); }),
            "rates has 2 entries; expected (order + 1) nv = " + std::to_string(3 * model.nv()));
  EXPECT_EQ(message_of([&] { static_cast<void>(motion.twist_derivative(0, 3)); }),
            "order 3 is not among 0 to 2");
  EXPECT_EQ(message_of([&] { static_cast<void>(motion.twist_derivative(0, -1)); }),
            "order -1 is not among 0 to 2");
  EXPECT_EQ(message_of([&] { static_cast<void>(motion.twist_derivative(model.n_frames(), 0)); }).substr(0, 9),
            "frame is ");
  std::vector<TwistRate<BodyFixed>> J(static_cast<std::size_t>(model.nv()) + 1);
  EXPECT_EQ(
      message_of([&] { motion.jacobian_derivative<BodyFixed>(0, 0, J); }),
      "J has " + std::to_string(model.nv() + 1) + " entries; expected nv = " + std::to_string(model.nv()));
}

}  // namespace
}  // namespace axode::test
