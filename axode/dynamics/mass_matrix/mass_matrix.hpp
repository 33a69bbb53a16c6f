#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The generalised mass matrix M(q), armature included, by the composite-body algorithm; nv × nv entries,
/// symmetric, zero for velocities on different branches of the tree. It does not depend on the representation
/// Rep in which the algorithm runs. O(n d) for a tree of depth d, and O(nv²) to clear the matrix.
template <RecursionChoice Rep = Fast, class T>
void mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                 std::type_identity_t<std::span<T>> M);

/// The inverse mass matrix M⁻¹, nv × nv entries, by the articulated-body algorithm. If M is singular, the
/// returned Solvability says so, and the result is NaN. O(n²).
template <RecursionChoice Rep = Fast, class T>
Solvability inverse_mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> M_inverse);

}  // namespace axode
