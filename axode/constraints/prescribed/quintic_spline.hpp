#pragma once
#include <span>
#include <vector>

namespace axode {

/// The spline of degree 5 through samples, with four continuous derivatives. It has a knot at every sample
/// except the two next to the first and the two next to the last one, so that it is exact for polynomials of
/// degree 5. Fewer than six samples give one polynomial of lower degree.
class QuinticSpline {
 public:
  /// Interpolates two or more samples at increasing times. O(n) for n samples.
  QuinticSpline(std::span<const double> times, std::span<const double> values);

  /// The derivative of an order from 0 to 5 at time t; outside the samples, of the first or last polynomial.
  double derivative(int order, double t) const;

 private:
  /// The index of the last knot at or before the time t, which determines the B-splines that are not 0 at t.
  /// A t outside the samples is replaced by the nearest sample.
  int interval(double t) const;
  /// Replaces the sample values in coefficients_ by the coefficients of the B-splines with these values.
  void interpolate(std::span<const double> times);

  int degree_;
  std::vector<double> knots_;         ///< the first and the last time, degree + 1 times each, and knots in
                                      ///< between
  std::vector<double> coefficients_;  ///< coefficients of the B-splines
};

}  // namespace axode
