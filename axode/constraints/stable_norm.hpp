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
  const Eigen::Map<const Eigen::VectorXd> entries(x.data(), std::ssize(x));
  const double norm = entries.norm();
  if (std::isfinite(norm) || !finite(x)) return norm;
  return std::min(entries.stableNorm(), std::numeric_limits<double>::max());
}

/// Whether an error is finite and at most `bound`, which may be infinite.
inline bool is_within(double error, double bound) {
  return error <= std::min(bound, std::numeric_limits<double>::max());
}

}  // namespace axode
