#pragma once
#include "axode/kinematics/arguments.hpp"

/// Springs, dampers and stops, which a model has on joints (Dof) and between frames (SpringDescription). They act in
/// simulations, linearisations and equilibria. Inverse and forward dynamics and their derivatives leave them out: call
/// add_spring_forces() on τ.
///
/// On a joint of one velocity, at its own position p (a coupled joint's, too), the spring's force is -k (p - rest), and
/// beyond a limit the stop's is -k δ max(0, 1 + d δ') for the depth δ (Hunt and Crossley): continuous, and never pulling.
/// On a joint of several velocities the motion from the drawn pose has the logarithm x, the energy is xᵀ K x / 2 and so the
/// force -dexp_{-x}⁻ᵀ K x. It jumps at half a turn, where the other way round becomes the shorter one; of planar and free
/// joints so does the energy. Between two points at distance l there is a tension k (l - rest) + d l' along the line; where
/// they meet the line has no direction, and there is no force.
namespace axode {

/// The generalised forces of all of them, τ (nv): N m or N. O(n) for the joints and O(depth) for each line.
template <class T>
void spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                   std::type_identity_t<std::span<T>> tau);

/// Adds them to τ (nv).
template <class T>
void add_spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       std::type_identity_t<std::span<T>> tau);

/// The energy that springs and stops hold, J: its gradient is -τ where nothing moves.
template <class T> T elastic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q);

}  // namespace axode
