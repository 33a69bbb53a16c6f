#include <Eigen/SVD>
#include <numeric>

#include "axode/io.hpp"
#include "tests/kinematics/derivatives.hpp"
#include "tests/support/refused_arguments.hpp"

/// Inverse kinematics finds configurations in which places have given poses.
namespace axode::test {
namespace {

using enum InverseKinematicsStatus;

Model example(const std::string& file, Base base = Base::as_described) {
  return load(AXODE_SOURCE_DIR "/examples/robots/" + file, base);
}

/// Computes poses of frames of a model.
class PosesOf {
 public:
  explicit PosesOf(const Model& model)
      : model_(model), workspace_(model), C_(static_cast<std::size_t>(model.n_frames())) {}
  SE3<> operator()(const std::vector<double>& q, const Place<>& place) {
    poses(model_, workspace_, q, C_);
    return C_[static_cast<std::size_t>(place.frame)] * place.offset;
  }

 private:
  Model model_;
  Workspace<> workspace_;
  std::vector<SE3<>> C_;
};

/// The weighted error of a configuration, as the header defines it.
double residual_of(const Model& model, std::span<const PoseTarget> targets, const std::vector<double>& q) {
  PosesOf pose(model);
  double sum = 0;
  for (const PoseTarget& target : targets) {
    const SE3<> C = pose(q, target.place);
    const Screw<> X = log(inverse(C) * target.pose);
    const Vec3<> linear = target.angular_weight > 0 ? X.v : target.pose.r - C.r;
    sum += std::pow(target.angular_weight * norm(X.w), 2) + std::pow(target.linear_weight * norm(linear), 2);
  }
  return std::sqrt(sum);
}
bool within_limits(const Model& model, const std::vector<double>& q) { return clamp(model, q) == q; }

TEST(InverseKinematics, ReachesNearlyEveryPoseThatTheArmCanTake) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange"), count = 10000;
  const std::vector<double> start = neutral(arm);
  PosesOf pose(arm);
  int reached = 0, at_first = 0;
  for (int k = 1; k <= count; ++k) {
    const PoseTarget target{.place = tool, .pose = pose(random_configuration(arm, 1000000 + k), tool)};
    const InverseKinematicsResult result = inverse_kinematics(arm, {{target}}, start);
    EXPECT_TRUE(within_limits(arm, result.q)) << "target " << k;
    EXPECT_NEAR(result.residual, residual_of(arm, {{target}}, result.q), 1e-13) << "target " << k;
    EXPECT_EQ(result.status == solved, result.residual <= 1e-9) << "target " << k;
    reached += result.status == solved, at_first += result.status == solved && result.restarts == 0;
  }
  RecordProperty("reached", reached);
  RecordProperty("reached_from_the_first_start", at_first);
  EXPECT_GE(reached, count * 99 / 100);
}

TEST(InverseKinematics, OfAPositionLeavesTheOrientationFree) {
  const Model arm = example("arm7.toml");
  const Place<> tip(arm.frame_index("flange"), Vec3<>{0, 0, 0.1});
  PosesOf pose(arm);
  for (int k = 1; k <= 200; ++k) {
    const Vec3<> r = pose(random_configuration(arm, k), tip).r;
    const PoseTarget target{.place = tip, .pose = {{}, r}, .angular_weight = 0};
    const auto result = inverse_kinematics(arm, {{target}}, neutral(arm));
    EXPECT_EQ(result.status, solved);
    EXPECT_LE(norm(pose(result.q, tip).r - r), 1e-9);
  }
}

TEST(InverseKinematics, OfAnOrientationLeavesThePositionFree) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  PosesOf pose(arm);
  for (int k = 1; k <= 200; ++k) {
    const SO3<> R = pose(random_configuration(arm, k), tool).R;
    const PoseTarget target{.place = tool, .pose = {R, {5, 5, 5}}, .linear_weight = 0};
    const auto result = inverse_kinematics(arm, {{target}}, neutral(arm));
    EXPECT_EQ(result.status, solved);
    EXPECT_LE(norm(log_SO3(transpose(pose(result.q, tool).R) * R)), 1e-9);
  }
}

