#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives ∂v/∂q, ∂v/∂p, ∂p'/∂q and ∂p'/∂p, nv × nv each, row by row, [component, direction]. They must not
/// overlap.
template <class T> struct MomentumFormDerivatives { std::span<T> v_q, v_p, dp_q, dp_p; };

/// First derivatives of momentum_form() at a state (q, p); ∂v/∂p = M⁻¹, and the derivatives by τ are 0 and 1.
/// Without joint_losses, and if every joint has one velocity, ∂p'/∂p = -(∂v/∂q)ᵀ, as in Hamilton's equations.
/// Directions of q, loads and losses are those of inverse_dynamics_derivatives(). O(n d) for the terms, and
/// articulated bodies on all nv columns; no allocation. If the status is not ok(), all results are NaN. See
/// (D5.5) of docs/derivations.
template <class T>
Solvability momentum_form_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> p,
                                      const std::type_identity_t<MomentumFormDerivatives<T>>& d,
                                      const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
