#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// Jacobians are what makes twists of velocities.
namespace axode::test {
namespace {

template <class C> class Jacobian : public testing::Test {};
TYPED_TEST_SUITE(Jacobian, Cases, CaseNames);

const TreeRecipe trees{.most_bodies = 30};

template <class Rep, class T> std::vector<Twist<Rep, T>> jacobian_of(Trial<T>& trial, const Place<T>& place) {
  std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(trial.model.nv()),
                               {{T(9), T(9), T(9)}, {T(9), T(9), T(9)}});
  jacobian<Rep>(trial.model, trial.workspace, trial.state.q, place, J);
  return J;
}
template <class Rep, class T>
Twist<Rep, T> times(const std::vector<Twist<Rep, T>>& J, const std::vector<T>& v) {
  Twist<Rep, T> V{};
  for (std::size_t c = 0; c < J.size(); ++c) V += v[c] * J[c];
  return V;
}

TYPED_TEST(Jacobian, TimesTheVelocitiesIsTheTwistOfEveryFrame) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison twist("twist", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    std::vector<Twist<Rep, T>> V;
    for (int f = 0; f < trial.model.n_frames(); ++f)
      V.push_back(times(jacobian_of<Rep, T>(trial, f), trial.state.v));
    twist.expect_equal(V, trial.template twists<Rep>());
  });
}

TYPED_TEST(Jacobian, IsTheSumOfItsColumnsAlongThePath) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    const Model& model = trial.model;
    std::vector<JacobianColumn<Rep, T>> columns(static_cast<std::size_t>(model.n_screws()));
    for (int f = 0; f < model.n_frames(); ++f) {
      const std::size_t count = jacobian_columns<Rep>(model, trial.workspace, trial.state.q, f, columns);
      std::vector<Twist<Rep, T>> sum(static_cast<std::size_t>(model.nv()));
      for (std::size_t k = 0; k < count; ++k) sum[columns[k].c] += columns[k].J;
      Comparison("column", agreement<T>).expect_equal(jacobian_of<Rep, T>(trial, f), sum);

      std::size_t screws_on_path = 0;
      for (int i = model.frame(f).body; i > 0; i = model.body(i).predecessor)
        screws_on_path += model.body(i).X.size();
      EXPECT_EQ(count, screws_on_path);
    }
  });
}

TYPED_TEST(Jacobian, OfAPoseInAFrameIsThatOfAFrameThere) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison pose("pose", agreement<T>), point("point", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Description description = told(random_mechanism(random, trees), random);
    const std::string body = description.bodies.back().name;
    const SE3<> offset{random.rotation(), random.vector()};
    description.frames.push_back({.name = "place", .body = body, .pose = offset});
    description.frames.push_back({.name = "point", .body = body, .pose = {{}, offset.r}});
    Trial<T> trial(ModelBuilder(description).build(), random);
    const int frame = trial.model.frame_index(body);
    pose.expect_equal(jacobian_of<Rep, T>(trial, {frame, axode::cast<T>(offset)}),
                      jacobian_of<Rep, T>(trial, trial.model.frame_index("place")));
    point.expect_equal(jacobian_of<Rep, T>(trial, {frame, axode::cast<T>(offset.r)}),
                       jacobian_of<Rep, T>(trial, trial.model.frame_index("point")));
  });
}

TYPED_TEST(Jacobian, ChangesItsRepresentationLikeTwists) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison column("column", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    const int frame = trial.model.n_frames() - 1;
    const SE3<T> C = trial.poses().back();
    const auto compare = [&](auto other) {
      using Other = decltype(other);
      std::vector<Twist<Rep, T>> changed;
      for (const auto& J_c : jacobian_of<Other, T>(trial, frame)) changed.push_back(change<Rep>(C, J_c));
      column.expect_equal(jacobian_of<Rep, T>(trial, frame), changed);
    };
    compare(BodyFixed{}), compare(Spatial{}), compare(Hybrid{}), compare(Mixed{});
  });
}

template <class Rep, class T>
std::vector<Twist<Rep, T>> relative_jacobian_of(Trial<T>& trial, const Place<T>& place,
                                                const Place<T>& base) {
  std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(trial.model.nv()));
  relative_jacobian<Rep>(trial.model, trial.workspace, trial.state.q, place, base, J);
  return J;
}

TYPED_TEST(Jacobian, OfOnePlaceRelativeToAnotherIsThatOfTheRelativePose) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  using S = Taylor<T, 2>;
  Comparison rate("rate", agreement<T>);
  for_seeds(150, [&](std::uint64_t seed) {
    Random<double> random(seed);
    Trial<T> trial(random_model(random, trees), random);
    const Place<> place = random_place(trial.model, random), base = random_place(trial.model, random);
    const Tree<S> tree = axode::cast<S>(trial.model.template tree<T>());
    const std::vector<T> zero = trial.zero();
    const std::vector<S> q = moving<2>(tree, trial.state.q, trial.state.v, zero);
    const std::vector<SE3<S>> frames = frame_poses(tree, q);
    const auto pose = [&](const Place<>& at) {
      return frames[static_cast<std::size_t>(at.frame)] * axode::cast<S>(at.offset);
    };
    const SE3<S> C_series = inverse(pose(base)) * pose(place);
    const SE3<T> C = time_derivative(C_series, 0), dC = time_derivative(C_series, 1);

    const Twist<Rep, T> V =
        times(relative_jacobian_of<Rep, T>(trial, on<T>(place), on<T>(base)), trial.state.v);
    const Eigen::Matrix4<T> C_V = to_eigen(C) * hat(screw(change<BodyFixed>(C, V)));
    Eigen::Matrix4<T> expected = to_eigen(dC);
    expected(3, 3) = 0;
    rate.expect_equal(C_V, expected, 1);
  });
}

