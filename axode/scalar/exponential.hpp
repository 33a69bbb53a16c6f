#pragma once
#include <cmath>
#include <cstddef>

#include "axode/scalar/dual.hpp"

namespace axode {

/// The exponential function of a number a that carries derivatives.
template <class S, std::size_t N> Dual<S, N> exp(const Dual<S, N>& a) {
  using std::exp;
  Dual<S, N> r(exp(a.x));
  for (std::size_t k = 0; k < N; ++k) r.dx[k] = r.x * a.dx[k];
  return r;
}

}  // namespace axode
