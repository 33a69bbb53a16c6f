#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// Computes τ = M(q) a + C(q, v) v + g(q) - (generalised forces of the loads), the drive forces for
/// accelerations a, by the recursive Newton-Euler algorithm (Müller, sections 4.1 to 4.3, eqs. aVbRec2 to
/// cWhRec; aWbRec, bWsRec and bWhRec with erratum 22 of docs/errata.md, bVhRec2 with erratum 23). τ has nv
/// entries, N m or N. It includes armatures, and damping, friction and losses of gears (D9.9) only if
/// loads.joint_losses is set. O(n), no allocation if no gear has losses.
/// Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm, a load on a frame
/// that does not exist, and losses of gears in a mechanism with springs, because the forces of springs do not
/// pass through the gears.
template <RecursionChoice Rep = Fast, class T>
void inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> tau,
                      const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
