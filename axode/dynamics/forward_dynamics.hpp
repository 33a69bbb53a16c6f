#pragma once
#include "axode/fast/fast.hpp"
#include "axode/kinematics/arguments.hpp"
#include "axode/recursion/loads.hpp"
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The accelerations a for drive forces τ: M(q) a + C(q, v) v + g(q) = τ + (applied forces), the inverse of
/// inverse_dynamics with the same loads. a has nv entries. O(n) by the articulated-body algorithm; coupled
/// joints add a cost that is proportional to the square of the number of couplings whose paths overlap. If
/// the mass matrix is singular or a number is not finite, the returned status says so, and a is NaN. Losses
/// of gears that move cost O(n²) and allocate; if a gear locks itself so strongly that the accelerations are
/// not unique (D9.12), the status says so. They throw in a mechanism with springs, as in inverse_dynamics.
template <RecursionChoice Rep = Fast, class T>
Solvability forward_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                             Numbers<T> tau, std::type_identity_t<std::span<T>> a,
                             const std::type_identity_t<Loads<T>>& loads = {});

}  // namespace axode
