#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

/// The terms of the equations of motion M(q) a + C(q, v) v + g(q) = τ + Q, where Q are the generalised forces
/// of the loads. Each function computes one term, with nv entries, in O(n).
namespace axode {

/// The Coriolis vector C(q, v) v: the drive forces at velocities v without gravity, loads and accelerations.
template <RecursionChoice Rep = Fast, class T>
void coriolis_vector(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                     std::type_identity_t<std::span<T>> Cv);
/// g(q) = ∂U/∂q: the drive forces that hold the system at rest against gravity.
template <RecursionChoice Rep = Fast, class T>
void gravity_torques(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                     std::type_identity_t<std::span<T>> g);
/// The generalised forces Q = Σ Jᵀ W of the wrenches W in `loads`, with the Jacobian J of the frame on which
/// each wrench acts, and of damping and friction at velocities v if loads.joint_losses is set.
template <RecursionChoice Rep = Fast, class T>
void generalized_loads(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> Q);

}  // namespace axode
