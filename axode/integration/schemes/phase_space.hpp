#pragma once
#include <span>
#include <vector>

#include "axode/fast/articulated_bodies.hpp"
#include "axode/fast/lagrangian.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"

namespace axode {

/// Hamilton's side of a model: what a scheme on (q, p), p = M v, asks for. O(n) each, but for solve() with coupled joints.
class PhaseSpace {
 public:
  explicit PhaseSpace(const Model& model)
      : tree_(&model.tree<double>()), group_(*tree_), kernels_(model.topology()), own_(size(model)) {}

  /// p = M v and f = τ + ∂L/∂q with loads and losses, so that p' = f + ad_vᵀ p. Gravity is given for every root.
  void partials(const double* q, const double* v, std::span<const Vec3<>> g, std::span<const double> tau,
                const Loads<double>& loads, double* p, double* f) {
    const Tree<double>& tree = *tree_;
    kernels_->lagrangian.run(tree, q, v, g, loads.wrenches, p, f);
    // Of joints with several velocities armatures have a momentum that, as forward_dynamics() has it, does not turn.
    for (int c = 0; c < tree->nv; ++c) own_[index(c)] = tree.armature[index(c)] * v[c];
    group_.cobracket(v, own_.data(), own_.data());
    for (int c = 0; c < tree->nv; ++c) {
      f[c] += tau[index(c)] - own_[index(c)];
      if (loads.joint_losses) f[c] -= joint_loss(tree, c, v[c]);
    }
  }
  /// Makes solve() ready for a configuration.
  Solvability factorize(const double* q) {
    auto& [lagrangian, quick, motion, careful] = *kernels_;
    quick_ = (*tree_)->coupled_bodies.empty();
    if (quick_) {
      quick.maybe_singular = false;
      quick.update_kinematics(*tree_, q), quick.factorize(*tree_);
      quick_ = !quick.maybe_singular;
    }
    return quick_ ? Solvability{} : careful.factorize(*tree_, q, tree_->armature.data());
  }
  /// x := M⁻¹ x.
  void solve(double* x) {
    auto& [lagrangian, quick, motion, careful] = *kernels_;
    if (quick_)
      quick.solve_one(*tree_, motion, x);
    else
      careful.solve(*tree_, x);
  }

 private:
  struct Kernels {
    using Quick = FastArticulatedBodies<FastGeometry<double>::type, double>;
    FastLagrangian<double> lagrangian;
    Quick quick;
    Quick::Motion* motion;
    ArticulatedBodies<Hybrid, double> careful;

    explicit Kernels(Arena& arena)
        : lagrangian(arena), quick(arena), motion(arena.per_body<Quick::Motion>()), careful(arena) {}
  };
  static std::size_t index(int c) { return static_cast<std::size_t>(c); }
  static std::size_t size(const Model& model) { return static_cast<std::size_t>(model.nv()); }

  const Tree<double>* tree_;
  ConfigurationGroup<double> group_;
  WithScratch<double, Kernels> kernels_;
  std::vector<double> own_;
  bool quick_ = true;
};

}  // namespace axode
