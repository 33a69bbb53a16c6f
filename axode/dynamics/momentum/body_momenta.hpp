#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The momenta Π_i = M_i V_i of all bodies (n_bodies entries), in representation Rep of their frames; O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void body_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                  std::type_identity_t<std::span<Momentum<Rep, T>>> Pi);

}  // namespace axode
