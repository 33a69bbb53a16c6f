#include <cstring>
#include <thread>

#include "tests/laws/law.hpp"

/// Threads share a model; each has a workspace of its own, and no call leaves anything behind in it.
namespace axode::test {
namespace {

template <class C> class Threads : public testing::Test {};
TYPED_TEST_SUITE(Threads, Cases, CaseNames);

/// Poses, accelerations, torques and joint wrenches of every state, one after the other.
template <class Rep, class T>
std::vector<double> results(const Model& model, const std::vector<State<double>>& states) {
  std::vector<double> all;
  Workspace<T> workspace(model);
  for (const State<double>& exact : states) {
    const State<T> state = cast<T>(exact);
    std::vector<SE3<T>> C(static_cast<std::size_t>(model.n_frames()));
    std::vector<TwistRate<Rep, T>> dV(C.size());
    std::vector<T> tau(static_cast<std::size_t>(model.nv()));
    std::vector<Wrench<Rep, T>> W(static_cast<std::size_t>(model.n_bodies()));
    poses<T>(model, workspace, state.q, C);
    accelerations<Rep>(model, workspace, state.q, state.v, state.a, dV);
    inverse_dynamics<Rep>(model, workspace, state.q, state.v, state.a, tau, state.loads());
    joint_wrenches<Rep>(model, workspace, state.q, state.v, state.a, W, state.loads());
    append(all, C), append(all, dV), append(all, tau), append(all, W);
  }
  return all;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TYPED_TEST(Threads, AgreeToTheLastBit) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Random<double> random(5);
  const Model model = ModelBuilder(told(random_mechanism(random), random)).build();
  ASSERT_GT(model.n_bodies(), 5);
  std::vector<State<double>> states;
  for (int k = 0; k < 100; ++k) states.push_back(random_state(model, random));

  const std::vector<double> alone = results<Rep, T>(model, states);
  std::vector<std::vector<double>> together(2);
  std::vector<std::thread> threads;
  for (std::vector<double>& mine : together)
    threads.emplace_back([&] { mine = results<Rep, T>(model, states); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& mine : together) EXPECT_TRUE(same_bits(mine, alone));
}

TYPED_TEST(Threads, AWorkspaceRemembersNothing) {
  using Rep = typename TypeParam::Rep;
  using T = typename TypeParam::T;
  Random<double> random(5);
  const Model model = ModelBuilder(told(random_mechanism(random), random)).build();
  const State<double> state = random_state(model, random), other = random_state(model, random);
  const std::vector<double> fresh = results<Rep, T>(model, {state});
  const std::vector<double> later = results<Rep, T>(model, {other, state});
  ASSERT_GT(later.size(), fresh.size());
  EXPECT_TRUE(same_bits({later.end() - static_cast<std::ptrdiff_t>(fresh.size()), later.end()}, fresh));
}

}  // namespace
}  // namespace axode::test
