#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "axode/constraints.hpp"
#include "axode/integration.hpp"
#include "axode/kinematics.hpp"
#include "tests/model/random_loops.hpp"
#include "tests/support/random_tree.hpp"
#include "tests/support/shared_files.hpp"
#include "tests/view/scene_json.hpp"

/// The data for a page describe the mechanism and its motion.
namespace axode::test {
namespace {

using testing::HasSubstr;

double distance(const Eigen::Isometry3d& C, const SE3<>& expected) {
  return (C.matrix() - to_eigen(expected)).cwiseAbs().maxCoeff();
}

Model random_model(std::uint64_t seed) {
  Random<double> random(seed);
  Description tree = described(random_mechanism(random, {.most_bodies = 20}), random);
  for (BodyDescription& body : tree.bodies)
    body.shapes.push_back({.kind = ShapeKind::box, .pose = random.pose(), .size = {1, 2, 3}});
  return ModelBuilder(with_loops(std::move(tree), random)).build();
}

void expect_the_mechanism(const Model& model, std::uint64_t seed) {
  const std::vector<double> q = random_configuration(model, seed);
  const Json scene = scene_of(model, q);
  EXPECT_EQ(scene["format"], "axode scene 1");
  EXPECT_EQ(scene["q"].get<std::vector<double>>(), q);
  Workspace<> workspace(model);
  std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
  poses<double>(model, workspace, q, C);
  double size = 1;
  for (const SE3<>& each : C) size = std::max(size, norm(each.r));
  const std::vector<Eigen::Isometry3d> found = poses_of(scene, q);
  ASSERT_EQ(found.size(), static_cast<std::size_t>(model.n_bodies()) + 1);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT(distance(found[i], C[i]), 1e-12 * size) << i;
  for (std::size_t f = 0; f < scene["frames"].size(); ++f) {
    const Json& frame = scene["frames"][f];
    const std::size_t at = found.size() + f;
    EXPECT_EQ(frame["name"], model.frame(static_cast<int>(at)).name);
    EXPECT_LT(distance(found[frame["body"].get<std::size_t>()] * pose_from(frame["pose"]), C[at]),
              1e-12 * size);
  }
  std::size_t k = model.description().shapes.size();  // those of the ground come first
  for (const BodyDescription& body : model.description().bodies)
    for (const ShapeDescription& shape : body.shapes) {
      if (shape.kind == ShapeKind::mesh) continue;
      const Json& shown = scene["shapes"][k++];
      EXPECT_LT(distance(found[shown["body"].get<std::size_t>()] * pose_from(shown["pose"]),
                         C[model.frame_index(body.name)] * shape.pose),
                1e-12 * (size + norm(shape.pose.r)))
          << body.name;
    }
}

TEST(Scene, PosesOfBodiesFramesAndShapesAreThoseOfTheModel) {
  for (std::uint64_t seed = 1; seed <= 60 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_the_mechanism(random_model(seed), seed);
  }
  for (const auto& file : files_ending_in(AXODE_SOURCE_DIR "/examples/robots", "")) {
    SCOPED_TRACE(file.string());
    for (const Base base : {Base::as_described, Base::free}) {
      if (base == Base::free && file.extension() != ".urdf") continue;
      expect_the_mechanism(load(file, base), 3);
    }
  }
}

TEST(Scene, PosesOfRobotsOfOthersAreThoseOfTheModel) {
  const auto files = files_ending_in(robots_folder(), ".urdf");
  if (files.empty()) GTEST_SKIP() << missing(robots_folder(), "AXODE_ROBOTS");
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    expect_the_mechanism(load(file, Base::free), 5);
  }
}

TEST(Scene, HasWhatTheModelSaysOfJointsMassesAndLoops) {
  for (std::uint64_t seed = 1; seed <= 20 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Model model = random_model(seed);
    const Json scene = scene_of(model, neutral(model));
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Json& body = scene["bodies"][i];
      const Joint& joint = model.joint(i);
      EXPECT_EQ(body["name"], model.body(i).name);
      EXPECT_EQ(body["joint"]["name"], joint.name);
      EXPECT_EQ(body["joint"]["passive"], joint.passive);
      ASSERT_EQ(body["joint"]["limits"].size(), joint.dof.size());
      for (std::size_t d = 0; d < joint.dof.size(); ++d) {
        const Json& lower = body["joint"]["limits"][d][0];
        EXPECT_EQ(lower.is_null() ? -INFINITY : lower.get<double>(), joint.dof[d].lower);
      }
      const auto Theta = body["inertia"].get<std::vector<double>>();
      const auto c = body["com"].get<std::vector<double>>();
      const Inertia<> M = inertia_from_com<double>(
          body["mass"], {c[0], c[1], c[2]}, {Theta[0], Theta[1], Theta[2], Theta[3], Theta[4], Theta[5]});
      const Inertia<>& expected = model.body(i).M;
      EXPECT_EQ(M.m, expected.m);
      EXPECT_LT((to_eigen(M) - to_eigen(expected)).cwiseAbs().maxCoeff(),
                1e-12 * (1 + to_eigen(expected).cwiseAbs().maxCoeff()));
    }
    ASSERT_EQ(scene["loops"].size(), model.loops().joints.size());
    for (std::size_t k = 0; k < scene["loops"].size(); ++k) {
      const Loop& loop = model.loops().joints[k];
      EXPECT_EQ(scene["loops"][k]["kind"], to_string(loop.kind));
      EXPECT_EQ(scene["loops"][k]["pitch"], loop.pitch);
      EXPECT_EQ(scene["loops"][k]["size"], loop.size);
      EXPECT_EQ(scene["loops"][k]["wheel"], loop.wheel);
    }
    ASSERT_EQ(scene["couplings"].size(), model.loops().couplings.size());
    for (std::size_t k = 0; k < scene["couplings"].size(); ++k) {
      const LoopCoupling& coupling = model.loops().couplings[k];
      EXPECT_EQ(scene["couplings"][k]["offset"], coupling.offset);
      ASSERT_EQ(scene["couplings"][k]["terms"].size(), coupling.terms.size());
      for (std::size_t j = 0; j < coupling.terms.size(); ++j)
        EXPECT_EQ(scene["couplings"][k]["terms"][j],
                  Json({coupling.terms[j].coordinate, coupling.terms[j].factor}));
    }
  }
}

