#pragma once
#include "axode/derivatives/term_derivatives.hpp"

namespace axode {

/// Computes the derivatives ∂τ/∂q and ∂τ/∂v of the generalised forces τ of all springs, nv × nv numbers each,
/// [component, direction]. They are exact: the second derivatives of spring coordinates, such as distances,
/// and of logarithms of rotations are included. No allocation; O(nv²) to write the zeros, and O(depth²) for
/// each spring between two points.
template <class T>
void spring_force_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              const std::type_identity_t<StateDerivatives<T>>& d);

}  // namespace axode
