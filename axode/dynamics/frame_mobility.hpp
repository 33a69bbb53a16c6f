#pragma once
#include <cstddef>
#include <span>

#include "axode/lie/six.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// J Y for a Jacobian J and the response Y of the velocities to impulses on its place: 36 entries, made symmetric.
template <class Rep, class T>
void frame_mobility(std::span<const Twist<Rep, T>> J, std::span<const Twist<Rep, T>> Y, T* mobility) {
  for (std::size_t k = 0; k < 36; ++k) mobility[k] = T(0);
  for (std::size_t c = 0; c < J.size(); ++c)
    for (int r = 0; r < 6; ++r)
      for (int s = 0; s < 6; ++s) mobility[6 * r + s] += entry(J[c], r) * entry(Y[c], s);
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t s = 0; s < r; ++s)
      mobility[6 * r + s] = mobility[6 * s + r] = T(0.5) * (mobility[6 * r + s] + mobility[6 * s + r]);
}

}  // namespace axode
