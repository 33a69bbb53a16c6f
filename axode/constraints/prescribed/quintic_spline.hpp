#pragma once
#include <span>
#include <vector>

namespace axode {

/// The spline of degree 5 through samples, with four continuous derivatives. Two samples at each end, next to
/// the first and the last one, are not knots, so that polynomials of degree 5 are reproduced. Fewer than six
/// samples give one polynomial of lower degree.
class QuinticSpline {
 public:
  /// Interpolates two or more samples at increasing times. O(n) for n samples.
  QuinticSpline(std::span<const double> times, std::span<const double> values);

  /// The derivative of an order from 0 to 5 at time t; outside the samples, of the first or last polynomial.
  double derivative(int order, double t) const;

 private:
  /// The index of the last knot before or at t, where a t outside the samples is moved to the nearest one. It
  /// determines the B-splines that are not 0 at t.
  int interval(double t) const;
  /// Replaces the sample values in coefficients_ by the coefficients of the B-splines with these values.
  void interpolate(std::span<const double> times);

  int degree_;
  std::vector<double> knots_;         ///< the first and the last time, degree + 1 times each, and knots in
                                      ///< between
  std::vector<double> coefficients_;  ///< coefficients of the B-splines
};

}  // namespace axode
