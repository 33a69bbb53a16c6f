#pragma once
#include "axode/derivatives/term_derivatives.hpp"

namespace axode {

/// ∂/∂q and ∂/∂v of spring_forces(), nv × nv, [component, direction]; exact, second derivatives of the
/// logarithms and the distances included. No allocation; O(nv²) for the zeros, O(depth²) for each line.
template <class T>
void spring_force_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              const std::type_identity_t<StateDerivatives<T>>& d);

}  // namespace axode
