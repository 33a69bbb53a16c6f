#pragma once
#include "axode/kinematics/arguments.hpp"

/// Springs, dampers and stops, which a model has on joints (Dof) and as elements of their own
/// (SpringDescription). They act in simulations, linearisations and equilibria. Inverse and forward
/// dynamics and their derivatives leave them out: add their forces to τ by add_spring_forces().
///
/// A joint of one velocity has its own position p, also if it is coupled. The force of its spring is -k (p
/// - rest), and beyond a limit that of the stop is -k δ max(0, 1 + d δ') for the depth δ (Hunt and
/// Crossley), which is continuous and never pulls. For a joint of several velocities, let x be the
/// logarithm of the motion from the drawn pose; the energy is xᵀ K x / 2 and the force is -dexp_{-x}⁻ᵀ K x.
/// The force jumps at half a turn, where the shorter rotation changes its direction; for planar and free
/// joints the energy jumps there as well.
///
/// A spring between two points, along a path of points, of an angle or of coordinates of joints has one
/// coordinate x and the tension F of its ForceLaw, and the force -F ∂x/∂q (D16.1). If two points of a path
/// coincide, the segment between them has no direction and no force. A bushing has the energy Xᵀ K X / 2
/// for X = log(D_0⁻¹ D) (D16.10). Angles and bushings jump at half a turn.
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

/// The coordinate x of spring k of the description, m or rad, and unless it is empty the gradient ∂x/∂q
/// (nv), whose entries are the moment arms of its force with the opposite sign. Throws
/// std::invalid_argument for a bushing, which has no coordinate, and for a number without a spring.
/// O(depth) for each segment.
template <class T>
T spring_coordinate(const Model& model, Workspace<T>& workspace, int k, Numbers<T> q,
                    std::type_identity_t<std::span<T>> gradient = {});

}  // namespace axode
