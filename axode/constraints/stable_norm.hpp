#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "axode/model/finite.hpp"

/// Comparison of norms with tolerances for numbers whose squares overflow.
namespace axode {

/// The Euclidean norm of numbers whose squares may overflow, but at most the largest double. If a number is
/// infinite or NaN, the norm is infinite or NaN.
inline double stable_norm(std::span<const double> x) {
  const double norm = Eigen::Map<const Eigen::VectorXd>(x.data(), std::ssize(x)).norm();
  if (std::isfinite(norm) || !finite(x)) return norm;
  double size = 0;
  for (const double x_k : x) size = std::hypot(size, x_k);
  return std::min(size, std::numeric_limits<double>::max());
}

/// Whether an error is finite and at most `bound`, which may be infinite.
inline bool is_within(double error, double bound) {
  return error <= std::min(bound, std::numeric_limits<double>::max());
}

}  // namespace axode
