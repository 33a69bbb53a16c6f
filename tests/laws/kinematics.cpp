#include "axode/kinematics/product_of_exponentials.hpp"
#include "tests/laws/law.hpp"
#include "tests/lie/relative_error.hpp"
#include "tests/support/any_scalar.hpp"

/// Poses, twists and accelerations of all frames: three ways to the same poses, and every rate is the time
/// derivative of what it is the rate of.
namespace axode::test {
namespace {

template <class C> class Kinematics : public testing::Test {};
TYPED_TEST_SUITE(Kinematics, Cases, CaseNames);

/// The derivative of each entry of a pose at t = 0, as 4×4 matrices.
template <class T, std::size_t N>
std::vector<Eigen::Matrix4<T>> rates(const std::vector<SE3<Taylor<T, N>>>& C) {
  std::vector<Eigen::Matrix4<T>> out;
  for (const SE3<Taylor<T, N>>& C_i : C) {
    const auto column = [](const Vec3<Taylor<T, N>>& a) {
      return Eigen::Vector3<T>(a.x.c[1], a.y.c[1], a.z.c[1]);
    };
    Eigen::Matrix4<T> dC = Eigen::Matrix4<T>::Zero();
    dC.template topRows<3>() << column(C_i.R.x), column(C_i.R.y), column(C_i.R.z), column(C_i.r);
    out.push_back(dC);
  }
  return out;
}

TYPED_TEST(Kinematics, TwistsAreTheRatesOfPoses) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison rate("rate", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const auto tree = cast<Taylor<T, 3>>(trial.model.template tree<T>());
    const auto q = moving(tree, trial.state.q, trial.state.v, trial.state.a);
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
    std::vector<Eigen::Matrix4<T>> C_V;
    for (std::size_t f = 0; f < C.size(); ++f)
      C_V.push_back(to_eigen(C[f]) * hat(screw(change<BodyFixed>(C[f], V[f]))));
    rate.expect_equal(C_V, rates(frame_poses(tree, q)));
  });
}

template <class Rep, class T, std::size_t N>
std::vector<TwistRate<Rep, T>> rates(const std::vector<Twist<Rep, Taylor<T, N>>>& V) {
  std::vector<TwistRate<Rep, T>> dV;
  for (const auto& [w, v] : V) dV.push_back({{w.x.c[1], w.y.c[1], w.z.c[1]}, {v.x.c[1], v.y.c[1], v.z.c[1]}});
  return dV;
}

TYPED_TEST(Kinematics, AccelerationsAreTheRatesOfTwists) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison rate("rate", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const auto tree = cast<Taylor<T, 3>>(trial.model.template tree<T>());
    const auto q = moving(tree, trial.state.q, trial.state.v, trial.state.a);
    const auto v = moving<3>(trial.state.v, trial.state.a);
    rate.expect_equal(trial.template accelerations<Rep>(), rates(frame_twists<Rep>(tree, q, v)));
  });
}

TYPED_TEST(Kinematics, TwistsAndAccelerationsChangeRepresentation) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison twist("twist", agreement<T>), acceleration("acceleration", agreement<T>);
  for_seeds(250, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    const std::vector<SE3<T>> C = trial.poses();
    const std::vector<Twist<Rep, T>> V = trial.template twists<Rep>();
    const std::vector<TwistRate<Rep, T>> dV = trial.template accelerations<Rep>();
    const auto compare = [&](auto other) {
      using Other = decltype(other);
      if constexpr (!std::same_as<Rep, Other>) {
        std::vector<Twist<Other, T>> V_other;
        std::vector<TwistRate<Other, T>> dV_other;
        for (std::size_t f = 0; f < C.size(); ++f) {
          V_other.push_back(change<Other>(C[f], V[f]));
          dV_other.push_back(change<Other>(C[f], V[f], dV[f]));
        }
        twist.expect_equal(trial.template twists<Other>(), V_other);
        acceleration.expect_equal(trial.template accelerations<Other>(), dV_other);
      }
    };
    compare(BodyFixed{}), compare(Spatial{}), compare(Hybrid{}), compare(Mixed{});
  });
}

template <class T> class Poses : public testing::Test {};
TYPED_TEST_SUITE(Poses, Scalars, ScalarNames);

TYPED_TEST(Poses, AreProductsOfExponentialsOfBodyAndOfSpatialScrews) {
  using T = TypeParam;
  Comparison by_X("X", agreement<T>), by_Y("Y", agreement<T>);
  for_seeds(2000, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    std::vector<SE3<T>> C = trial.poses();
    C.resize(static_cast<std::size_t>(trial.model.n_bodies() + 1));  // the ground and the bodies
    by_X.expect_equal(poses_by_body_screws(trial.model, trial.state.q.data()), C);
    by_Y.expect_equal(poses_by_spatial_screws(trial.model, trial.state.q.data()), C);
  });
}

TYPED_TEST(Poses, PutTheCentreOfMassAtTheMeanOfThoseOfTheBodies) {
  using T = TypeParam;
  Comparison moment("first moment", agreement<T>);
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    if (trial.model.total_mass() == 0) return;
    const std::vector<SE3<T>> C = trial.poses();
    Vec3<T> sum;
    for (int i = 1; i <= trial.model.n_bodies(); ++i) {
      const Inertia<T> M = axode::cast<T>(trial.model.body(i).M);
      if (M.m > 0) sum += M.m * (C[static_cast<std::size_t>(i)] * center_of_mass(M));
    }
    const Vec3<T> c = center_of_mass<T>(trial.model, trial.workspace, trial.state.q);
    moment.expect_equal(T(trial.model.total_mass()) * c, sum, trial.model.total_mass());
  });
}

TYPED_TEST(Poses, OfEveryJointAtZeroAreThoseDrawn) {
  using T = TypeParam;
  Comparison pose("pose", agreement<T>);
  for_seeds(500, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Mechanism drawn = random_mechanism(random, {.couplings = false});
    const Model model = ModelBuilder(told(drawn, random)).build();
    Trial<T> trial(model, State<double>{neutral(model), {}, {}});
    const std::vector<SE3<T>> C = trial.poses();
    const auto compare = [&](const std::string& name, const SE3<>& A) {
      pose.expect_equal(C[static_cast<std::size_t>(model.frame_index(name))], axode::cast<T>(A));
    };
    for (const DrawnBody& body : drawn.bodies) compare(body.name, body.A);
    for (const DrawnFrame& frame : drawn.frames) compare(frame.name, frame.pose);
  });
}

}  // namespace
}  // namespace axode::test
