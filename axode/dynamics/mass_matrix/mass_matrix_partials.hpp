#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The partial derivatives ∂M_ij/∂q_k of the mass matrix at [(k nv + i) nv + j], nv³ entries. With the
/// spatial joint screws J and the composite inertias M^c of the subtrees of the joints,
///   ∂_k M_ij = [J_j, J_k]ᵀ M_i^c J_i                              for j < k <= i,
///   ∂_k M_ij = [J_j, J_k]ᵀ M_k^c J_i + J_jᵀ M_k^c [J_i, J_k]     for j <= i < k.
/// O(n d²) for a tree of depth d, and O(nv³) to clear the result. For velocity k of a joint with several
/// degrees of freedom, ∂/∂q_k is the derivative along q ⊕ e_k ε with the unit vector e_k.
template <class T>
void mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                          std::type_identity_t<std::span<T>> dM);
/// The partial derivatives of the inverse mass matrix, ∂(M⁻¹)/∂q_k = -M⁻¹ (∂M/∂q_k) M⁻¹, nv³ entries, with
/// ∂(M⁻¹)_ij/∂q_k at [(k nv + i) nv + j]. O(n⁴). Allocates. If M is singular, the returned Solvability says
/// so, and the result is NaN.
template <class T>
Solvability inverse_mass_matrix_partials(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                         std::type_identity_t<std::span<T>> dM_inverse);

}  // namespace axode
