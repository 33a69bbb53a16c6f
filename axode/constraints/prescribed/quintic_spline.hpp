#pragma once
#include <span>
#include <vector>

namespace axode {

/// The spline of degree 5 through samples, with four continuous derivatives. The second, the third, and the
/// last two samples before the final one are not knots, so that polynomials of degree 5 are reproduced. If
/// there are fewer than six samples, the spline is one polynomial of lower degree.
class QuinticSpline {
 public:
  /// Interpolates two or more samples at increasing times. O(n) for n samples.
  QuinticSpline(std::span<const double> times, std::span<const double> values);

  /// The derivative of an order from 0 to 5 at time t. Outside the samples the first and the last polynomial
  /// are continued.
  double derivative(int order, double t) const;

 private:
  /// The index of the last knot before or at t, where t outside the samples is moved to the nearest one. This
  /// and the degree determine the B-splines that are not 0 at t.
  int interval(double t) const;
  /// Replaces the values of the samples, in coefficients_, by the coefficients of the B-splines with these
  /// values.
  void interpolate(std::span<const double> times);

  int degree_;
  std::vector<double> knots_;         ///< the first and the last time, degree + 1 times each, and knots in
                                      ///< between
  std::vector<double> coefficients_;  ///< coefficients of the B-splines
};

}  // namespace axode