TEST(Scene, TheEndsOfAClosedLoopMeet) {
  for (const char* file : {"four_bar.toml", "slider_crank.toml", "bricard.toml", "five_bar_arm.toml"}) {
    const Model model = shipped(file);
    const AssemblyResult closed = assemble(model, neutral(model), std::vector<double>(model.nv()));
    ASSERT_EQ(closed.status, AssemblyStatus::closed) << file;
    const Json scene = scene_of(model, closed.q);
    const std::vector<Eigen::Isometry3d> C = poses_of(scene, closed.q);
    ASSERT_FALSE(scene["loops"].empty());
    for (const Json& loop : scene["loops"]) {
      const auto place = [&](const Json& end) {
        return (C[end["body"].get<std::size_t>()] * pose_from(end["pose"])).translation();
      };
      if (loop["kind"] != "revolute" && loop["kind"] != "spherical") continue;
      EXPECT_LT((place(loop["ends"][0]) - place(loop["ends"][1])).norm(), 1e-8)
          << file << ' ' << loop["name"];
    }
  }
}

ShownMotion shown(const Trajectory& motion) {
  const auto all = [](std::span<const double> x) { return std::vector<double>(x.begin(), x.end()); };
  return {all(motion.t()), all(motion.q()), all(motion.v()), all(motion.a()), all(motion.tau())};
}

/// A motion that begins near the drawn configuration, with loops closed.
ShownMotion motion_of(const Model& model, double until) {
  const AssemblyResult closed =
      assemble(model, neutral(model), std::vector<double>(static_cast<std::size_t>(model.nv()), 0.1));
  const Trajectory motion = simulate(model, closed.q, closed.v, until);
  EXPECT_TRUE(motion.complete) << motion.stop_reason;
  return shown(motion);
}

Eigen::Matrix<double, 6, 1> six(const Json& x) {
  Eigen::Matrix<double, 6, 1> out;
  for (int c = 0; c < 6; ++c) out[c] = x[c].get<double>();
  return out;
}

