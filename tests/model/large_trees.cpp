#include <gtest/gtest.h>
#include <pthread.h>

#include <functional>
#include <map>

#include "axode/dynamics.hpp"
#include "tests/model/large_mechanisms.hpp"
#include "tests/support/counted_work.hpp"

/// Mechanisms of many bodies, in a row or all on one body: building takes work in proportion to the number of
/// bodies and no deep recursion.
namespace axode::test {
namespace {

Description nothing_but_faults(int n) {
  Description description = chain(n);
  for (BodyDescription& body : description.bodies)
    body.predecessor = "x" + body.name, body.inertia->mass = -1,
    body.joint.coupling = Coupling{"k" + body.name};
  return description;
}
Description ring_of_couplings(int n) {
  Description description = star(n);
  for (int i = 0; i < n; ++i) description.bodies[i].joint.coupling = Coupling{named('j', (i + 1) % n)};
  return description;
}
Description ring(int n) {
  Description description = chain(n);
  description.bodies[0].predecessor = named('b', n - 1);
  return description;
}
Description ring_of_drives(int n) {
  Description description = chain_of_drives(n);
  description.drives.back().input.values.clear();
  description.drives.back().input.from = named('d', 1);
  return description;
}

struct Case {
  LargeMechanism mechanism;
  std::vector<Rule> faults_of_each = {};  ///< the faults that each body has, or each drive if there are any
  std::vector<Rule> faults_of_all = {};
};
class LargeTrees : public testing::TestWithParam<Case> {};

TEST_P(LargeTrees, AreBuiltByWorkInProportionToTheirSize) {
  expect_work_in_proportion_to_size([](int n) {
    try {
      ModelBuilder(GetParam().mechanism.make(n)).build();
    } catch (const ModelError&) {
    }
  });
}

/// Runs a function on a stack of 128 KiB, on which a thousand nested calls do not fit.
void on_small_stack(std::function<void()> function) {
  pthread_attr_t attributes;
  pthread_t thread;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 128 * 1024), 0);
  const auto run = [](void* f) -> void* {
    (*static_cast<std::function<void()>*>(f))();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, run, &function), 0);
  ASSERT_EQ(pthread_join(thread, nullptr), 0);
  pthread_attr_destroy(&attributes);
}

TEST_P(LargeTrees, NeedNoDeepRecursion) {
  const Description description = GetParam().mechanism.make(1000);
  on_small_stack([&] {
    try {
      const Model model = ModelBuilder(description).build();
      Workspace<double> workspace(model);
      const std::vector<double> q = neutral(model), zero(model.nv());
      std::vector<SE3<>> C(model.n_frames());
      std::vector<double> tau(model.nv());
      poses(model, workspace, q, C);
      if (description.loops.empty()) inverse_dynamics(model, workspace, q, zero, zero, tau);
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

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const LargeMechanism& mechanism : large_mechanisms) all.push_back({mechanism});
  all.push_back({{"nothing_but_faults", nothing_but_faults},
                 {Rule::unknown_predecessor, Rule::mass_not_positive, Rule::coupling_unknown_joint}});
  all.push_back({{"ring", ring}, {}, {Rule::cycle}});
  all.push_back({{"ring_of_couplings", ring_of_couplings}, {Rule::coupling_loop}});
  all.push_back({{"ring_of_drives", ring_of_drives}, {Rule::cycle}});
  return all;
}
INSTANTIATE_TEST_SUITE_P(, LargeTrees, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.mechanism.name); });

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
