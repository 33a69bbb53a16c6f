#pragma once
#include "axode/kinematics/arguments.hpp"

namespace axode {

/// The momenta Π_i = M_i V_i of all bodies, each in the representation Rep of the frame of the body. n_bodies
/// entries, O(n).
template <RecursionRepresentation Rep = BodyFixed, class T>
void body_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                  std::type_identity_t<std::span<Momentum<Rep, T>>> Pi);

}  // namespace axode
