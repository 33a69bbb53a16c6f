#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// Jerk, snap and higher derivatives: the recursion on coefficients gives the same as the kernels of every
/// representation on power series, and as explicit formulas.
namespace axode::test {
namespace {

class HigherOrder : public Law {
 protected:
  const Representation in = GetParam().representation;
};
INSTANTIATE_TEST_SUITE_P(Kinematics, HigherOrder, representations_in_double(), name_of);

constexpr int highest = 6;
constexpr std::size_t N = highest + 2;
using Series = Taylor<double, N>;
const TreeRecipe small_trees{.most_bodies = 10};

/// A random tree in a motion with random velocities and random derivatives of these up to the order
/// `highest`.
struct Motion {
  Random<double> random;
  Model model;
  std::vector<double> q, rates;
  Tree<Series> tree;
  std::vector<Series> q_t, v_t;

  explicit Motion(std::uint64_t seed)
      : random(seed),
        model(random_model(random, small_trees)),
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

/// The k-th derivative of a twist in a representation.
template <class T>
Six twist_derivative(Representation in, const HigherOrderMotion<T>& motion, const Place<>& place, int k) {
  return with_representation(in, [&](auto rep) {
    const auto [a, b] = motion.template twist_derivative<decltype(rep)>(on<T>(place), k);
    return Six{axode::cast<double>(a), axode::cast<double>(b)};
  });
}
std::vector<Six> twist_derivatives(Representation in, const HigherOrderMotion<>& motion, int frames, int k) {
  std::vector<Six> V_k;
  for (int f = 0; f < frames; ++f) V_k.push_back(twist_derivative(in, motion, f, k));
  return V_k;
}
/// The k-th derivative of a Jacobian in a representation, column by column.
std::vector<Six> jacobian_derivative(Representation in, const HigherOrderMotion<>& motion,
                                     const Place<>& place, int nv, int k) {
  std::vector<Six> out;
  with_representation(in, [&](auto rep) {
    std::vector<TwistRate<decltype(rep)>> J_k(static_cast<std::size_t>(nv), {{9, 9, 9}, {9, 9, 9}});
    motion.jacobian_derivative<decltype(rep)>(place, k, J_k);
    for (const auto& column : J_k) out.push_back(six(column));
  });
  return out;
}

/// A twist as a series in time.
struct SixSeries {
  Vec3<Series> a, b;

  Six derivative(int k) const {
    return {time_derivative(a, static_cast<std::size_t>(k)), time_derivative(b, static_cast<std::size_t>(k))};
  }
};
std::vector<Six> derivatives(const std::vector<SixSeries>& twists, int k) {
  std::vector<Six> all;
  for (const SixSeries& V : twists) all.push_back(V.derivative(k));
  return all;
}
/// The twists of all frames from the recursion in a representation, computed on series.
std::vector<SixSeries> frame_twists_in(Representation in, const Motion& at, const std::vector<Series>& v) {
  std::vector<SixSeries> all;
  with_representation(in, [&](auto rep) {
    for (const auto& [a, b] : frame_twists<decltype(rep)>(at.tree, at.q_t, v)) all.push_back({a, b});
  });
  return all;
}
std::vector<SixSeries> jacobian_in(Representation in, const Motion& at, const Place<>& place) {
  std::vector<SixSeries> all;
  with_representation(in, [&](auto rep) {
    for (const auto& [a, b] : jacobian_on<decltype(rep)>(at.tree, at.q_t, on<Series>(place)))
      all.push_back({a, b});
  });
  return all;
}

TEST_P(HigherOrder, TwistsAreThoseOfTheRecursionOnSeries) {
  Comparison derivative_of("derivative", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const std::vector<SixSeries> V = frame_twists_in(in, at, at.v_t);
    for (int k = 0; k <= highest; ++k) {
      SCOPED_TRACE("order " + std::to_string(k));
      derivative_of.expect_equal(twist_derivatives(in, motion, at.model.n_frames(), k), derivatives(V, k), 1);
    }
  });
}

TEST_P(HigherOrder, JacobiansAreThoseOfTheRecursionOnSeriesForUnitVelocities) {
  Comparison derivative_of("derivative", agreement<double>);
  for_seeds(40, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const int frame = at.model.n_frames() - 1;
    std::vector<SixSeries> J;
    for (int c = 0; c < at.model.nv(); ++c)
      J.push_back(frame_twists_in(in, at, on<Series>(unit(at.model.nv(), c))).back());
    for (int k = 0; k <= highest; ++k) {
      SCOPED_TRACE("order " + std::to_string(k));
      derivative_of.expect_equal(jacobian_derivative(in, motion, frame, at.model.nv(), k), derivatives(J, k),
                                 1);
    }
  });
}

TEST_P(HigherOrder, PlacesBesideAFrameMoveWithIt) {
  Comparison column("column", agreement<double>), twist("twist", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const Place<> place = random_place(at.model, at.random);
    const std::vector<SixSeries> J = jacobian_in(in, at, place);
    SixSeries V{};
    for (std::size_t c = 0; c < J.size(); ++c) V.a += at.v_t[c] * J[c].a, V.b += at.v_t[c] * J[c].b;
    for (int k = highest; k >= 0; --k) {
      column.expect_equal(jacobian_derivative(in, motion, place, at.model.nv(), k), derivatives(J, k), 1);
      twist.expect_equal(twist_derivative(in, motion, place, k), V.derivative(k), 1);
    }
  });
}

