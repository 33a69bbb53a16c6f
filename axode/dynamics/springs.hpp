#pragma once
#include "axode/kinematics/arguments.hpp"

/// Springs, dampers and stops, which a model has on joints (Dof) and between frames (SpringDescription). They
/// act in simulations, linearisations and equilibria. Inverse and forward dynamics and their derivatives
/// leave them out: add their forces to τ by add_spring_forces().
///
/// A joint of one velocity has its own position p, also if it is coupled. The force of its spring is -k (p -
/// rest), and beyond a limit that of the stop is -k δ max(0, 1 + d δ') for the depth δ (Hunt and Crossley),
/// which is continuous and never pulls. For a joint of several velocities, let x be the logarithm of the
/// motion from the drawn pose; the energy is xᵀ K x / 2 and the force is -dexp_{-x}⁻ᵀ K x. The force jumps at
/// half a turn, where the shorter rotation changes its direction; for planar and free joints the energy jumps
/// there as well. Between two points at distance l there is a tension k (l - rest) + d l' along the line; if
/// the points coincide, the line has no direction, and there is no force.
namespace axode {

/// The generalised forces τ (nv; N m or N) of all springs, dampers and stops. O(n) for the joints, and
/// O(depth) for each spring between two points.
template <class T>
void spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                   std::type_identity_t<std::span<T>> tau);

/// Adds the forces of spring_forces() to τ (nv).
template <class T>
void add_spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       std::type_identity_t<std::span<T>> tau);

/// The energy of springs and stops, J. Its gradient is -τ at rest.
template <class T> T elastic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q);

}  // namespace axode
