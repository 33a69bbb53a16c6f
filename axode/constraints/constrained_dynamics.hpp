#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/recursion/solvability.hpp"

/// Dynamics of mechanisms with loops: M a + h - Aᵀ λ = τ with A a + γ = 0.
///
/// Rows of loops may be redundant, by their kinds (a planar four-bar in space) or by geometry (Bricard's
/// mechanism). The accelerations are unique nevertheless. Of all possible multipliers the least ones are
/// computed, in a norm that weights each row by the mass that it moves. See
/// docs/derivations/loop-dynamics.md.
namespace axode {

/// Computes accelerations a (nv) from drive forces τ, and the multipliers λ (loops().rows numbers, N m and N)
/// unless `lambda` is empty. q and v should be closed, see assemble(): their residuals are not corrected. O(n
/// + m d + m² d + m³) for m rows on paths of d joints. The result is singular if the mass matrix of the tree
/// is.
template <class T>
Solvability forward_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             std::type_identity_t<std::span<T>> lambda = {},
                             const std::type_identity_t<Loads<T>>& loads = {});

/// Computes drive forces τ (nv) that produce the accelerations a, with drives at the velocities `drives` or,
/// if this is empty, at the velocities of all joints that are not passive. If there are more drives than the
/// mechanism needs, τ is the least one (D7.10). `forces` (nv, may be empty), such as spring_forces, act in
/// addition. Returns the part of the required forces, by norm, that no drive can produce: 0 to rounding if
/// the drives can produce a. Throws std::invalid_argument, in double precision, if a does not keep the loops
/// closed. The forces are found limb by limb, see docs/derivations/constraint-embedding.md: O(limbs) for
/// limbs of bounded size, without allocating. If some motion has no drive, if `lambda` is not unique, or near
/// singularities, a general method allocates and costs O(nv³).
template <class T>
[[nodiscard]] T inverse_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> a, std::type_identity_t<std::span<T>> tau,
                                 std::type_identity_t<std::span<T>> lambda = {},
                                 std::span<const int> drives = {},
                                 const std::type_identity_t<Loads<T>>& loads = {},
                                 std::type_identity_t<Numbers<T>> forces = {});

/// Computes the wrench that each joint of the tree transmits from the predecessor to the body, drive and
/// reaction, for accelerations a and multipliers λ (loops().rows) of one result of forward_dynamics() or
/// inverse_dynamics(). W has n_bodies entries, in the representation Rep of the body's frame moved to the
/// point `at`, as in the overload for trees. The method is a Newton-Euler recursion in which the wrenches W λ
/// of the loops are applied to the bodies. Sᵀ W is the drive force minus the forces of armature and losses;
/// it is 0 in passive joints, and joints in a coupling also transmit the force of the coupling. Springs are
/// ignored, as in inverse_dynamics(). O(n + m).
template <RecursionRepresentation Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<Numbers<T>> lambda,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {}, WrenchPoint at = WrenchPoint::body);

/// Computes the joint wrenches under the drive forces and multipliers of inverse_dynamics() for a. If loops
/// are redundant, the share of each loop is indeterminate for rigid bodies; the wrenches are those of the
/// least multipliers. Returns the part of the required forces that no drive can produce, and throws, as
/// inverse_dynamics() does. Allocates; O(nv³).
template <RecursionRepresentation Rep = BodyFixed, class T>
[[nodiscard]] T joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                               Numbers<T> a, std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                               std::span<const int> drives = {},
                               const std::type_identity_t<Loads<T>>& loads = {},
                               WrenchPoint at = WrenchPoint::body);

/// Computes the velocities v⁺ (nv) after an impact that closes the loops, A v⁺ = -e A v with the coefficient
/// of restitution e, and the impulses (loops().rows; N m s and N s). The energy decreases by (1 - e²)/2 (A
/// v)ᵀ (A M⁻¹ Aᵀ)⁻¹ A v. v⁺ may share the memory of v. See (D7.12).
template <class T>
Solvability impact(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, T restitution,
                   std::type_identity_t<std::span<T>> v_after,
                   std::type_identity_t<std::span<T>> impulses = {});

/// Computes the wrenches W λ of the loops on their second bodies, in a representation of the frame of that
/// body. W has an entry for each of loops().all; those of couplings are 0.
template <RecursionRepresentation Rep = BodyFixed, class T>
void loop_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                   std::type_identity_t<std::span<Wrench<Rep, T>>> W);

}  // namespace axode
