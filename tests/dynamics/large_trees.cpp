#include <gtest/gtest.h>
#include <pthread.h>

#include <functional>
#include <map>

#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "tests/io/same_mechanism.hpp"
#include "tests/model/large_mechanisms.hpp"

/// Mechanisms of ten thousand bodies are built, evaluated, written and read without deep recursion.
namespace axode::test {
namespace {

class TenThousandBodies : public testing::TestWithParam<large::Mechanism> {};
INSTANTIATE_TEST_SUITE_P(Sound, TenThousandBodies, testing::ValuesIn(large::mechanisms), large::name_of);
INSTANTIATE_TEST_SUITE_P(Faulty, TenThousandBodies, testing::ValuesIn(large::faulty_mechanisms),
                         large::name_of);

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

TEST_P(TenThousandBodies, NeedNoDeepRecursion) {
  const Description description = GetParam().make(10'000);
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

TEST(LargeTree, FilesOfAChainOfTenThousandBodiesNeedNoDeepRecursion) {
  const int n = 10'000;
  on_small_stack([&] {
    const Model model = ModelBuilder(large::chain(n)).build();
    const Model drawn = ModelBuilder(read_drawing_text(drawing_of(model), "chain.toml")).build();
    EXPECT_EQ(drawn.body(n).predecessor, n - 1);
    const Model in_urdf = ModelBuilder(read_urdf_text(urdf_of(model), "chain.urdf")).build();
    EXPECT_EQ(in_urdf.body(n).predecessor, n - 1);
    std::ostringstream mjcf;
    write_mjcf(model, mjcf);
  });
}

TEST(LargeTree, AChainOfTenThousandBodiesIsEvaluatedRight) {
  const int n = 10'000;
  const Model model = ModelBuilder(large::chain(n)).build();
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