TEST(InverseKinematics, TakesSeveralPlacesAtOnce) {
  const Model humanoid = example("humanoid.urdf");
  const int left = humanoid.frame_index("left_palm"), right = humanoid.frame_index("right_palm");
  PosesOf pose(humanoid);
  for (int k = 1; k <= 20; ++k) {
    const std::vector<double> q = random_configuration(humanoid, k);
    const PoseTarget targets[] = {
        {.place = left, .pose = pose(q, left)},
        {.place = right, .pose = pose(q, right), .angular_weight = 0.3, .linear_weight = 2}};
    const auto result = inverse_kinematics(humanoid, targets, neutral(humanoid));
    EXPECT_EQ(result.status, solved) << "target " << k;
    EXPECT_LE(residual_of(humanoid, targets, result.q), 1e-9);
    EXPECT_TRUE(within_limits(humanoid, result.q));
  }
}

TEST(InverseKinematics, MovesAFreeBaseAsWell) {
  const Model humanoid = example("humanoid.urdf", Base::free);
  const char* const places[] = {"left_sole", "right_sole", "left_palm", "right_palm"};
  PosesOf pose(humanoid);
  for (int k = 1; k <= 10; ++k) {
    const std::vector<double> q = random_configuration(humanoid, k);
    std::vector<PoseTarget> targets;
    for (const char* name : places) {
      const int frame = humanoid.frame_index(name);
      targets.push_back({.place = frame, .pose = pose(q, frame)});
    }
    const auto result = inverse_kinematics(humanoid, targets, neutral(humanoid), {.iterations = 200});
    EXPECT_EQ(result.status, solved) << "target " << k;
    EXPECT_LE(residual_of(humanoid, targets, result.q), 1e-9);
    EXPECT_NO_THROW(check_configuration(humanoid, result.q)) << "unit quaternions";
  }
}

/// Trees with spherical, planar, free and coupled joints.
TEST(InverseKinematics, ReachesWhatARandomTreeReaches) {
  int reached = 0, count = 0;
  for_seeds(300, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Model model = random_model(random, {.most_bodies = 12});
    const Place<> place = random_place(model, random);
    const PoseTarget target{.place = place, .pose = PosesOf(model)(random_configuration(model, seed), place)};
    const auto result = inverse_kinematics(model, {{target}}, neutral(model));
    EXPECT_NEAR(result.residual, residual_of(model, {{target}}, result.q), 1e-13);
    EXPECT_EQ(result.status == solved, result.residual <= 1e-9);
    reached += result.status == solved, ++count;
  });
  EXPECT_GE(reached, count * 99 / 100);
}

TEST(InverseKinematics, SaysThatAPlaceIsOutOfReachAndHowFar) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  const double reach = 0.42 + 0.4 + 0.126;  // from the shoulder at (0, 0, 0.36)
  for (const Vec3<>& direction : {Vec3<>{1, 0, 0}, Vec3<>{0, 0.6, 0.8}, Vec3<>{-0.6, 0, 0.8}}) {
    const PoseTarget target{
        .place = tool, .pose = {{}, Vec3<>{0, 0, 0.36} + 2.0 * direction}, .angular_weight = 0};
    const auto result = inverse_kinematics(arm, {{target}}, neutral(arm), {.restarts = 10});
    EXPECT_NE(result.status, solved);
    EXPECT_EQ(result.restarts, 10);
    EXPECT_GE(result.residual, 2 - reach - 1e-12);
    EXPECT_LE(result.residual, (2 - reach) * 1.001);
    EXPECT_TRUE(within_limits(arm, result.q));
  }
  const PoseTarget far{.place = tool, .pose = {{}, {1e6, 0, 0}}};
  const auto result = inverse_kinematics(arm, {{far}}, neutral(arm), {.restarts = 3});
  EXPECT_NE(result.status, solved);
  EXPECT_TRUE(std::isfinite(result.residual));
}

