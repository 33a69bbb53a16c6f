#pragma once
#include <span>
#include <vector>

#include "axode/dynamics/solvability.hpp"
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The generalised mass matrix M(q), armature included, by the composite-body algorithm. nv × nv entries,
/// symmetric; entries of velocities on different branches are zero. All representations give the same. O(n d)
/// for depth d, and nv² to clear.
template <class Rep = Fast, class T>
void mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                 std::type_identity_t<std::span<T>> M);

/// M⁻¹, nv × nv entries, by the articulated-body algorithm, O(n²); where joints are coupled from M = LᵀDL,
/// O(n² d). Where M is singular the result is NaN.
template <class Rep = Fast, class T>
Solvability inverse_mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> M_inverse);

/// ∂M_ij/∂q_k at [(k nv + i) nv + j], nv³ entries, armature being constant, by screws: with J of the joint
/// screws and M^c of composite bodies, ∂_k M_ij = [J_j, J_k]ᵀ M_i^c J_i for j < k <= i and [J_j, J_k]ᵀ M_k^c
/// J_i + J_jᵀ M_k^c [J_i, J_k] for j <= i < k. O(n d²), and nv³ to clear. The direction of a multi-DOF
/// joint's velocity k is q ⊕ e_k ε.
template <class T>
void mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                          std::type_identity_t<std::span<T>> dM);
/// ∂(M⁻¹)/∂q_k = -M⁻¹ ∂_k M M⁻¹, in the same order, nv³ entries; O(n⁴). Where M is singular the result is
/// NaN.
Solvability inverse_mass_matrix_partials(const Model& model, Workspace<double>& workspace,
                                         std::span<const double> q, std::span<double> dM_inverse);

/// M = LᵀDL with a unit lower triangular L that has entries only where velocities are on one path, as M has.
/// It makes room once; nothing is allocated afterwards.
template <class T = double> class MassMatrixFactor {
 public:
  explicit MassMatrixFactor(const Model& model);
  /// From the entries of M, O(n d²). Where it fails the factor is of no use.
  Solvability factorize(std::type_identity_t<std::span<const T>> M);
  /// x := M⁻¹ x, O(n d).
  void solve(std::type_identity_t<std::span<T>> x) const;
  /// nv × nv entries, O(n² d).
  void inverse(std::type_identity_t<std::span<T>> M_inverse) const;
  /// Entry (c, p) of L.
  T L(int c, int p) const { return c == p ? T(1) : c < p ? T(0) : H_[static_cast<std::size_t>(c * nv_ + p)]; }
  T D(int c) const { return H_[static_cast<std::size_t>(c * nv_ + c)]; }
  int nv() const { return nv_; }

 private:
  Model model_;
  int nv_;
  std::vector<T> H_;
};

}  // namespace axode