TEST(SceneOfAMotion, MomentaOfBodiesAddUpAndEnergyIsKept) {
  for (const char* file : {"humanoid.urdf", "arm7.toml", "four_bar.toml", "governor.toml"}) {
    SCOPED_TRACE(file);
    const Model model = shipped(file);
    const ShownMotion motion = motion_of(model, 0.1);
    const Json scene = scene_of(model, neutral(model), {.motion = motion});
    const Json& shown = scene["motion"];
    ASSERT_EQ(shown["t"].size(), motion.t.size());
    const Json &energy = shown["series"][0]["values"], &angular = shown["series"][1]["values"],
               &linear = shown["series"][2]["values"];
    for (std::size_t k = 0; k < motion.t.size(); ++k) {
      Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
      double kinetic = 0;
      for (int i = 0; i < model.n_bodies(); ++i) {
        const Eigen::Matrix<double, 6, 1> Pi = six(shown["momenta"][k][i]), V = six(shown["twists"][k][i]);
        sum += Pi;
        kinetic += Pi.dot(V) / 2;
      }
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(sum[c], angular[k][c].get<double>(), 1e-9);
        EXPECT_NEAR(sum[c + 3], linear[k][c].get<double>(), 1e-9);
      }
      EXPECT_NEAR(energy[k].back().get<double>(), energy[0].back().get<double>(), 1e-5);
      bool armature = false;
      for (const Joint& joint : model.joints())
        for (const Dof& dof : joint.dof) armature = armature || dof.armature != 0;
      if (armature) continue;
      EXPECT_NEAR(kinetic, energy[k][0].get<double>(), 1e-9);
    }
  }
}

/// The power of the wrench that a joint transmits equals the powers of its drive, its spring and its rotor.
void expect_powers_at_joints(const Model& model, const ShownMotion& motion, const Json& scene) {
  const Json& wrenches = scene["motion"]["wrenches"];
  ASSERT_TRUE(wrenches.is_array());
  for (std::size_t k = 0; k < motion.t.size(); ++k) {
    const std::span<const double> q = std::span(motion.q).subspan(k * model.nq(), model.nq());
    const std::vector<Eigen::Isometry3d> C = poses_of(scene, q);
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Joint& joint = model.joint(i);
      const Eigen::Matrix<double, 6, 1> W = six(wrenches[k][i - 1]);
      for (int d = 0; d < joint.nv; ++d) {
        const Dof& dof = joint.dof[d];
        if (joint.leader || (dof.stiffness != 0 && joint.nv > 1)) continue;
        const Screw<> X = Ad(from_eigen<SE3<>>(C[i].matrix()), model.body(i).X[d]);
        const std::size_t c = k * model.nv() + joint.iv + d;
        const double spring = dof.stiffness == 0 ? 0 : -dof.stiffness * (q[joint.iq] - dof.rest),
                     expected = motion.tau[c] + spring - dof.armature * motion.a[c];
        EXPECT_NEAR(W.dot(to_eigen(X)), expected, 1e-8 * (1 + W.norm()))
            << joint.name << " at " << motion.t[k];
      }
    }
  }
}

/// The law of powers holds with and without loops and springs between bodies.
TEST(SceneOfAMotion, JointWrenchesDoThePowerOfDrivesSpringsAndRotors) {
  for (const char* file : {"humanoid.urdf", "arm7.toml", "double_pendulum.toml", "four_bar.toml",
                           "andrews.toml", "governor.toml", "bricard.toml"}) {
    SCOPED_TRACE(file);
    const Model model = shipped(file);
    ShownMotion motion = motion_of(model, 0.02);
    expect_powers_at_joints(model, motion, scene_of(model, neutral(model), {.motion = motion}));
    motion.a.clear();
    EXPECT_TRUE(scene_of(model, neutral(model), {.motion = motion})["motion"]["wrenches"].is_null());
  }
}

