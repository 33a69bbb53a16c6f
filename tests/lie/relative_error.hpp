#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <concepts>
#include <limits>
#include <string>

#include "axode/eigen.hpp"

/// Distances between quantities of the same kind, by norms.
namespace axode::test {

/// The scalar types for which laws are tested, with their names.
using Scalars = testing::Types<double, float>;
struct ScalarNames {
  template <class T> static std::string GetName(int) { return std::same_as<T, double> ? "double" : "float"; }
};

/// The tolerance of laws: a few hundred rounding errors.
template <class T> inline constexpr T tolerance = T(500) * std::numeric_limits<T>::epsilon();

/// The largest error to reference values of more digits, normwise and relative to the reference.
inline constexpr double reference_bound = 1e-13;

/// By a loop, because expressions of matrices take longer to compile than what is tested.
template <class Matrix> auto norm_of_entries(const Matrix& x) {
  typename Matrix::Scalar squares(0);
  for (Eigen::Index k = 0; k < x.size(); ++k) squares += x.data()[k] * x.data()[k];
  return std::sqrt(squares);
}

/// ‖a - b‖.
template <class Quantity> auto distance(const Quantity& a, const Quantity& b) {
  auto difference = to_eigen(a);
  const auto subtracted = to_eigen(b);
  for (Eigen::Index k = 0; k < difference.size(); ++k) difference.data()[k] -= subtracted.data()[k];
  return norm_of_entries(difference);
}

/// ‖a - reference‖ / ‖reference‖.
template <class Quantity> auto relative_error(const Quantity& a, const Quantity& reference) {
  const auto size = norm_of_entries(to_eigen(reference));
  const auto error = distance(a, reference);
  return error == 0 ? error : error / size;
}

}  // namespace axode::test
