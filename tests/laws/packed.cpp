#include "axode/fast/articulated_bodies.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/fast/jacobians.hpp"
#include "axode/fast/motion.hpp"
#include "tests/laws/law.hpp"

/// The fast kernels give the same results with packed vectors, which the library uses if the processor has
/// suitable registers, and with plain ones.
namespace axode::test {
namespace {

using Numbers = std::vector<double>;

class PackedVectors : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, PackedVectors, testing::ValuesIn(scalars()), name_of);

/// The fast kernels with one of the two kinds of vectors.
struct Kernels {
  Numbers (*forces)(const Model&, const State<double>&);
  /// Returns no numbers if the mass matrix may be singular.
  Numbers (*accelerations)(const Model&, const State<double>&, const Numbers& tau);
  /// Twists, twist rates and Jacobians of all frames, in all representations.
  Numbers (*motion)(const Model&, const State<double>&);
};

template <class G, class T> Numbers forces(const Model& model, const State<double>& state) {
  Workspace<T> workspace(model);
  Arena arena = workspace.arena(model.topology());
  const Tree<T>& tree = model.tree<T>();
  const State<T> at = cast<T>(state);
  FastInverseDynamics<G, T> recursion(arena);
  recursion.forward(tree, at.q.data(), at.v.data(), at.a.data(), tree.g);
  std::vector<T> tau(at.v.size());
  recursion.backward(tree, tau.data());
  return cast<double>(tau);
}

template <class G, class T>
Numbers accelerations(const Model& model, const State<double>& state, const Numbers& drives) {
  Workspace<T> workspace(model);
  Arena arena = workspace.arena(model.topology());
  const Tree<T>& tree = model.tree<T>();
  const State<T> at = cast<T>(state);
  const std::vector<T> tau = cast<T>(drives);
  using Bodies = FastArticulatedBodies<G, T>;
  Bodies bodies(arena);
  auto* motion = arena.template per_body<typename Bodies::Motion>();
  bodies.update_kinematics_and_bias(tree, at.q.data(), at.v.data(), motion);
  std::vector<T> a(at.v.size());
  bodies.factorize(tree, tau.data());
  if (bodies.maybe_singular) return {};
  bodies.accelerate(tree, motion, a.data());
  return cast<double>(a);
}

template <class Rep, class G, class T> void add_motion(const Model& model, const State<T>& at, Numbers& all) {
  const Tree<T>& tree = model.tree<T>();
  Workspace<T> workspace(model);
  const auto add = [&](const auto& six) {
    for (const auto& X : six)
      for (const T& x : {X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z}) all.push_back(static_cast<double>(x));
  };
  const auto frames = static_cast<std::size_t>(tree->n_frames());
  {
    Arena arena = workspace.arena(model.topology());
    FastMotionIn<Rep, T, true, G> moving(arena);
    std::vector<TwistRate<Rep, T>> dV(frames);
    moving.run(tree, at.q.data(), at.v.data(), at.a.data());
    moving.template write<Rep>(tree, dV.data());
    add(dV);
  }
  {
    Arena arena = workspace.arena(model.topology());
    FastMotionIn<Rep, T, false, G> moving(arena);
    std::vector<Twist<Rep, T>> V(frames);
    moving.run(tree, at.q.data(), at.v.data());
    moving.template write<Rep>(tree, V.data());
    add(V);
  }
  Arena arena = workspace.arena(model.topology());
  FastJacobians<T, G> jacobians(arena);
  jacobians.template run<Rep>(tree, at.q.data());
  std::vector<Twist<Rep, T>> J(at.v.size());
  for (std::size_t f = 0; f < frames; ++f) {
    jacobians.template write<Rep>(tree, tree->frame_body[f], tree.frame_offset[f], J.data());
    add(J);
  }
}
template <class G, class T> Numbers motion(const Model& model, const State<double>& state) {
  const State<T> at = cast<T>(state);
  Numbers all;
  for (const Representation representation : representations)
    with_representation(representation, [&](auto rep) { add_motion<decltype(rep), G, T>(model, at, all); });
  return all;
}

template <class G, class T> constexpr Kernels kernels{forces<G, T>, accelerations<G, T>, motion<G, T>};

TEST_P(PackedVectors, GiveWhatPlainOnesGive) {
  const Kernels packed = GetParam().single ? kernels<Packed<float>, float> : kernels<Packed<double>, double>,
                plain = GetParam().single ? kernels<Plain<float>, float> : kernels<Plain<double>, double>;
  Comparison force("force", GetParam().agreement()), moved("motion", GetParam().agreement());
  int solved = 0;
  for_seeds(500, [&](std::uint64_t seed) {
    Trial trial(GetParam(), seed);
    force.expect_equal(packed.forces(trial.model, trial.state), plain.forces(trial.model, trial.state));
    moved.expect_equal(packed.motion(trial.model, trial.state), plain.motion(trial.model, trial.state));
    if (trial.model.n_screws() != trial.model.nv()) return;
    const Numbers tau = trial.inverse_dynamics(trial.state.v, trial.state.a, {});
    for (const Kernels& kernels : {packed, plain}) {
      const Numbers a = kernels.accelerations(trial.model, trial.state, tau);
      if (a.empty()) continue;
      ++solved;
      force.expect_equal(trial.inverse_dynamics(trial.state.v, a, {}), tau);
    }
  });
  EXPECT_GE(solved, 10);
}

}  // namespace
}  // namespace axode::test
