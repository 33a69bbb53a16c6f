#include "axode/dynamics/fast_articulated_bodies.hpp"
#include "tests/laws/law.hpp"

/// The fast kernels give the same on packed vectors, which the library uses where the processor has registers for
/// them, and on plain ones.
namespace axode::test {
namespace {

template <class T> class PackedVectors : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(PackedVectors, Scalars);

template <class G, class T> std::vector<T> forces(Trial<T>& trial) {
  typename Workspace<T>::Arena arena(trial.workspace);
  const Tree<T>& tree = trial.model.template tree<T>();
  FastInverseDynamics<G, T> recursion(arena);
  recursion.forward(tree, trial.state.q.data(), trial.state.v.data(), trial.state.a.data(), tree.g);
  std::vector<T> tau = trial.zero();
  recursion.backward(tree, tau.data());
  return tau;
}

/// Accelerations, then the inverse of the mass matrix; nothing where it may be singular.
template <class G, class T> std::vector<T> accelerations(Trial<T>& trial, const std::vector<T>& tau) {
  typename Workspace<T>::Arena arena(trial.workspace);
  const Tree<T>& tree = trial.model.template tree<T>();
  using Bodies = FastArticulatedBodies<G, T>;
  Bodies bodies(arena);
  auto* motion = arena.template per_body<typename Bodies::Motion>();
  bodies.place_and_move(tree, trial.state.q.data(), trial.state.v.data(), motion);
  std::vector<T> a = trial.zero();
  bodies.solve(tree, tau.data(), motion, a.data());
  if (bodies.doubtful) return {};
  return a;
}

TYPED_TEST(PackedVectors, GiveWhatPlainOnesGive) {
  using T = TypeParam;
  Comparison force("force", agreement<T>);
  int solved = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial<T> trial{Random<double>(seed)};
    force.expect_equal(forces<Packed<T>>(trial), forces<Plain<T>>(trial));
    if (trial.model.n_screws() != trial.model.nv()) return;
    const std::vector<T> tau = trial.template inverse_dynamics<Hybrid>(trial.state.v, trial.state.a, {});
    for (const std::vector<T>& a :
         {accelerations<Packed<T>>(trial, tau), accelerations<Plain<T>>(trial, tau)}) {
      if (a.empty()) continue;
      ++solved;
      force.expect_equal(trial.template inverse_dynamics<Hybrid>(trial.state.v, a, {}), tau);
    }
  });
  EXPECT_GE(solved, 10);
}

}  // namespace
}  // namespace axode::test
