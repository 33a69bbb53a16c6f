#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/recursion/solvability.hpp"

/// Dynamics of mechanisms with loops: M a + h - Aᵀ λ = τ with A a + γ = 0. M is the mass matrix and h the
/// bias force of the spanning tree; A is the Jacobian of the loop equations A v = 0, λ their multipliers, and
/// γ the part of (A v)' that does not depend on the accelerations a.
///
/// Loop equations may be redundant, because of the kinds of the loop joints (a planar four-bar in space) or
/// by geometry (Bricard's mechanism). The accelerations are unique nevertheless. If the multipliers are not
/// unique, those with the least Σ d² λ² are computed, where d² is the diagonal entry of A M⁻¹ Aᵀ for an
/// equation, but not less than a lower limit (D7.7). See (D7.1) to (D7.9) of
/// docs/derivations/loop-dynamics.md.
namespace axode {

/// Computes the accelerations a (nv) of a mechanism with loops from drive forces τ and, unless `lambda` is
/// empty, the multipliers λ of the loop equations (a number for each of the loops().rows equations; N m and
/// N). q and v should close the loops: their residuals are not corrected. Springs act only if their forces
/// are added to τ. O(n + m d + m² d + m³) for n bodies and m loop equations on paths of d joints. The
/// returned Solvability is not ok() if the mass matrix of the spanning tree is singular; a and λ are NaN
/// then. Throws std::invalid_argument for wrong sizes and for a model with prescribed motions.
template <class T>
Solvability forward_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             std::type_identity_t<std::span<T>> lambda = {},
                             const std::type_identity_t<Loads<T>>& loads = {});

/// Computes drive forces τ (nv) that produce the accelerations a of a mechanism with loops. `drives` has the
/// indices of the velocities on which drives act; if it is empty, these are the velocities of all joints that
/// are not passive. If several τ produce a, the one with the least sum of squares is computed, of numbers in
/// N m and N (D7.10). Also computes the multipliers λ of the loop equations unless `lambda` is empty.
/// `forces` (nv, may be empty) are additional joint forces, such as those of springs. Returns the norm of the
/// forces that no drive can produce, divided by the norm of all required forces: 0 to rounding if the drives
/// can produce a. Throws std::invalid_argument for wrong sizes and, in double precision, if a does not keep
/// the loops closed.
///
/// A limb is a part of the mechanism that is coupled to the rest only through one body, the platform. For
/// limbs of bounded size the cost is proportional to their number, without allocation ((D18.7) to (D18.9)).
/// Near singularities, if the mechanism can move while all drives are locked, or if λ is computed and not
/// unique, the function allocates and costs O(nv³).
template <class T>
[[nodiscard]] T inverse_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> a, std::type_identity_t<std::span<T>> tau,
                                 std::type_identity_t<std::span<T>> lambda = {},
                                 std::span<const int> drives = {},
                                 const std::type_identity_t<Loads<T>>& loads = {},
                                 std::type_identity_t<Numbers<T>> forces = {});

/// Computes all six components of the wrench that each joint of the spanning tree transmits from the
/// predecessor to the body. The accelerations a and the multipliers λ of the loops (a number for each of the
/// loops().rows equations) must belong to one solution of the equations of motion. W[i - 1] belongs to joint
/// i, in the representation Rep of the frame of body i, with this frame moved to the point `at` (origin of
/// the body frame or of the joint frame) without turning it; spatial wrenches are about the inertial origin.
/// The product Sᵀ W with a joint screw S is the drive force, which is 0 in passive joints, minus the forces
/// of armature and losses. Joints in a coupling also transmit the force of the coupling. If springs act in
/// the given motion, W contains their forces as if the joints transmitted them. O(n + m) for m loop
/// equations. Throws std::invalid_argument for wrong sizes.
template <RecursionRepresentation Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<Numbers<T>> lambda,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {}, WrenchPoint at = WrenchPoint::body);

/// Computes the wrenches that the joints of the spanning tree of a mechanism with loops transmit from the
/// predecessor to the body at accelerations a. The drive forces are those that inverse_dynamics() computes
/// for a and `drives`, the indices of the velocities on which drives act (if it is empty, those of all joints
/// that are not passive). W has n_bodies entries. W[i - 1] belongs to joint i, in the representation Rep of
/// the frame of body i with its origin moved to the point `at` of this body: the origin of the body frame or
/// of the joint frame. Spatial wrenches are about the inertial origin. If loop equations are redundant, the
/// multipliers of the loops, and with them the wrenches, are not unique; the multipliers with the least
/// weighted sum of squares are taken (D7.11). Returns the norm of the required joint forces that neither
/// drives nor loops can produce, divided by the norm of all required joint forces. Throws
/// std::invalid_argument for wrong sizes and, in double precision, if a does not keep the loops closed.
/// Allocates; O(nv³).
template <RecursionRepresentation Rep = BodyFixed, class T>
[[nodiscard]] T joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                               Numbers<T> a, std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                               std::span<const int> drives = {},
                               const std::type_identity_t<Loads<T>>& loads = {},
                               WrenchPoint at = WrenchPoint::body);

/// Computes the velocities v⁺ (nv) after an impact that imposes the loop equations on the velocities v before
/// the impact: A v⁺ = -e A v with the Jacobian A of the loop equations and the coefficient of restitution e
/// from 0 to 1 (D7.12). Also computes the impulses of the loop equations (a number for each of the
/// loops().rows equations; N m s and N s) unless `impulses` is empty. The kinetic energy decreases by (1 -
/// e²)/2 (A v)ᵀ (A M⁻¹ Aᵀ)⁺ A v with the mass matrix M of the spanning tree. v⁺ may share the memory of v.
/// Throws std::invalid_argument for wrong sizes and for an e that is not from 0 to 1.
template <class T>
Solvability impact(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, T restitution,
                   std::type_identity_t<std::span<T>> v_after,
                   std::type_identity_t<std::span<T>> impulses = {});

/// Computes the wrench that each loop joint exerts on its second body for the multipliers λ of the loop
/// equations (a number for each of the loops().rows equations), in the representation Rep of the frame of
/// that body. W has one entry for each loop joint, followed by one for each coupling. The entries of
/// couplings are 0, because a coupling, an equation of joint coordinates, exerts joint forces alone.
template <RecursionRepresentation Rep = BodyFixed, class T>
void loop_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                   std::type_identity_t<std::span<Wrench<Rep, T>>> W);

}  // namespace axode
