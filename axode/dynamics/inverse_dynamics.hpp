#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// τ = M(q) a + C(q, v) v + g(q) - (applied forces): the drive forces for accelerations a, by the recursive
/// Newton-Euler algorithm (sections 4.1 to 4.3, eqs. aVbRec2 to cWhRec with erratum 22). tau has nv entries,
/// N m or N. Armature is part of it; damping and friction only if loads.joint_losses is set. O(n), no
/// allocation. Throws std::invalid_argument for a wrong size, a quaternion that is not of unit norm or a load
/// on a frame that does not exist.
template <RecursionChoice Rep = Fast, class T>
void inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                      std::type_identity_t<std::span<T>> tau,
                      const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
