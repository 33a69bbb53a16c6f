#include "axode/constraints/prescribed/quintic_spline.hpp"

#include <algorithm>
#include <array>

namespace axode {
namespace {

constexpr int quintic = 5;
/// Number of samples after the first one, and before the last one, that are not knots.
constexpr int without_knots = 2;

}  // namespace

QuinticSpline::QuinticSpline(std::span<const double> times, std::span<const double> values)
    : degree_(std::min(quintic, static_cast<int>(times.size()) - 1)),
      knots_(static_cast<std::size_t>(degree_) + 1, times.front()),
      coefficients_(values.begin(), values.end()) {
  if (times.size() > quintic + 1)
    knots_.insert(knots_.end(), times.begin() + without_knots + 1, times.end() - without_knots - 1);
  knots_.insert(knots_.end(), static_cast<std::size_t>(degree_) + 1, times.back());
  interpolate(times);
}

int QuinticSpline::interval(double t) const {
  const auto first = knots_.begin() + degree_, last = knots_.end() - degree_ - 1;
  const auto above = std::upper_bound(first, last, t);
  return static_cast<int>(std::max(above - knots_.begin(), std::ptrdiff_t{degree_} + 1)) - 1;
}

void QuinticSpline::interpolate(std::span<const double> times) {
  // The matrix of the B-splines at the samples is banded and totally positive, so that its elimination needs
  // no pivots (de Boor, A Practical Guide to Splines, chapter XIII).
  const int n = static_cast<int>(times.size()), width = 2 * degree_ + 1;
  std::vector<double> band(static_cast<std::size_t>(n) * static_cast<std::size_t>(width));
  const auto entry = [&](int row, int column) -> double& {
    return band[static_cast<std::size_t>(row * width + column - row + degree_)];
  };
  const auto knot = [&](int k) { return knots_[static_cast<std::size_t>(k)]; };
  for (int row = 0; row < n; ++row) {
    const double t = times[static_cast<std::size_t>(row)];
    const int at = interval(t);
    std::array<double, quintic + 1> B{1};  // the B-splines that are not 0 at t, degree by degree
    for (int p = 1; p <= degree_; ++p) {
      double carried = 0;
      for (int k = 0; k < p; ++k) {
        const double left = knot(at + k + 1 - p), right = knot(at + k + 1), part = B[k] / (right - left);
        B[k] = carried + (right - t) * part;
        carried = (t - left) * part;
      }
      B[p] = carried;
    }
    for (int k = 0; k <= degree_; ++k) entry(row, at - degree_ + k) = B[k];
  }
  for (int k = 0; k < n; ++k)
    for (int row = k + 1; row <= std::min(k + degree_, n - 1); ++row) {
      const double factor = entry(row, k) / entry(k, k);
      for (int column = k; column <= std::min(k + degree_, n - 1); ++column)
        entry(row, column) -= factor * entry(k, column);
      coefficients_[static_cast<std::size_t>(row)] -= factor * coefficients_[static_cast<std::size_t>(k)];
    }
  for (int row = n - 1; row >= 0; --row) {
    double& x = coefficients_[static_cast<std::size_t>(row)];
    for (int column = row + 1; column <= std::min(row + degree_, n - 1); ++column)
      x -= entry(row, column) * coefficients_[static_cast<std::size_t>(column)];
    x /= entry(row, row);
  }
}

double QuinticSpline::derivative(int order, double t) const {
  if (order > degree_) return 0;
  const int at = interval(t);
  const auto knot = [&](int k) { return knots_[static_cast<std::size_t>(at + k)]; };
  std::array<double, quintic + 1> c{};
  std::copy_n(coefficients_.begin() + at - degree_, degree_ + 1, c.begin());
  for (int r = 1; r <= order; ++r)  // coefficients of the derivative
    for (int k = degree_; k >= r; --k)
      c[k] = (degree_ - r + 1) * (c[k] - c[k - 1]) / (knot(k + 1 - r) - knot(k - degree_));
  const int p = degree_ - order;
  for (int r = 1; r <= p; ++r)  // de Boor's algorithm
    for (int k = degree_; k >= order + r; --k) {
      const double left = knot(k - degree_), right = knot(k - degree_ + p + 1 - r);
      c[k] += (right - t) / (right - left) * (c[k - 1] - c[k]);
    }
  return c[degree_];
}

}  // namespace axode