TEST(InverseKinematics, KeepsTheLimitsUnlessToldOtherwise) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  const std::vector<double> beyond{0.3, 0.4, 0.1, 2.6, 0.2, 0.5, 0.3};  // the limit of A4 is 2.0944
  const PoseTarget target{.place = tool, .pose = PosesOf(arm)(beyond, tool)};
  const auto kept = inverse_kinematics(arm, {{target}}, beyond);
  EXPECT_TRUE(within_limits(arm, kept.q));
  EXPECT_NE(kept.status, solved) << "the elbow alone decides how far the wrist is from the shoulder";
  const auto free = inverse_kinematics(arm, {{target}}, beyond, {.limits = false});
  EXPECT_EQ(free.status, solved);
  EXPECT_EQ(free.q, beyond);
  EXPECT_EQ(free.iterations, 0);
}

double distance(const Model& model, const std::vector<double>& q, const std::vector<double>& posture) {
  const std::vector<double> way = difference(model, q, posture);
  return std::sqrt(std::inner_product(way.begin(), way.end(), way.begin(), 0.0));
}

/// The direction in which the joints of the arm can move while its flange is at rest.
Eigen::VectorXd self_motion(const Model& arm, const std::vector<double>& q) {
  Workspace<> workspace(arm);
  std::vector<Twist<BodyFixed>> columns(7);
  jacobian(arm, workspace, q, arm.frame_index("flange"), columns);
  Eigen::Matrix<double, 6, 7> J;
  for (int c = 0; c < 7; ++c) J.col(c) = to_eigen(columns[c]);
  return Eigen::JacobiSVD<Eigen::MatrixXd>(J, Eigen::ComputeFullV).matrixV().col(6);
}

TEST(InverseKinematics, StaysOnTheTargetAndComesAsNearAPostureAsItCan) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  const CoordinateLimits limit = limits(arm);
  const std::vector<double> posture{0.2, 0.5, -0.3, 0.9, 0.1, -0.4, 0.3};
  PosesOf pose(arm);
  int nearer = 0, inside = 0;
  for (int k = 1; k <= 100; ++k) {
    SCOPED_TRACE("target " + std::to_string(k));
    const PoseTarget target{.place = tool, .pose = pose(random_configuration(arm, k), tool)};
    const auto plain = inverse_kinematics(arm, {{target}}, neutral(arm));
    const auto near = inverse_kinematics(arm, {{target}}, neutral(arm), {.posture = posture});
    ASSERT_EQ(near.status, solved);
    EXPECT_LE(residual_of(arm, {{target}}, near.q), 1e-9);
    EXPECT_TRUE(within_limits(arm, near.q));
    EXPECT_LE(distance(arm, near.q, posture), distance(arm, plain.q, posture));
    nearer += distance(arm, near.q, posture) < 0.999 * distance(arm, plain.q, posture);

    bool at_limit = false;
    for (std::size_t c = 0; c < 7; ++c)
      at_limit = at_limit || near.q[c] - limit.lower[c] < 1e-3 || limit.upper[c] - near.q[c] < 1e-3;
    if (at_limit) continue;
    ++inside;
    const std::vector<double> way = difference(arm, near.q, posture);
    EXPECT_LE(std::abs(self_motion(arm, near.q).dot(Eigen::VectorXd(as_eigen(std::span(way))))), 0.01);
  }
  EXPECT_GE(nearer, 75) << "the others happen to be there already";
  EXPECT_GE(inside, 75);
}

TEST(InverseKinematics, TakesThePostureItselfWhereTheTargetAllowsIt) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  const std::vector<double> posture{0.2, 0.5, -0.3, 0.9, 0.1, -0.4, 0.3},
      start{0.3, 0.4, -0.4, 0.8, 0.2, -0.3, 0.2};
  const PoseTarget target{.place = tool, .pose = PosesOf(arm)(posture, tool)};
  const auto result = inverse_kinematics(arm, {{target}}, start, {.posture = posture});
  EXPECT_EQ(result.status, solved);
  EXPECT_LE(distance(arm, result.q, posture), 1e-3);
}

