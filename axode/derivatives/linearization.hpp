#pragma once
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Receives the matrices A (2nv × 2nv) and B (2nv × nv) of the linear system x' = A x + B δτ of small
/// deviations x of the state and δτ of the forces, row by row, [component of x', component of x or δτ]. They
/// must not overlap each other or v. If the model has springs, they must not overlap q or τ either.
template <class T> struct Linearization { std::span<T> A, B; };

/// Computes the linear system x' = A x + B δτ of small deviations x = (δ, δv) from the motion through a state
/// (q, v) with forces τ. The deviating motion has the coordinates q ⊕ δ, the velocities v + δv and the forces
/// τ + δτ. With the accelerations a of forward dynamics
///     A = [-ad_v  I; ∂a/∂q  ∂a/∂v],    B = [0; ∂a/∂τ],
/// where ad_v δ = [v, δ] is the Lie bracket in the subgroup of each joint; ad_v is 0 at rest, and for joints
/// with one velocity. The forces of springs, dampers and stops of the model are part of a. The damping and
/// Coulomb friction of joints are part of a only if loads.joint_losses is set; Coulomb friction has the
/// derivative 0. In an equilibrium (a = 0 and v = 0) A and B are constant; in any other state they hold at
/// this instant only. The components of loads are constant in the representation in which they are given. The
/// cost is that of the first derivatives of forward dynamics. No allocation. Throws std::invalid_argument for
/// loops, prescribed motions, drives with states of their own (motors, cylinders), a wrong size, quaternions
/// that are not of unit norm, a load on a frame that does not exist and results whose memory overlaps. If the
/// status is not ok(), all results are NaN.
template <class T>
Solvability linearize(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> tau,
                      const std::type_identity_t<Linearization<T>>& linear,
                      const std::type_identity_t<Loads<T>>& loads = {});

/// Computes the matrices A and B of the linear system x' = A x + B δτ of small deviations x of the state (q,
/// v) and δτ of the forces, also for models with drives. `tau` are the forces of the drives at this state; A
/// and B do not contain the derivatives of these forces.
template <class T>
Solvability linearize_without_drives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                     Numbers<T> tau, const std::type_identity_t<Linearization<T>>& linear,
                                     const std::type_identity_t<Loads<T>>& loads);

}  // namespace axode
