#pragma once
#include <span>
#include <vector>

#include "axode/fast/articulated_bodies.hpp"
#include "axode/fast/lagrangian.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/articulated_bodies.hpp"
#include "axode/scalar/index.hpp"

namespace axode {

/// The equations of motion in Hamilton's form, for integration schemes on (q, p) with the momenta p = M v.
/// All functions are O(n), except solve() if joints are coupled.
class PhaseSpace {
 public:
  explicit PhaseSpace(const Model& model)
      : tree_(&model.tree<double>()), group_(*tree_), kernels_(model.topology()), own_(size(model)) {}

  /// Computes the momenta p = M v and the forces f = τ + ∂L/∂q, with the Lagrangian L and the joint forces
  /// tau; loads and losses are included in f. The rates of the momenta are then p' = f + ad_vᵀ p (D5.2). For
  /// each body i that is joined to the ground, g[i] is the gravity (m/s²) that acts on its subtree.
  void partials(const double* q, const double* v, std::span<const Vec3<>> g, std::span<const double> tau,
                const Loads<double>& loads, double* p, double* f) {
    const Tree<double>& tree = *tree_;
    kernels_->lagrangian.run(tree, q, v, g, loads.wrenches, p, f);
    // The momenta of armatures of joints with several velocities do not turn with the joint, as in
    // forward_dynamics().
    for (int c = 0; c < tree->nv; ++c) own_[index(c)] = tree.armature[index(c)] * v[c];
    group_.ad_transpose(v, own_.data(), own_.data());
    for (int c = 0; c < tree->nv; ++c) {
      f[c] += tau[index(c)] - own_[index(c)];
      if (loads.joint_losses) f[c] -= joint_loss(tree, c, v[c]);
    }
  }
  /// Factorises M at q for solve().
  Solvability factorize(const double* q) {
    auto& [lagrangian, fast, motion, robust] = *kernels_;
    use_fast_ = (*tree_)->coupled_bodies.empty();
    if (use_fast_) {
      fast.maybe_singular = false;
      fast.update_kinematics(*tree_, q);
      fast.factorize(*tree_);
      use_fast_ = !fast.maybe_singular;
    }
    return use_fast_ ? Solvability{} : robust.factorize(*tree_, q, tree_->armature.data());
  }
  /// Replaces x by M⁻¹ x.
  void solve(double* x) {
    auto& [lagrangian, fast, motion, robust] = *kernels_;
    if (use_fast_)
      fast.solve_one(*tree_, motion, x);
    else
      robust.solve(*tree_, x);
  }

 private:
  struct Kernels {
    using Fast = FastArticulatedBodies<FastGeometry<double>::type, double>;
    FastLagrangian<double> lagrangian;
    Fast fast;
    Fast::Motion* motion;
    ArticulatedBodies<Hybrid, double> robust;

    explicit Kernels(Arena& arena)
        : lagrangian(arena), fast(arena), motion(arena.per_body<Fast::Motion>()), robust(arena) {}
  };
  static std::size_t size(const Model& model) { return static_cast<std::size_t>(model.nv()); }

  const Tree<double>* tree_;
  ConfigurationGroup<double> group_;
  WithScratch<double, Kernels> kernels_;
  std::vector<double> own_;
  bool use_fast_ = true;
};

}  // namespace axode