/// Loads in every representation on the frame `tip`, and one on another body. Their spatial wrenches are those
/// by hand, and the law of powers holds for a motion under them.
TEST(SceneOfAMotion, LoadsAreShownAndActInTheWrenchesOfJoints) {
  const Vec3<> m{0.3, -0.2, 0.5}, f{2, -1, 3};
  for (const auto& [file, tip] : {std::pair{"arm7.toml", "flange"}, {"four_bar.toml", "tip"}}) {
    SCOPED_TRACE(file);
    const Model model = shipped(file);
    const int frame = model.frame_index(tip);
    SimulationOptions options;
    for (const Representation representation :
         {Representation::body, Representation::spatial, Representation::hybrid, Representation::mixed})
      options.loads.emplace_back(frame, representation, m, f);
    options.loads.emplace_back(1, Representation::spatial, f, m);
    const AssemblyResult closed =
        assemble(model, neutral(model), std::vector<double>(static_cast<std::size_t>(model.nv()), 0.1));
    ShownMotion motion = shown(simulate(model, closed.q, closed.v, 0.02, {}, options));
    motion.loads.assign(motion.t.size(), options.loads);
    const Json scene = scene_of(model, neutral(model), {.motion = motion});
    expect_powers_at_joints(model, motion, scene);
    const Json &places = scene["motion"]["load_frames"], &loads = scene["motion"]["loads"];
    ASSERT_EQ(places.size(), 2U);
    EXPECT_EQ(places[0]["name"], model.frame(1).name);
    EXPECT_EQ(places[1]["name"], tip);
    EXPECT_EQ(places[1]["body"], model.frame(frame).body);
    ASSERT_EQ(loads.size(), motion.t.size());
    for (std::size_t k = 0; k < motion.t.size(); ++k) {
      const std::span<const double> q = std::span(motion.q).subspan(k * model.nq(), model.nq());
      const Eigen::Isometry3d C = poses_of(scene, q)[static_cast<std::size_t>(model.frame(frame).body)] *
                                  Eigen::Isometry3d(to_eigen(model.frame(frame).pose));
      const Eigen::Vector3d M = to_eigen(m), F = to_eigen(f), p = C.translation(), R_m = C.linear() * M,
                            R_f = C.linear() * F;
      Eigen::Matrix<double, 6, 1> expected;
      expected << R_m + p.cross(R_f) + M + M + p.cross(F) + R_m + p.cross(F), R_f + F + F + F;
      EXPECT_LT((six(loads[k][1]) - expected).norm(), 1e-12 * expected.norm());
      expected << F, M;
      EXPECT_LT((six(loads[k][0]) - expected).norm(), 1e-12 * expected.norm());
    }
  }
}

TEST(SceneOfAMotion, ALongOneIsThinnedAndKeepsItsEnds) {
  const Model model = shipped("double_pendulum.toml");
  ShownMotion motion;
  const std::size_t N = 60'001, width = 11 + 2 + 4 + 18 * 2;
  for (std::size_t k = 0; k < N; ++k) motion.t.push_back(1e-3 * static_cast<double>(k));
  motion.q.assign(2 * N, 0.1), motion.v.assign(2 * N, 0.2);
  std::ostringstream out;
  const SceneContents contents = write_scene(model, neutral(model), out, {.motion = motion});
  ASSERT_EQ(contents.warnings.size(), 1U);
  EXPECT_EQ(contents.warnings[0], "warning: motion: has 60001 states; one in 4 is shown");
  const Json shown = Json::parse(out.str())["motion"];
  EXPECT_LT(shown["t"].size() * width, longest_motion);
  EXPECT_EQ(shown["t"].front(), 0.0);
  EXPECT_EQ(shown["t"].back(), motion.t.back());
  EXPECT_EQ(shown["q"].size(), shown["t"].size());
  EXPECT_EQ(shown["twists"].size(), shown["t"].size());
  EXPECT_TRUE(shown["tau"].is_null());
}

