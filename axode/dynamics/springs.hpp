#pragma once
#include "axode/kinematics/arguments.hpp"

/// Springs, dampers and end stops, on joints (Dof) and as elements of their own (SpringDescription). They act
/// in simulations, linearisations and equilibria. Inverse and forward dynamics and their derivatives leave
/// them out: add their forces to τ by add_spring_forces().
///
/// On a joint with one velocity, a spring of stiffness k has the force -k (p - rest), where `rest` is the
/// position without force and p the position of the joint. p is its coordinate q or, for a joint that is
/// coupled to a leader with the coordinate q, ratio · q + offset. At a depth δ beyond a limit of the joint,
/// its stop has the force -k_s δ max(0, 1 + d δ') (Hunt and Crossley), where k_s and d are the stiffness and
/// the damping of the stop. For the spring of a joint with several velocities, let x be the logarithm of the
/// joint's displacement from its reference pose (coordinates 0, quaternion the identity), and K the diagonal
/// matrix of stiffnesses; the energy is xᵀ K x / 2 and the force is -dexp_{-x}⁻ᵀ K x. The force jumps at half
/// a turn, where the shorter rotation changes its direction; for planar and free joints the energy jumps
/// there as well.
///
/// A spring element acts between two points, along a path of points, on the angle between two frames or on a
/// sum of joint coordinates. It has one coordinate x (length, angle or sum), a tension F given by its
/// ForceLaw, and the generalised force -F ∂x/∂q (D16.1). If two points of a path coincide, the segment
/// between them has no force. A bushing between two frames has the energy Xᵀ K X / 2 for X = log(D_0⁻¹ D),
/// where K is its 6×6 stiffness, D the relative pose of the frames and D_0 the relative pose at rest
/// (D16.10). The forces on angles and the forces of bushings jump at half a turn.
namespace axode {

/// The generalised forces τ (nv; N m or N) of all springs, dampers and end stops. Springs, dampers and stops
/// of joints cost O(n) in total. A spring element on a sum of joint coordinates costs O(d) for d joints in
/// the sum. Any other spring element acts on points or frames, with d joints between them and the ground. It
/// costs O(d), or O(d) for each straight segment if it acts along a path of points.
template <class T>
void spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                   std::type_identity_t<std::span<T>> tau);

/// Adds the forces of spring_forces() to τ (nv).
template <class T>
void add_spring_forces(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       std::type_identity_t<std::span<T>> tau);

/// The elastic energy (J) of all springs and stops. Its gradient by q is minus their forces at v = 0.
template <class T> T elastic_energy(const Model& model, Workspace<T>& workspace, Numbers<T> q);

/// Returns the coordinate x (m or rad) of spring element k of the model and, unless `gradient` is empty,
/// ∂x/∂q (nv entries), the negative moment arms of the tension. Throws std::invalid_argument for a bushing,
/// which has no coordinate, and for a k that is not the index of a spring element. If the element acts on a
/// sum of joint coordinates, the cost is O(d) for d joints in the sum. Otherwise d is the number of joints
/// between the ground and the points or frames on which the element acts, and the cost is O(d), or O(d) for
/// each straight segment if it acts along a path of points.
template <class T>
T spring_coordinate(const Model& model, Workspace<T>& workspace, int k, Numbers<T> q,
                    std::type_identity_t<std::span<T>> gradient = {});

}  // namespace axode
