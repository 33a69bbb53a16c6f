#include "axode/integration.hpp"
#include "tests/vectors/reference_state.hpp"

/// Motions of every reference system under constant drive forces, to 20 digits.
namespace axode::test {
namespace {

std::vector<std::string> motion_files() {
  std::vector<std::string> names;
  for (const auto& file : files_ending_in(vectors_folder(), ".json"))
    if (const std::string name = file.stem().string(); name.find("_trajectory") != std::string::npos)
      names.push_back(name);
  return names.empty() ? std::vector{none} : names;
}

class ReferenceMotions : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == none) GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ReferenceMotions, testing::ValuesIn(motion_files()), name_of);

/// The system of `<system>_trajectory1.json`, or of `multidof1_floating_trajectory.json`.
ReferenceSystem system_of(const std::string& motion) {
  const std::string name = motion.substr(0, motion.find("_trajectory"));
  const auto file = vectors_folder() / (name + ".json");
  return std::filesystem::exists(file) ? ReferenceSystem(name, read_json(file).at("model"))
                                       : ReferenceSystem(name);
}

TEST_P(ReferenceMotions, AreMet) {
  const Json file = read_json(vectors_folder() / (GetParam() + ".json"));
  const ReferenceSystem system = system_of(GetParam());
  const Model model = system.build(Telling::joint_frames);
  const auto number_of = [](const Json& x, std::size_t k) { return number(x.is_array() ? x.at(k) : x); };
  const auto velocities = [&](const Json& x) {
    std::vector<double> out(static_cast<std::size_t>(model.nv()));
    std::size_t k = 0;
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Joint& joint = model.joint(model.joint_index(ReferenceSystem::joint_name(i)));
      for (int c = 0; c < joint.nv; ++c) out[static_cast<std::size_t>(joint.iv + c)] = number(x.at(k++));
    }
    return out;
  };
  const auto coordinates = [&](const Json& x) {
    std::vector<double> out(static_cast<std::size_t>(model.nq()));
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const Joint& joint = model.joint(model.joint_index(ReferenceSystem::joint_name(i)));
      for (int c = 0; c < joint.nq; ++c)
        out[static_cast<std::size_t>(joint.iq + c)] =
            number_of(x.at(static_cast<std::size_t>(i) - 1), static_cast<std::size_t>(c));
    }
    return out;
  };
  const std::vector<double> tau = velocities(file.at("tau0"));
  const Json& first = file.at("samples").at(0);
  SimulationOptions options;
  options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> out) {
    std::ranges::copy(tau, out.begin());
  };
  const Trajectory motion = simulate(model, coordinates(first.at("q")), velocities(first.at("v")), 1.0,
                                     {.relative = 1e-12, .absolute = 1e-12}, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Comparison pose("C", 1e-9), velocity("v", 1e-9);
  Workspace<> workspace(model);
  for (const Json& sample : file.at("samples")) {
    std::vector<double> q(static_cast<std::size_t>(model.nq())), v(static_cast<std::size_t>(model.nv()));
    motion.at(number(sample.at("t")), q, v);
    velocity.expect_equal(v, velocities(sample.at("v")));
    std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
    poses<double>(model, workspace, q, C);
    for (int i = 1; i <= model.n_bodies(); ++i) {
      const SE3<> expected = se3(sample.at("C").at(static_cast<std::size_t>(i) - 1));
      const SE3<>& found = C[static_cast<std::size_t>(ReferenceSystem::frame(model, i))];
      for (const auto& [x, y] :
           {std::pair{found.R.x, expected.R.x}, {found.R.y, expected.R.y}, {found.r, expected.r}})
        pose.expect_equal(std::vector{x.x, x.y, x.z}, std::vector{y.x, y.y, y.z}, 1.0);
    }
  }
}

/// Simulates a top that turns on a spherical joint or is free, and compares it with the motion in
/// heavy_top.json or free_top.json.
void expect_top(const Json& top, const Json& inertia, JointKind kind, double until, double bound_of_pose) {
  const auto diagonal = [&](const Json& x) {
    return Sym3<>{number(x.at(0)), number(x.at(1)), number(x.at(2)), 0, 0, 0};
  };
  Description description{.name = "top"};
  description.gravity = top.contains("gravity") ? vec3(top.at("gravity")) : Vec3<>{};
  BodyDescription body{.name = "top", .predecessor = "ground"};
  body.joint = {.name = "point", .kind = kind};
  body.inertia = MassProperties{.mass = top.contains("mass") ? number(top.at("mass")) : 1,
                                .com = top.contains("com") ? vec3(top.at("com")) : Vec3<>{},
                                .Theta = diagonal(inertia)};
  description.bodies.push_back(body);
  const Model model = ModelBuilder(description).build();
  std::vector<double> q = neutral(model), v(static_cast<std::size_t>(model.nv()));
  const Vec3<> w = vec3(top.at("omega0"));
  v[0] = w.x, v[1] = w.y, v[2] = w.z;
  const Trajectory motion = simulate(model, q, v, until, {.relative = 1e-13, .absolute = 1e-13});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Workspace<> workspace(model);
  std::size_t met = 0;
  for (const Json& sample : top.at("samples")) {
    const double t = number(sample.at("t"));
    if (t > until) break;
    ++met;
    motion.at(t, q, v);
    std::vector<SE3<>> C(static_cast<std::size_t>(model.n_frames()));
    poses<double>(model, workspace, q, C);
    const SO3<> R = C[static_cast<std::size_t>(model.frame_index("top"))].R, expected = so3(sample.at("R"));
    for (const auto& [x, y] : {std::pair{R.x, expected.x}, {R.y, expected.y}, {R.z, expected.z}})
      EXPECT_LE(norm(x - y), bound_of_pose) << "at " << t;
    EXPECT_LE(norm(Vec3<>{v[0], v[1], v[2]} - vec3(sample.at("omega"))), bound_of_pose * (1 + norm(w)));
  }
  EXPECT_GT(met, 2u);
}

TEST(ReferenceTops, AreMet) {
  const auto heavy = vectors_folder() / "heavy_top.json", free = vectors_folder() / "free_top.json";
  if (!std::filesystem::exists(heavy) || !std::filesystem::exists(free))
    GTEST_SKIP() << missing(vectors_folder(), "AXODE_VECTORS");
  const Json top_on_a_point = read_json(heavy);
  expect_top(top_on_a_point, top_on_a_point.at("inertia_about_com"), JointKind::spherical, 1, 1e-8);
  const Json file = read_json(free);
  for (const Json& top : file.at("cases")) {
    expect_top(top, file.at("inertia"), JointKind::spherical, 10, 1e-8);
    expect_top(top, file.at("inertia"), JointKind::free, 10, 1e-8);
  }
}

}  // namespace
}  // namespace axode::test
