#pragma once
#include "axode/constraints/loops.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/recursion/solvability.hpp"

/// Dynamics of mechanisms with loops: M a + h - Aᵀ λ = τ with A a + γ = 0.
///
/// Loops may be redundant, by their kinds (a planar four-bar in space) or by geometry (Bricard's): accelerations do not
/// depend on how, and of the multipliers those that are least, each row measured by the mass it moves, are given.
namespace axode {

/// Accelerations a (nv) from drive forces τ, and the multipliers λ (loops().rows; N m and N), none where the caller gives
/// no room. q and v should be closed, see assemble(): what they lack is not made up for. O(n + m d + m² d + m³) for m rows
/// on paths of d joints. Fails where the tree without its loops has a singular mass matrix.
template <class T>
Solvability forward_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             std::type_identity_t<std::span<T>> lambda = {},
                             const std::type_identity_t<Loads<T>>& loads = {});

/// Drive forces τ (nv) that make the accelerations a: at the velocities `drives` alone, or where none are given at those of
/// all joints that are not passive; the least where there are more drives than the mechanism needs. `forces` (nv), or none,
/// act besides, such as spring_forces. Returns what no drive can do, as a part of what is needed: 0 to rounding, where the
/// drives can make a. Throws std::invalid_argument where a tears a loop, in double precision. Allocates;
/// O(nv³).
template <class T>
[[nodiscard]] T inverse_dynamics(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                 Numbers<T> a, std::type_identity_t<std::span<T>> tau,
                                 std::type_identity_t<std::span<T>> lambda = {},
                                 std::span<const int> drives = {},
                                 const std::type_identity_t<Loads<T>>& loads = {},
                                 std::type_identity_t<Numbers<T>> forces = {});

/// The wrench that each joint of the tree transmits from the predecessor to the body, drive and reaction, at accelerations a
/// and multipliers λ (loops().rows) that belong together, as forward_dynamics() and inverse_dynamics() give them. W has
/// n_bodies entries, in the representation Rep of the body's frame moved to the point `at`, as the overload for trees has it.
/// Newton-Euler recursion with the wrenches W λ of the loops among the applied ones. Sᵀ W is the drive force less armature and
/// losses; it is 0 in passive joints, and joints in a coupling transmit the force of the coupling as well. Springs are left
/// out, as in inverse_dynamics(). O(n + m).
template <RecursionRepresentation Rep = BodyFixed, class T>
void joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                    std::type_identity_t<Numbers<T>> lambda,
                    std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                    const std::type_identity_t<Loads<T>>& loads = {}, WrenchPoint at = WrenchPoint::body);

/// These wrenches under the drive forces and the multipliers that inverse_dynamics() gives for a. Where loops are redundant,
/// the share of each loop is indeterminate for rigid bodies: the least multipliers are taken, and the wrenches go with them.
/// Returns what inverse_dynamics() returns, and throws as it does. Allocates; O(nv³).
template <RecursionRepresentation Rep = BodyFixed, class T>
[[nodiscard]] T joint_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                               Numbers<T> a, std::type_identity_t<std::span<Wrench<Rep, T>>> W,
                               std::span<const int> drives = {},
                               const std::type_identity_t<Loads<T>>& loads = {},
                               WrenchPoint at = WrenchPoint::body);

/// Velocities (nv) after an impact that closes the loops, A v⁺ = -e A v with the coefficient of restitution e, and the
/// impulses (loops().rows; N m s and N s). It takes (1 - e²)/2 (A v)ᵀ (A M⁻¹ Aᵀ)⁻¹ A v of the energy. v⁺ may take the place
/// of v.
template <class T>
Solvability impact(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> v, T restitution,
                   std::type_identity_t<std::span<T>> v_after,
                   std::type_identity_t<std::span<T>> impulses = {});

/// The wrenches W λ by which the loops act on their second bodies (all loops().all; those of couplings are 0), in a
/// representation of that body's frame.
template <RecursionRepresentation Rep = BodyFixed, class T>
void loop_wrenches(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q, Numbers<T> lambda,
                   std::type_identity_t<std::span<Wrench<Rep, T>>> W);

}  // namespace axode
