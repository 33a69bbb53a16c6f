#include <gtest/gtest.h>
#include <pthread.h>

#include <functional>
#include <map>

#include "axode/dynamics.hpp"
#include "tests/model/random_mechanism.hpp"

/// Mechanisms of ten thousand bodies, in a row or all on one body: building takes time in proportion to the
/// number of bodies and no deep recursion.
namespace axode::test {
namespace {

/// A tree of n bodies. The predecessor of body i is the earlier body predecessor_of(i), or the ground if that
/// is negative.
Description tree(int n, const std::function<int(int)>& predecessor_of) {
  Description description{.name = "large"};
  for (int i = 0; i < n; ++i) {
    const int p = predecessor_of(i);
    description.bodies.push_back({.name = numbered('b', i),
                                  .predecessor = p < 0 ? "ground" : numbered('b', p),
                                  .joint = {.name = numbered('j', i),
                                            .kind = one_dof_kinds[static_cast<std::size_t>(i) % 2],
                                            .axis = {0.3, 1, 0},
                                            .point = {0.001 * i, 0, 0}},
                                  .geometry = InConstructionFrame{{{}, {0.001 * i, 0, 0}}},
                                  .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1, 0, 0, 0}}});
  }
  return description;
}
Description chain(int n) {
  return tree(n, [](int i) { return i - 1; });
}
Description backward_chain(int n) {  // its bodies are declared from the tip to the root
  Description description = chain(n);
  std::ranges::reverse(description.bodies);
  return description;
}
Description star(int n) {
  return tree(n, [](int i) { return i == 0 ? -1 : 0; });
}
Description forest(int n) {
  return tree(n, [](int) { return -1; });
}
Description fixed_chain(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies)
    if (body.name != "b0") body.joint.kind = JointKind::fixed;
  return description;
}
Description chain_of_split_joints(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies) body.joint.kind = JointKind::cylindrical;
  return description;
}
Description couplings_on_one_joint(int n) {
  Description description = star(n);
  for (BodyDescription& body : description.bodies)
    if (body.name != "b0") body.joint.coupling = Coupling{"j0"};
  return description;
}
Description chain_of_couplings(int n) {  // each joint follows the next one, which is declared after it
  Description description = star(n);
  for (int i = 0; i + 1 < n; ++i) description.bodies[i].joint.coupling = Coupling{numbered('j', i + 1)};
  return description;
}
Description nothing_but_faults(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies)
    body.predecessor = "x" + body.name, body.inertia->mass = -1,
    body.joint.coupling = Coupling{"k" + body.name};
  return description;
}
Description ring_of_couplings(int n) {
  Description description = star(n);
  for (int i = 0; i < n; ++i) description.bodies[i].joint.coupling = Coupling{numbered('j', (i + 1) % n)};
  return description;
}
Description ring(int n) {
  Description description = chain(n);
  description.bodies[0].predecessor = numbered('b', n - 1);
  return description;
}
Description many_frames(int n) {
  Description description = chain(10);
  for (int k = 0; k < n; ++k) description.frames.push_back({.name = numbered('f', k), .body = "b9"});
  return description;
}
/// A spring on a line and one on a coordinate for every body.
Description springs_on_every_body(int n) {
  Description description = forest(n);
  for (int k = 0; k < n; ++k) {
    description.springs.push_back({.between = {"ground", numbered('b', k)}, .stiffness = 1, .rest = 1});
    SpringDescription turn{.kind = SpringKind::joints, .stiffness = 1};
    turn.terms = {{numbered('j', k), 1.0}};
    description.springs.push_back(turn);
  }
  return description;
}
/// A controller on every body but the first, whose input is the output of the next one.
Description chain_of_drives(int n) {
  Description description = forest(n);
  for (int k = 1; k < n; ++k) {
    DriveDescription drive{.name = numbered('d', k), .kind = DriveKind::pid};
    drive.joints = {{numbered('j', k), 1.0}};
    drive.parameters = {{"kp", 1.0}};
    if (k + 1 < n)
      drive.input.from = numbered('d', k + 1);
    else
      drive.input.values = {0};
    description.drives.push_back(std::move(drive));
  }
  return description;
}
Description ring_of_drives(int n) {
  Description description = chain_of_drives(n);
  description.drives.back().input.values.clear();
  description.drives.back().input.from = "d1";
  return description;
}

struct Shape {
  const char* name;
  Description (*make)(int n);
  std::vector<Rule> faults_of_each = {};  ///< the faults that each body has, or each drive if there are any
  std::vector<Rule> faults_of_all = {};
};
class LargeTrees : public testing::TestWithParam<Shape> {};

