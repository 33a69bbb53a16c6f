#pragma once
#include <gtest/gtest.h>

#include <concepts>
#include <vector>

#include "axode/eigen.hpp"

/// Comparisons of anything made of numbers, relative to the largest number.
namespace axode::test {

/// The entries of anything made of numbers, one after the other.
template <std::floating_point T> void append(std::vector<double>& out, T x) { out.push_back(x); }
void append(std::vector<double>& out, const Eigen::VectorXd& x);
void append(std::vector<double>& out, const Eigen::MatrixXd& x);
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

double largest(const std::vector<double>& x);

/// Compares quantities and remembers the largest difference, which goes into the test's report.
class Comparison {
 public:
  Comparison(const char* quantity, double bound) : quantity_(quantity), bound_(bound) {}
  ~Comparison();
  Comparison(const Comparison&) = delete;
  Comparison& operator=(const Comparison&) = delete;

  /// ‖x - reference‖∞ <= bound max(‖reference‖∞, scale).
  template <class Quantity>
  void expect_equal(const Quantity& x, const Quantity& reference, double scale = 0) {
    compare(entries(x), entries(reference), scale);
  }

 private:
  void compare(const std::vector<double>& x, const std::vector<double>& reference, double scale);

  const char* quantity_;
  double bound_;
  double worst_ = 0;
};

}  // namespace axode::test
