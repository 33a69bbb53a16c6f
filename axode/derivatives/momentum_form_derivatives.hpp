#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives the matrices ∂v/∂q, ∂v/∂p, ∂p'/∂q and ∂p'/∂p of the momentum form, nv × nv numbers each, row by
/// row, [component, direction]. They must not overlap.
template <class T> struct MomentumFormDerivatives { std::span<T> v_q, v_p, dp_q, dp_p; };

/// Computes the first derivatives by q and p of momentum_form(), which gives the velocities v and the rates
/// p' of the momenta at a state (q, p) with forces τ. ∂v/∂p is the inverse mass matrix. If loads.joint_losses
/// is not set and every joint has one velocity, ∂p'/∂p = -(∂v/∂q)ᵀ, as in Hamilton's equations. Column k of a
/// derivative by q is along q ⊕ ε e_k. The components of loads are constant in the representation in which
/// they are given; damping has a derivative, and Coulomb friction has none. On paths of d velocities, the
/// derivatives of p and p' by q and v take O(n d), their products with the inverse mass matrix O(n²), and one
/// product of two matrices O(n² d). No allocation. If the status is not ok(), all results are NaN. See (D5.5)
/// of docs/derivations.
template <class T>
Solvability momentum_form_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                                      const std::type_identity_t<MomentumFormDerivatives<T>>& d,
                                      const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