TEST_P(HigherOrder, TwistsFollowFromJacobiansByTheProductRule) {
  Comparison sum("sum", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    const int frame = at.model.n_frames() - 1;
    for (int k = 0; k <= highest; ++k) {
      Six V_k{};
      double binomial = 1;
      for (int l = 0; l <= k; ++l) {
        const std::vector<Six> J_l = jacobian_derivative(in, motion, frame, at.model.nv(), l);
        for (std::size_t c = 0; c < J_l.size(); ++c) {
          const double v = binomial * at.rate(k - l)[c];
          V_k = V_k + Six{v * J_l[c].a, v * J_l[c].b};
        }
        binomial = binomial * (k - l) / (l + 1);
      }
      sum.expect_equal(twist_derivative(in, motion, frame, k), V_k, 1);
    }
  });
}

TEST_P(HigherOrder, OrdersZeroAndOneAreTheTwistTheJacobianAndTheAcceleration) {
  Comparison V("V", agreement<double>), dV("dV", agreement<double>), J("J", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed, small_trees);
    const Model& model = trial.model;
    HigherOrderMotion<> motion(model, 0), next(model, 1);
    motion.evaluate(trial.state.q, trial.state.v);
    V.expect_equal(twist_derivatives(in, motion, model.n_frames(), 0), trial.twists());
    Ask ask = trial.ask();
    ask.place = model.n_frames() - 1;
    J.expect_equal(jacobian_derivative(in, motion, ask.place, model.nv(), 0),
                   sixes_of(trial.call("jacobian", ask)));

    std::vector<double> rates = trial.state.v;
    rates.insert(rates.end(), trial.state.a.begin(), trial.state.a.end());
    next.evaluate(trial.state.q, rates);
    dV.expect_equal(twist_derivatives(in, next, model.n_frames(), 1), trial.accelerations());
  });
}

TEST_P(HigherOrder, AnEvaluationDoesNotDependOnAnEarlierOne) {
  const Motion at(8);
  HigherOrderMotion<> motion(at.model, highest);
  motion.evaluate(random_configuration(at.model, 99), std::vector<double>(at.rates.size(), 3.0));
  static_cast<void>(twist_derivative(in, motion, at.model.n_frames() - 1, highest));
  motion.evaluate(at.q, at.rates);
  const HigherOrderMotion<> fresh = at.evaluated();
  for (int k = 0; k <= highest; ++k)
    EXPECT_EQ(entries(twist_derivatives(in, motion, at.model.n_frames(), k)),
              entries(twist_derivatives(in, fresh, at.model.n_frames(), k)));
}

