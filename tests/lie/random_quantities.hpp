#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "axode/lie.hpp"

namespace axode::test {

/// Random quantities of the order of one. The seed is fixed, so that failures repeat, and every failure
/// prints it. No two quantities are drawn in the arguments of one call, because compilers evaluate these in
/// different orders; so all of them draw the same numbers.
template <class T> class Random {
 public:
  explicit Random(std::uint64_t seed = 1)
      : engine_(seed), trace_(__FILE__, __LINE__, "random quantities with seed " + std::to_string(seed)) {}

  /// A number in [low, high) with a uniform distribution. It is the number that std::uniform_real_distribution
  /// draws. That class computes a logarithm for each number if it is compiled without optimisation.
  T number(T low, T high) {
    const T part = static_cast<T>(engine_()) * static_cast<T>(0x1p-64);
    return low + (high - low) * std::min(part, T(1) - std::numeric_limits<T>::epsilon() / 2);
  }
  Vec3<T> vector(T size = T(1)) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  Vec3<T> direction() {
    for (;;) {
      const Vec3<T> a = vector();
      const T length = norm(a);
      if (length > T(0.1) && length < T(1)) return (T(1) / length) * a;
    }
  }
  /// A rotation vector with an angle in (low, high).
  Vec3<T> rotation_vector(T low, T high) {
    const Vec3<T> e = direction();
    return number(low, high) * e;
  }
  SO3<T> rotation() { return exp_SO3(rotation_vector(T(0), T(3.1))); }
  SE3<T> pose() { return {rotation(), vector(T(2))}; }
  Screw<T> screw() { return {vector(), vector()}; }
  /// A random twist, twist rate, wrench or momentum, or any other pair of vectors.
  template <class Quantity> Quantity any() { return {vector(), vector()}; }
  Sym3<T> tensor() {
    return {number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1)};
  }
  /// The inertia of six point masses at random places.
  Inertia<T> inertia() {
    Inertia<T> M;
    for (int k = 0; k < 6; ++k) {
      const Vec3<T> place = vector();
      M += inertia_from_com(number(T(0.1), T(1)), place, Sym3<T>{});
    }
    return M;
  }

 private:
  std::mt19937_64 engine_;
  testing::ScopedTrace trace_;
};

}  // namespace axode::test
