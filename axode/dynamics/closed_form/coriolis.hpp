#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The forms of the Coriolis matrix C(q, v). In each of them, C v is the Coriolis vector.
enum class CoriolisForm {
  paper,    ///< the paper's C = -Jᵀ (M A a + bᵀ M) J (Müller, eq. CMat); M' - 2C is not skew
  skew,     ///< C' = -Jᵀ (M A a + bᵀ M - M b) J: M' - 2C is skew
  spatial,  ///< Jᵀ (M J' - ad_Vᵀ M J) in spatial twists; equal to the form `skew`
  /// C_ij = Σ_k Γ_ijk v_k; M' - 2C is skew. With multi-DOF joints Γ is the Levi-Civita connection of M.
  christoffel
};
/// The Coriolis matrix C(q, v), nv × nv entries, row by row. `form` chooses one of the matrices C whose
/// product C v is the vector of Coriolis and centrifugal forces. O(n d) for a tree of depth d, and O(nv²) to
/// clear the matrix.
template <class T>
void coriolis_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                     CoriolisForm form, std::type_identity_t<std::span<T>> C);

/// Christoffel symbols of the first kind, Γ_ijk at [(i nv + j) nv + k], nv³ entries, from spatial joint
/// screws J and composite inertias (Müller, eq. Gamma with erratum 25 of
/// docs/errata.md):
///   2 Γ_ijk = J_kᵀ M^c [J_i, J_j] + J_jᵀ M^c [J_i, J_k] + J_iᵀ M^c [J_s, J_r].
/// Here the joints of the velocities i, j and k lie on one path to the ground; otherwise Γ_ijk = 0. M^c is
/// the composite inertia of the subtree of that joint of i, j and k which is farthest from the ground. In the
/// last bracket s = k and r = j if the joint of k is nearer to the ground than that of j, or if it is the
/// same joint; otherwise s = j and r = k. Γ_ijk = Γ_ikj, except if j and k are velocities of one joint with
/// several degrees of freedom: then Γ_ijk - Γ_ikj = J_iᵀ M^c [J_k, J_j]. O(n d²) for a tree of depth d, and
/// O(nv³) to clear the result.
template <class T>
void christoffel(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                 std::type_identity_t<std::span<T>> Gamma);

}  // namespace axode
