#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// Computes the accelerations a (nv entries) for drive forces τ from M(q) a + C(q, v) v + g(q) = τ +
/// (generalised forces of the loads). O(n) by the articulated-body algorithm. Coupled joints add up to O(c²)
/// for each velocity if at most c paths of couplings pass through one body; the path of a coupling has the
/// bodies between its joints. If the mass matrix is singular, the returned Solvability names a body and all
/// of a is NaN. The Solvability also says if a result is not finite.
///
/// If loads.joint_losses is set, the losses of gears are included for joints that move (D9.10). This
/// allocates. For k gears with losses whose joints move, it costs O(n²) and a few factorisations of k × k
/// matrices. If a gear locks itself so strongly that the accelerations are not unique (D9.12), the
/// Solvability names its body. Losses of gears in a mechanism with springs throw std::invalid_argument,
/// because τ could contain the forces of the springs, which do not pass through the gears.
template <RecursionChoice Rep = Fast, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
