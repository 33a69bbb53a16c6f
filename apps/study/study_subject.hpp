#pragma once
#include "apps/study/study.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/fast/inverse_dynamics.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/momentum.hpp"

namespace axode::command {

template <class T> struct Numbers {
  std::vector<T> q, v, a, out, out_2;
  std::vector<AppliedWrench<T>> wrenches;

  Numbers(const State& state, std::size_t nv)
      : q(state.q.begin(), state.q.end()),
        v(state.v.begin(), state.v.end()),
        a(state.a.begin(), state.a.end()),
        out(std::max(nv * nv, nv)),
        out_2(nv) {
    for (const AppliedWrench<>& W : state.loads)
      wrenches.emplace_back(W.frame, W.representation, axode::cast<T>(W.m), axode::cast<T>(W.f));
  }
  Loads<T> loads() const { return {.wrenches = wrenches}; }
};

/// The size in bytes of the scratch memory that the algorithms of the study need.
template <class T> std::size_t footprint_of_study(const Topology& t) {
  const auto of = [&]<class Rep>(Rep) {
    return footprint<ForwardDynamicsRecursion<Rep, T>, CompositeBodies<Rep, T>, MomentumForm<Rep, T>>(t);
  };
  return std::max({of(BodyFixed{}), of(Spatial{}), of(Hybrid{}), of(Mixed{}),
                   footprint<FastInverseDynamics<typename FastGeometry<T>::type, T>, FastForwardDynamics<T>,
                             FastInverse<T>, FastCompositeBodies<T>>(t)});
}

/// Runs an algorithm once, by the recursion in the representation Rep.
template <class Rep, class T, TreeOf<T> AnyTree>
  requires(!std::same_as<Rep, Fast>)
void call(Algorithm algorithm, const AnyTree& tree, Workspace<T>& workspace, Numbers<T>& x) {
  Arena arena = workspace.arena(*tree.operator->());
  const T *q = x.q.data(), *v = x.v.data(), *a = x.a.data();
  T* out = x.out.data();
  switch (algorithm) {
    case Algorithm::inverse_dynamics: {
      InverseDynamicsRecursion<Rep, T> recursion{arena};
      recursion.run(tree, q, v, a, x.loads());
      recursion.project(tree, v, a, false, out);
      break;
    }
    case Algorithm::forward_dynamics:
      static_cast<void>(ForwardDynamicsRecursion<Rep, T>(arena).run(tree, q, v, a, x.loads(), out));
      break;
    case Algorithm::mass_matrix:
      CompositeBodies<Rep, T>(arena).run(tree, q, tree.armature.data(), out);
      break;
    case Algorithm::inverse_mass_matrix: {
      ArticulatedBodies<Rep, T> bodies(arena);
      static_cast<void>(bodies.factorize(tree, q, tree.armature.data()));
      const std::size_t nv = static_cast<std::size_t>(tree->nv);
      std::fill(x.out.begin(), x.out.end(), T(0));
      for (std::size_t c = 0; c < nv; ++c) x.out[c * nv + c] = T(1);
      for (std::size_t c = 0; c < nv; ++c) bodies.solve(tree, x.out.data() + c * nv);
      break;
    }
    case Algorithm::accelerations: TreeMotion<Rep, T>(arena).run(tree, q, v, a); break;
    case Algorithm::momentum_form:
      static_cast<void>(MomentumForm<Rep, T>(arena).run(tree, q, v, a, x.loads(), out, x.out_2.data()));
      break;
  }
}

/// Runs an algorithm once, by the fast kernels of the library.
template <std::same_as<Fast> Rep, class T>
void call(Algorithm algorithm, const Tree<double>& tree, Workspace<T>& workspace, Numbers<T>& x) {
  Arena arena = workspace.arena(*tree.topology());
  const T *q = x.q.data(), *v = x.v.data(), *a = x.a.data();
  T* out = x.out.data();
  using G = typename FastGeometry<T>::type;
  using Bodies = FastArticulatedBodies<G, T>;
  switch (algorithm) {
    case Algorithm::inverse_dynamics: {
      FastInverseDynamics<G, T> recursion(arena);
      for (int c = 0; c < tree->nv; ++c) out[c] = T(tree.armature[c]) * a[c];
      recursion.forward(tree, q, v, a, cast<T>(tree.g));
      recursion.backward(tree, out);
      break;
    }
    case Algorithm::forward_dynamics: {
      Bodies bodies(arena);
      auto* motion = arena.template per_body<typename Bodies::Motion>();
      bodies.update_kinematics_and_bias(tree, q, v, motion);
      bodies.factorize(tree, a);
      bodies.accelerate(tree, motion, out);
      break;
    }
    case Algorithm::mass_matrix: {
      FastCompositeBodies<T> bodies(arena);
      bodies.run(tree, q);
      bodies.write(tree, out);
      break;
    }
    case Algorithm::inverse_mass_matrix: {
      Bodies bodies(arena);
      auto* columns = arena.template per_body<typename Bodies::Columns>();
      auto* u = arena.template per_screw<typename Bodies::Several>();
      bodies.update_kinematics(tree, q);
      bodies.factorize(tree);
      bodies.inverse(tree, columns, u, out);
      break;
    }
    case Algorithm::accelerations:
    case Algorithm::momentum_form: break;
  }
}

template <class T, class Frames> struct TreeIn { using type = FramedTree<T, Frames>; };
template <class T> struct TreeIn<T, JointFrames> { using type = Tree<T>; };

template <class Rep, class Frames> class SubjectIn : public Subject {
  static constexpr bool fast = std::same_as<Rep, Fast>;

 public:
  SubjectIn(const Model& model, const State& state)
      : tree_(model.tree<double>()),
        workspace_(model),
        numbers_(state, static_cast<std::size_t>(model.nv())) {}

  bool can(Algorithm algorithm) const override {
    if (fast && !numbers_.wrenches.empty()) return false;
    if (!fast || algorithm == Algorithm::inverse_dynamics) return true;
    return algorithm != Algorithm::accelerations && algorithm != Algorithm::momentum_form &&
           tree_->coupled_bodies.empty();
  }
  void run(Algorithm algorithm, int calls) override {
    for (int k = 0; k < calls; ++k) call<Rep>(algorithm, tree_, workspace_, numbers_);
  }
  std::vector<double> results_of(Algorithm algorithm) override {
    run(algorithm, 1);
    const bool square = algorithm == Algorithm::mass_matrix || algorithm == Algorithm::inverse_mass_matrix;
    const std::ptrdiff_t nv = tree_->nv;
    std::vector<double> results(numbers_.out.begin(), numbers_.out.begin() + (square ? nv * nv : nv));
    if (algorithm == Algorithm::momentum_form)
      results.insert(results.end(), numbers_.out_2.begin(), numbers_.out_2.end());
    return results;
  }

 private:
  const typename TreeIn<double, Frames>::type tree_;
  Workspace<double> workspace_;
  Numbers<double> numbers_;
};

template <class Rep, class Frames>
std::unique_ptr<Subject> make_subject(const Model& model, const State& state) {
  return std::make_unique<SubjectIn<Rep, Frames>>(model, state);
}

}  // namespace axode::command
