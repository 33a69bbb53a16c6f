#pragma once
#include <cstddef>
#include <span>

#include "axode/lie/six.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// Computes the inverse operational-space inertia J M⁻¹ Jᵀ = J Y (36 entries, row by row) of a place (a frame
/// on a body) from its Jacobian J (nv columns) and Y = M⁻¹ Jᵀ (nv rows), with the mass matrix M. It is made
/// exactly symmetric.
template <class Rep, class T>
void inverse_frame_inertia(std::span<const Twist<Rep, T>> J, std::span<const Twist<Rep, T>> Y,
                           T* Lambda_inverse) {
  for (std::size_t k = 0; k < 36; ++k) Lambda_inverse[k] = T(0);
  for (std::size_t c = 0; c < J.size(); ++c)
    for (int r = 0; r < 6; ++r)
      for (int s = 0; s < 6; ++s) Lambda_inverse[6 * r + s] += entry(J[c], r) * entry(Y[c], s);
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t s = 0; s < r; ++s)
      Lambda_inverse[6 * r + s] = Lambda_inverse[6 * s + r] =
          T(0.5) * (Lambda_inverse[6 * r + s] + Lambda_inverse[6 * s + r]);
}

}  // namespace axode