TEST_P(HigherOrder, InSinglePrecisionAgreesToItsDigits) {
  Comparison derivative_of("derivative", agreement<float>);
  for_seeds(50, [&](std::uint64_t seed) {
    const Motion at(seed);
    const HigherOrderMotion<> motion = at.evaluated();
    HigherOrderMotion<float> single(at.model, highest);
    single.evaluate(cast<float>(at.q), cast<float>(at.rates));
    const int frame = at.model.n_frames() - 1;
    for (int k = 0; k <= highest; ++k)
      derivative_of.expect_equal(twist_derivative(in, single, frame, k),
                                 twist_derivative(in, motion, frame, k));
  });
}

// ----------------------------------------------------------------------------- explicit formulas of the jerk

/// A joint screw on the path to a body. The path goes from the ground outwards.
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

/// A random tree in motion, with the quantities that the formulas for the jerk of one body need.
struct JerkOf {
  Motion at;
  HigherOrderMotion<> motion;
  Trial trial;
  std::vector<SE3<>> C;
  std::vector<Column> columns;
  std::vector<Screw<>> X;  ///< the screw of each column in the frame of its body, for a velocity of 1
  int body;

  explicit JerkOf(std::uint64_t seed)
      : at(seed),
        motion(at.evaluated(2)),
        trial(scalars()[0], at.model,
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
/// (erratum 4 of docs/errata.md). Screws of one joint act as one: [[J_j, J_k], J_r] over all its pairs.
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
    Trial spatial = at.trial.by(Representation::spatial);
    const std::vector<Six> V = spatial.twists(), dV = spatial.accelerations();
    Screw<> sum;
    for (std::size_t j = 0; j < at.columns.size(); ++j) {
      const std::size_t i = static_cast<std::size_t>(at.columns[j].joint);
      const Screw<> J = at.spatial(j), V_j{V[i].a, V[i].b}, dV_j{dV[i].a, dV[i].b}, dJ = ad(V_j, J);
      sum = sum + at.v(j, 2) * J + (2 * at.v(j, 1)) * dJ + at.v(j, 0) * (ad(dV_j, J) + ad(V_j, dJ));
    }
    const auto V_2 = at.motion.twist_derivative<Spatial>(at.body, 2);
    jerk.expect_equal(Screw<>{V_2.w, V_2.v}, sum);
  });
}

/// The hybrid jerk with erratum 10 of docs/errata.md, in the joint screws ⁰X_j^j at the bodies that they
/// move; r_ij points from i to j.
Screw<> hybrid_jerk(JerkOf& at) {
  const std::vector<Six> V = at.trial.twists(), dV = at.trial.accelerations();
  const auto ad_r = [](const Vec3<>& r, const Screw<>& X) { return Screw<>{{}, cross(r, X.w)}; };
  const auto ad_w = [](const Vec3<>& w, const Screw<>& X) { return Screw<>{cross(w, X.w), cross(w, X.v)}; };
  Screw<> sum;
  for (std::size_t a = 0; a < at.columns.size(); ++a) {
    const std::size_t j = static_cast<std::size_t>(at.columns[a].joint),
                      i = static_cast<std::size_t>(at.body);
    const Screw<> X = Ad(at.C[j].R, at.X[a]);
    const Vec3<> r = at.C[j].r - at.C[i].r, dr = V[j].b - V[i].b, ddr = dV[j].b - dV[i].b, w = V[j].a;
    const Screw<> wX = ad_w(w, X);
    const Screw<> J = Ad(r, X), dJ = ad_r(dr, X) + Ad(r, wX),
                  ddJ = ad_r(ddr, X) + 2.0 * ad_r(dr, wX) + Ad(r, ad_w(dV[j].a, X) + ad_w(w, wX));
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

/// V^m'' = diag(Rᵀ, I) (V^h'' - (ω × ω', 0)), with erratum 12 of docs/errata.md.
TEST(Jerk, MixedIsTheHybridOneWithItsAngularPartInTheBody) {
  Comparison jerk("jerk", agreement<double>);
  for_seeds(100, [&](std::uint64_t seed) {
    JerkOf at(seed);
    const Screw<> h = hybrid_jerk(at);
    const std::size_t i = static_cast<std::size_t>(at.body);
    const Vec3<> w = at.trial.twists()[i].a, dw = at.trial.accelerations()[i].a;
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