TYPED_TEST(Jacobian, RelativeToTheGroundIsTheJacobianAndRelativeToItselfIsZero) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Comparison to_ground("ground", agreement<T>), to_itself("itself", agreement<T>);
  for_seeds(50, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    const int frame = trial.model.n_frames() - 1;
    const auto J = jacobian_of<Rep, T>(trial, frame);
    to_ground.expect_equal(relative_jacobian_of<Rep, T>(trial, frame, 0), J);
    to_itself.expect_equal(relative_jacobian_of<Rep, T>(trial, frame, frame),
                           std::vector<Twist<Rep, T>>(J.size()), 1);
  });
}

template <class T> class JointScrews : public testing::Test {};
using Scalars = testing::Types<double, float>;
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};
TYPED_TEST_SUITE(JointScrews, Scalars, ScalarNames);

TYPED_TEST(JointScrews, SumUpAlongEveryPathToTheSpatialTwist) {
  using T = TypeParam;
  Comparison twist("twist", agreement<T>);
  for_seeds(200, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    const Model& model = trial.model;
    std::vector<Twist<Spatial, T>> J(static_cast<std::size_t>(model.n_screws()));
    joint_screws(model, trial.workspace, trial.state.q, J);
    std::vector<Twist<Spatial, T>> V(static_cast<std::size_t>(model.n_bodies() + 1));
    for (int i = 1; i <= model.n_bodies(); ++i) {
      V[i] = V[model.body(i).predecessor];
      for (int k = 0; k < static_cast<int>(model.body(i).X.size()); ++k) {
        const T ratio = model.joint(i).leader ? T(model.joint(i).leader->ratio) : T(1);
        V[i] += (ratio * trial.state.v[model.joint(i).iv + k]) * J[model.first_screw(i) + k];
      }
    }
    std::vector<Twist<Spatial, T>> expected = trial.template twists<Spatial>();
    expected.resize(V.size());
    twist.expect_equal(V, expected);
  });
}

TYPED_TEST(JointScrews, AreTheReferenceScrewsCarriedByTheirBodies) {
  using T = TypeParam;
  Comparison screw_of("screw", agreement<T>);
  for_seeds(100, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed), trees};
    const Model& model = trial.model;
    std::vector<Twist<Spatial, T>> J(static_cast<std::size_t>(model.n_screws())), expected;
    joint_screws(model, trial.workspace, trial.state.q, J);
    const std::vector<SE3<T>> C = trial.poses();
    for (int i = 1; i <= model.n_bodies(); ++i)
      for (const Screw<>& X : model.body(i).X)
        expected.push_back(twist<Spatial>(Ad(C[i], Screw<T>{axode::cast<T>(X.w), axode::cast<T>(X.v)})));
    screw_of.expect_equal(J, expected);
  });
}

TEST(JacobianErrors, NameTheArgumentAndTheRule) {
  Trial<double> trial{Random<double>(3), {.most_bodies = 5}};
  const Model& model = trial.model;
  Workspace<>& workspace = trial.workspace;
  const std::vector<double>& q = trial.state.q;
  std::vector<Twist<BodyFixed>> J(static_cast<std::size_t>(model.nv()));
  const std::string nv = std::to_string(model.nv()), one_more = std::to_string(model.nv() + 1);
  const auto with_frame = [&](int frame) {
    return message_of([&] { jacobian(model, workspace, q, frame, J); });
  };
  const std::string frames =
      "; model \"random tree\" has frames 0 to " + std::to_string(model.n_frames() - 1);
  EXPECT_EQ(with_frame(-1), "frame is -1" + frames);
  EXPECT_EQ(with_frame(model.n_frames()), "frame is " + std::to_string(model.n_frames()) + frames);
  EXPECT_EQ(with_frame(0), "no error");
  std::vector<Twist<BodyFixed>> longer(J.size() + 1);
  EXPECT_EQ(message_of([&] { jacobian(model, workspace, q, 1, longer); }),
            "J has " + one_more + " entries; expected nv = " + nv);
  EXPECT_EQ(message_of([&] { jacobian(model, workspace, std::vector<double>(q.size() + 1), 1, J); }),
            "q has " + std::to_string(q.size() + 1) + " entries; expected nq = " + std::to_string(q.size()));
  std::vector<JacobianColumn<BodyFixed>> none;
  const std::string too_short = message_of([&] { jacobian_columns(model, workspace, q, 1, none); });
  EXPECT_EQ(too_short.substr(0, 40), "columns has 0 entries; the path to the p");
  Workspace<> small(one_body());
  EXPECT_EQ(message_of([&] { jacobian(model, small, q, 1, J); }).substr(0, 10), "workspace:");
}

}  // namespace
}  // namespace axode::test