/// The processor time for building a description, in seconds: the least of some runs.
double build_time(const Description& description, int runs) {
  double least = 1e9;
  for (int run = 0; run < runs; ++run) {
    const std::clock_t start = std::clock();
    try {
      ModelBuilder(description).build();
    } catch (const ModelError&) {
    }
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

/// Sixteen times the bodies take 30 to 60 times as long, because they do not fit in the processor's cache.
/// Time that grows with the square of the size would be at least 256 times as long.
TEST_P(LargeTrees, AreNotBuiltInTimeThatGrowsWithTheSquareOfTheirSize) {
  const double small = build_time(GetParam().make(1250), 3), large = build_time(GetParam().make(20'000), 1);
  EXPECT_LT(large / small, 100) << "1,250 bodies took " << small << " s, and 20,000 took " << large << " s";
  EXPECT_LT(large, 5);
}

/// Runs a function on a stack of 256 KiB, on which ten thousand nested calls do not fit.
void on_small_stack(std::function<void()> function) {
  pthread_attr_t attributes;
  pthread_t thread;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 256 * 1024), 0);
  const auto run = [](void* f) -> void* {
    (*static_cast<std::function<void()>*>(f))();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, run, &function), 0);
  ASSERT_EQ(pthread_join(thread, nullptr), 0);
  pthread_attr_destroy(&attributes);
}

TEST_P(LargeTrees, NeedNoDeepRecursion) {
  const Description description = GetParam().make(10'000);
  on_small_stack([&] {
    try {
      const Model model = ModelBuilder(description).build();
      Workspace<double> workspace(model);
      const std::vector<double> q = neutral(model), zero(model.nv());
      std::vector<SE3<>> C(model.n_frames());
      std::vector<double> tau(model.nv());
      poses(model, workspace, q, C);
      inverse_dynamics(model, workspace, q, zero, zero, tau);
      const std::string_view locked[] = {model.joint(1).name};
      EXPECT_TRUE(GetParam().faults_of_each.empty() && GetParam().faults_of_all.empty());
      if (!model.joint(1).leader) {
        EXPECT_EQ(reduced(model, locked, q).n_frames(), model.n_frames());
      }
    } catch (const ModelError& error) {
      std::map<Rule, std::size_t> found, expected;
      for (const Fault& fault : error.faults()) {
        ++found[fault.rule];
        EXPECT_LT(fault.message.size(), 500u);
      }
      const std::size_t elements =
          description.drives.empty() ? description.bodies.size() : description.drives.size();
      for (const Rule rule : GetParam().faults_of_each) expected[rule] += elements;
      for (const Rule rule : GetParam().faults_of_all) ++expected[rule];
      EXPECT_EQ(found, expected);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(
    , LargeTrees,
    testing::Values(Shape{"chain", chain}, Shape{"backward_chain", backward_chain}, Shape{"star", star},
                    Shape{"forest", forest}, Shape{"fixed_chain", fixed_chain},
                    Shape{"chain_of_split_joints", chain_of_split_joints},
                    Shape{"couplings_on_one_joint", couplings_on_one_joint},
                    Shape{"chain_of_couplings", chain_of_couplings},
                    Shape{"nothing_but_faults",
                          nothing_but_faults,
                          {Rule::unknown_predecessor, Rule::mass_not_positive, Rule::coupling_unknown_joint}},
                    Shape{"ring", ring, {}, {Rule::cycle}},
                    Shape{"ring_of_couplings", ring_of_couplings, {Rule::coupling_loop}},
                    Shape{"many_frames", many_frames}, Shape{"springs_on_every_body", springs_on_every_body},
                    Shape{"chain_of_drives", chain_of_drives},
                    Shape{"ring_of_drives", ring_of_drives, {Rule::cycle}}),
    [](const auto& shape) { return std::string(shape.param.name); });

TEST(LargeTree, AChainOfTenThousandBodiesIsEvaluatedRight) {
  const int n = 10'000;
  const Model model = ModelBuilder(chain(n)).build();
  ASSERT_EQ(model.n_bodies(), n);
  for (int i = 1; i <= n; ++i) ASSERT_EQ(model.body(i).predecessor, i - 1);
  Workspace<double> workspace(model);
  const std::vector<double> q = neutral(model), zero(model.nv());
  std::vector<SE3<>> C(model.n_frames());
  poses(model, workspace, q, C);
  EXPECT_NEAR(C[n].r.x, 0.001 * (n - 1), 1e-9);
  std::vector<Wrench<Hybrid>> W(n);
  joint_wrenches<Hybrid>(model, workspace, q, zero, zero, W);
  EXPECT_NEAR(W[0].f.z, 9.81 * n, 1e-6) << "the first joint carries all of the weight";
  EXPECT_NEAR(W[0].m.y, -9.81 * 0.001 * (n - 1.0) * n / 2, 1e-4);
  EXPECT_NEAR(W[n - 1].f.z, 9.81, 1e-12) << "the last one its own";
}

}  // namespace
}  // namespace axode::test