std::string refusal(const Model& model, std::span<const double> q, const ShownMotion& motion = {}) {
  try {
    scene_of(model, q, {.motion = motion});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(Scene, RefusesStatesAndMotionsThatDoNotFit) {
  const Model model = shipped("arm7.toml");
  const std::vector<double> q = neutral(model);
  std::vector<double> bad = q;
  bad[3] = std::nan("");
  EXPECT_EQ(refusal(model, bad), "q: it must be finite");
  EXPECT_EQ(refusal(model, std::vector<double>(6)), "q has 6 entries; expected nq = 7");
  const ShownMotion good{{0, 1}, std::vector<double>(14), std::vector<double>(14)};
  EXPECT_EQ(refusal(model, q, good), "none");
  ShownMotion motion = good;
  motion.q.pop_back();
  EXPECT_EQ(refusal(model, q, motion), "motion.q has 13 entries; expected nq for each time = 14");
  motion = good, motion.a = {1};
  EXPECT_EQ(refusal(model, q, motion), "motion.a has 1 entries; expected nv for each time = 14");
  motion = good, motion.t = {1, 1};
  EXPECT_EQ(refusal(model, q, motion), "motion.t: time 1 is 1 after 1; times must increase");
  motion = good, motion.v[9] = INFINITY;
  EXPECT_EQ(refusal(model, q, motion), "motion.v: number 9 is inf; it must be finite");
  motion = good, motion.loads.resize(1);
  EXPECT_EQ(refusal(model, q, motion), "motion.loads has 1 entries; expected a list for each time = 2");
  motion = good, motion.loads = {{{99, Representation::body, {}, {}}}, {}};
  EXPECT_EQ(refusal(model, q, motion), "motion.loads: there is no frame 99");
  motion = good, motion.loads = {{{1, Representation::body, {NAN, 0, 0}, {}}}, {}};
  EXPECT_EQ(refusal(model, q, motion), "motion.loads: a number is not finite");
  motion = good, motion.v.assign(14, 1e200);
  EXPECT_THAT(refusal(model, q, motion), HasSubstr("overflow"));
  const Model humanoid = load(AXODE_SOURCE_DIR "/examples/robots/humanoid.urdf", Base::free);
  motion = {{0}, std::vector<double>(humanoid.nq()), std::vector<double>(humanoid.nv())};
  EXPECT_THAT(refusal(humanoid, neutral(humanoid), motion), HasSubstr("motion.q"));
}

constexpr const char* empty_page =
    "<html>\n<script id=\"scene\" type=\"application/json\">null</script>\n<script>run()</script></html>\n";

TEST(Page, HoldsTheSceneAndNoNameEndsItsElement) {
  const std::string hostile = "</script><script>alert(1)</script><!-- & \u2028\u2029 \xff \"quoted\"";
  const Model model = ModelBuilder(hostile)
                          .add(BodyDescription{.name = hostile,
                                               .joint = {.kind = JointKind::revolute},
                                               .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}},
                                               .shapes = {{.name = hostile, .radius = 1}}})
                          .build();
  std::ostringstream out;
  write_page(empty_page, model, neutral(model), out, {.live = "</script>"});
  const std::string page = out.str(), before = "type=\"application/json\">";
  const std::size_t from = page.find(before) + before.size(), to = page.find("</script>");
  EXPECT_EQ(page.substr(0, from) + "null" + page.substr(to), empty_page);
  const std::string text = page.substr(from, to - from);
  EXPECT_EQ(text.find_first_of("<>&"), std::string::npos);
  EXPECT_TRUE(std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; }));
  const Json scene = Json::parse(text);
  std::string readable = hostile;
  readable.replace(readable.find('\xff'), 1, "\uFFFD");
  EXPECT_EQ(scene["name"], readable);
  EXPECT_EQ(scene["bodies"][1]["name"], readable);
  EXPECT_EQ(scene["shapes"][0]["name"], readable);
  EXPECT_EQ(scene["live"], "</script>");
}

TEST(Page, RefusesAPageWithoutAPlaceForTheScene) {
  const Model model = shipped("arm7.toml");
  std::ostringstream out;
  for (const std::string page :
       {"", "<html></html>", "<script id=\"scene\" type=\"application/json\">{}</script>"})
    EXPECT_THROW(write_page(page, model, neutral(model), out), std::invalid_argument) << page;
  EXPECT_EQ(out.str(), "");
}

TEST(FirstConfiguration, ClosesLoopsThatCanBeClosed) {
  for (const std::string name :
       {"andrews.toml", "bricard.toml", "cart.toml", "five_bar_arm.toml", "four_bar.toml", "gough.toml",
        "governor.toml", "leg.toml", "n_four_bar.toml", "slider_crank.toml"}) {
    const Model model = shipped(name);
    const std::vector<double> q = first_configuration(model);
    std::vector<double> r(static_cast<std::size_t>(model.loops().residuals));
    LoopWorkspace<> workspace(model);
    loop_residual<double>(model, workspace, q, r);
    for (const double x : r) EXPECT_LT(std::abs(x), 1e-10) << name;
  }
  const Model arm = shipped("arm7.toml");
  EXPECT_EQ(first_configuration(arm), neutral(arm));
}

}  // namespace
}  // namespace axode::test
