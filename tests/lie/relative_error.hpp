#pragma once
#include <gtest/gtest.h>

#include <concepts>
#include <limits>
#include <string>

#include "axode/eigen.hpp"

/// Normwise distances between quantities of the same kind.
namespace axode::test {

/// The scalars over which laws are tested, with their names.
using Scalars = testing::Types<double, float>;
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};

/// A few hundred roundings.
template <class T> inline constexpr T tolerance = T(500) * std::numeric_limits<T>::epsilon();

/// ‖a - b‖.
template <class Quantity> auto distance(const Quantity& a, const Quantity& b) {
  return (to_eigen(a) - to_eigen(b)).norm();
}

/// ‖a - reference‖ / ‖reference‖.
template <class Quantity> auto relative_error(const Quantity& a, const Quantity& reference) {
  const auto size = to_eigen(reference).norm();
  const auto error = distance(a, reference);
  return error == 0 ? error : error / size;
}

}  // namespace axode::test
