#pragma once
#include <span>
#include <utility>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/workspace.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

/// The dynamics of a mechanism on a scalar T of the caller's choice, for example Dual (derivatives along
/// directions) or Taylor (derivatives in time).
///
/// T needs + - * /, sqrt, sin, cos, `<`, `>`, select and a conversion from double; forward dynamics compares
/// the values of numbers only, not their derivatives. The recursions run in the representation Rep, on which
/// results do not depend. mass_matrix() takes O(n²) operations, all other functions O(n). After construction
/// no function allocates memory, and every function throws std::invalid_argument for an argument of a wrong
/// size. Quaternions in q must have norm 1. Inverse and forward dynamics throw std::invalid_argument for a
/// mechanism with loops, and for losses of gears if loads.joint_losses is set. They do not include the forces
/// of springs.
template <class T, RecursionRepresentation Rep = Hybrid> class GenericDynamics {
 public:
  explicit GenericDynamics(const Model& model) : GenericDynamics(model, cast<T>(model.tree<double>())) {}
  /// Uses the real-valued data of `tree` (inertias, armatures, gravity and others) instead of those of the
  /// model, for derivatives with respect to these data. To make such a tree, take the Tree<T>
  /// cast<T>(model.tree<double>()), copy its base class TreeNumbers<T>, which has the data, change the copy,
  /// and construct a Tree<T> from the topology() of the first tree and the copy.
  GenericDynamics(const Model& model, Tree<T> tree)
      : model_(model),
        tree_(std::move(tree)),
        inverse_(model.topology()),
        forward_(model.topology()),
        bodies_(model.topology()) {}

  const Tree<T>& tree() const { return tree_; }

  /// Writes q ⊕ dv (nq numbers) to `moved`: q moved along left-trivialised joint directions dv (nv).
  void integrate(std::span<const T> q, std::span<const T> dv, std::span<T> moved) const {
    check("q", q, model_.nq(), "nq");
    check("dv", dv, model_.nv(), "nv");
    check("moved", moved, model_.nq(), "nq");
    for (int i = 1; i <= tree_->n; ++i)
      if (!tree_->coupled[i])
        with_joint(tree_, i, [&](const auto& joint) {
          joint.integrate(&q[tree_->iq[i]], &dv[tree_->iv[i]], &moved[tree_->iq[i]]);
        });
  }

  /// Computes the drive forces τ (nv; N m and N) for accelerations a (nv) by the Newton-Euler recursion.
  void inverse_dynamics(std::span<const T> q, std::span<const T> v, std::span<const T> a, std::span<T> tau,
                        const Loads<T>& loads = {}) {
    check_counts("inverse_dynamics");
    check(q, v, loads);
    check("a", a, model_.nv(), "nv");
    check("tau", tau, model_.nv(), "nv");
    inverse_->run(tree_, q.data(), v.data(), a.data(), loads);
    inverse_->project(tree_, v.data(), a.data(), loads.joint_losses, tau.data());
  }

  /// Computes the accelerations a (nv; rad/s² and m/s²) for drive forces τ (nv) by the articulated-body
  /// algorithm. The returned Solvability says whether the mass matrix is singular; if T carries derivatives,
  /// only the values of numbers decide this.
  Solvability forward_dynamics(std::span<const T> q, std::span<const T> v, std::span<const T> tau,
                               std::span<T> a, const Loads<T>& loads = {}) {
    check_counts("forward_dynamics");
    check(q, v, loads);
    check("tau", tau, model_.nv(), "nv");
    check("a", a, model_.nv(), "nv");
    return forward_->run(tree_, q.data(), v.data(), tau.data(), loads, a.data());
  }

  /// The mass matrix M(q), nv × nv, row by row, armatures included. O(n²).
  void mass_matrix(std::span<const T> q, std::span<T> M) {
    check("q", q, model_.nq(), "nq");
    check("M", M, model_.nv() * model_.nv(), "nv * nv");
    bodies_->run(tree_, q.data(), tree_.armature.data(), M.data());
  }

 private:
  void check_counts(catalog::Id row) const {
    catalog::check_counts(row.words(), model_, catalog::Caller::workspace);
  }
  template <class Numbers>
  static void check(const char* argument, const Numbers& x, int expected, const char* meaning) {
    check_size(argument, x.size(), static_cast<std::size_t>(expected), meaning);
  }
  void check(std::span<const T> q, std::span<const T> v, const Loads<T>& loads) const {
    check("q", q, model_.nq(), "nq");
    check("v", v, model_.nv(), "nv");
    check_loads(model_, loads);
  }

  Model model_;
  Tree<T> tree_;
  WithScratch<T, InverseDynamicsRecursion<Rep, T>> inverse_;
  WithScratch<T, ForwardDynamicsRecursion<Rep, T>> forward_;
  WithScratch<T, CompositeBodies<Rep, T>> bodies_;
};

}  // namespace axode
