#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The partial derivatives ∂M_ij/∂q_k of the mass matrix, nv³ entries, at [(k nv + i) nv + j]. With the
/// spatial joint screws J and the composite inertias M^c of the subtrees of the joints,
///   ∂_k M_ij = [J_j, J_k]ᵀ M_i^c J_i                              for j < k <= i,
///   ∂_k M_ij = [J_j, J_k]ᵀ M_k^c J_i + J_jᵀ M_k^c [J_i, J_k]     for j <= i < k,
/// and ∂_k M_ji is equal; all other entries are 0. In the conditions i, j, k stand for the joints of these
/// velocities, and j < k means that joint j is on the path from the ground to joint k. For velocity k of a
/// joint with several degrees of freedom, ∂/∂q_k is the derivative along q ⊕ e_k ε with the unit vector e_k.
/// O(n d²) for a tree of n bodies and depth d, and O(nv³) to clear the result.
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