TEST(InverseKinematics, OfOneSeedIsOneResult) {
  const Model arm = example("arm7.toml");
  const int tool = arm.frame_index("flange");
  const PoseTarget target{.place = tool, .pose = PosesOf(arm)(random_configuration(arm, 3), tool)};
  const InverseKinematicsOptions no_patience{.iterations = 4, .restarts = 30};
  const auto first = inverse_kinematics(arm, {{target}}, neutral(arm), no_patience);
  const auto second = inverse_kinematics(arm, {{target}}, neutral(arm), no_patience);
  EXPECT_GT(first.restarts, 0);
  EXPECT_EQ(first.q, second.q);
  EXPECT_EQ(first.iterations, second.iterations);
}

TEST(InverseKinematics, OfWhatCannotMoveComparesAndStops) {
  const Model statue =
      ModelBuilder("statue").add({.name = "block", .joint = {.kind = JointKind::fixed}}).build();
  const PoseTarget here{.place = 0, .pose = {}}, there{.place = 0, .pose = {{}, {0, 0, 2}}};
  EXPECT_EQ(inverse_kinematics(statue, {{here}}, {}).status, solved);
  const auto result = inverse_kinematics(statue, {{there}}, {}, {.restarts = 0});
  EXPECT_EQ(result.status, stalled);
  EXPECT_EQ(result.residual, 2);
}

TEST(InverseKinematicsErrors, NameTheArgumentTheValueAndTheRule) {
  const Model arm = example("arm7.toml");
  const PoseTarget good{.place = 1, .pose = {}};
  const auto with = [&](const PoseTarget& target, const InverseKinematicsOptions& options = {}) {
    return message_of([&] { static_cast<void>(inverse_kinematics(arm, {{target}}, neutral(arm), options)); });
  };
  const std::string where = "inverse_kinematics: ";
  EXPECT_EQ(message_of([&] { static_cast<void>(inverse_kinematics(arm, {}, neutral(arm))); }),
            where + "targets is empty; name at least one pose to reach");
  EXPECT_EQ(message_of([&] { static_cast<void>(inverse_kinematics(arm, {{good}}, std::vector<double>(3))); }),
            "q0 has 3 entries; expected nq = 7");
  EXPECT_EQ(message_of([&] {
              static_cast<void>(inverse_kinematics(arm, {{good}}, std::vector<double>(7, std::nan(""))));
            }),
            where + "q0 is not finite");
  EXPECT_EQ(with({.place = 99, .pose = {}}).substr(0, 12), "frame is 99;");
  EXPECT_EQ(with({.place = 1, .pose = {}, .angular_weight = -1}),
            where + "a weight is -1; it must not be negative");
  EXPECT_EQ(with({.place = 1, .pose = {{}, {std::nan(""), 0, 0}}}),
            where + "a target position is not finite");
  const SO3<> twice{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}, mirror{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const SO3<>& R : {twice, mirror})
    EXPECT_EQ(with({.place = 1, .pose = {R, {}}}).substr(0, 55),
              where + "a target rotation is off a rotation");
  EXPECT_EQ(with(good, {.tolerance = 0}), where + "tolerance is 0; it must be positive");
  EXPECT_EQ(with(good, {.iterations = 0}), where + "iterations is 0; it must be positive");
  EXPECT_EQ(with(good, {.restarts = -1}), where + "restarts is -1; it must not be negative");
  const std::vector<double> short_posture(2);
  EXPECT_EQ(with(good, {.posture = short_posture}), "posture has 2 entries; expected nq = 7");
  EXPECT_EQ(to_string(solved), "solved");
  EXPECT_EQ(to_string(stalled), "stalled");
  EXPECT_EQ(to_string(iteration_limit), "iteration_limit");
}

}  // namespace
}  // namespace axode::test
