#pragma once
#include <span>
#include <vector>

namespace axode {

/// The spline of degree 5 through samples, with four continuous derivatives. It has no knots at the second,
/// third, last but one and last but two samples, so that it repeats polynomials of degree 5. Fewer than six
/// samples make a polynomial.
class QuinticSpline {
 public:
  /// Two or more samples at increasing times. O(n).
  QuinticSpline(std::span<const double> times, std::span<const double> values);

  /// The derivative of an order from 0 to 5 at a time; outside the samples the polynomials at the ends go on.
  double derivative(int order, double t) const;

 private:
  /// The index of the last knot before or at t, so that t is in the support of degree + 1 B-splines.
  int interval(double t) const;
  /// Replaces the values of the samples by the coefficients of B-splines with these values.
  void interpolate(std::span<const double> times);

  int degree_;
  std::vector<double> knots_;         ///< degree + 1 times the first and the last time, and knots in between
  std::vector<double> coefficients_;  ///< of the B-splines
};

}  // namespace axode
