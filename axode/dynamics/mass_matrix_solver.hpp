#pragma once
#include "axode/dynamics/composite_bodies.hpp"
#include "axode/dynamics/solvability.hpp"
#include "axode/dynamics/sparse_factor.hpp"

namespace axode {

/// M x = b at one configuration: by the articulated-body algorithm, or, where joints are coupled, by the mass
/// matrix that their couplings project, and its sparse factors.
template <class Rep, class T> class MassMatrixSolver {
 public:
  template <TreeOf<T> AnyTree>
  MassMatrixSolver(const AnyTree& tree, typename Workspace<T>::Arena& arena, Link<Rep, T>* link) noexcept
      : MassMatrixSolver(tree, arena, link, tree.armature.data()) {}
  template <TreeOf<T> AnyTree>
  MassMatrixSolver(const AnyTree& tree, typename Workspace<T>::Arena& arena, Link<Rep, T>* link,
                   const T* armature) noexcept
      : tree_(tree), coupled_(tree.n_screws > tree.nv) {
    if (coupled_) {
      H_ = arena.template per_pair<T>();
      CompositeBodies<Rep, T>{arena, link}.run(tree, armature, H_);
      const int c = factorize(tree, H_);
      solvability_.singular_body = c < 0 ? 0 : body_of_velocity(tree, c);
    } else {
      articulated_ = ArticulatedBodies<Rep, T>{arena, link};
      solvability_.singular_body = articulated_.factorize(tree, armature);
    }
  }

  Solvability solvability() const { return solvability_; }

  /// x := M⁻¹ x, or NaN.
  void solve(T* x) const noexcept {
    if (!solvability_.ok()) {
      for (int c = 0; c < tree_.nv; ++c) x[c] = T(std::numeric_limits<double>::quiet_NaN());
    } else if (coupled_) {
      axode::solve(tree_, H_, x);
    } else {
      articulated_.solve(tree_, x);
    }
  }

 private:
  const Tree<T>& tree_;
  bool coupled_;
  T* H_ = nullptr;
  ArticulatedBodies<Rep, T> articulated_;
  Solvability solvability_;
};

}  // namespace axode
