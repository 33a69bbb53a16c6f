#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <string>
#include <vector>

#include "axode/eigen.hpp"
#include "axode/model/fault.hpp"

/// Comparisons of anything made of numbers, relative to the largest number.
namespace axode::test {

/// The entries of anything made of numbers, one after the other.
template <std::floating_point T> void append(std::vector<double>& out, T x) { out.push_back(x); }
template <class Derived> void append(std::vector<double>& out, const Eigen::MatrixBase<Derived>& x) {
  for (const auto entry : x.derived().reshaped()) out.push_back(entry);
}
template <class Quantity>
  requires requires(const Quantity& x) { to_eigen(x); }
void append(std::vector<double>& out, const Quantity& x) { append(out, to_eigen(x)); }
template <class Entry> void append(std::vector<double>& out, const std::vector<Entry>& x) {
  for (const Entry& entry : x) append(out, entry);
}
template <class Quantity> std::vector<double> entries(const Quantity& x) {
  std::vector<double> out;
  append(out, x);
  return out;
}

inline double largest(const std::vector<double>& x) {
  double m = 0;
  for (const double entry : x) m = std::isnan(entry) ? entry : std::max(m, std::abs(entry));
  return m;
}

/// Compares quantities and remembers the largest difference, which goes into the test's report.
class Comparison {
 public:
  Comparison(const char* quantity, double bound) : quantity_(quantity), bound_(bound) {}
  ~Comparison() { testing::Test::RecordProperty(quantity_, to_text(worst_)); }
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  /// ‖x - reference‖∞ <= bound max(‖reference‖∞, scale).
  template <class Quantity>
  void expect_equal(const Quantity& x, const Quantity& reference, double scale = 0) {
    const std::vector<double> a = entries(x), b = entries(reference);
    ASSERT_EQ(a.size(), b.size());
    std::vector<double> difference;
    for (std::size_t k = 0; k < a.size(); ++k) difference.push_back(a[k] - b[k]);
    const double error = largest(difference), size = std::max(largest(b), scale);
    if (error > 0) worst_ = std::max(worst_, error / size);
    EXPECT_TRUE(error <= bound_ * size) << quantity_ << ": differs by " << error << " in " << size;
  }

 private:
  const char* quantity_;
  double bound_;
  double worst_ = 0;
};

}  // namespace axode::test
