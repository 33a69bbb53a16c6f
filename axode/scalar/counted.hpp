#pragma once
#include <array>
#include <type_traits>

#include "axode/lie/scalar.hpp"
#include "axode/lie/screw_operation_scope.hpp"

namespace axode {

/// Counts of arithmetic operations by kind, and of operations on whole screws and inertias.
struct Operations {
  long products = 0, sums = 0, divisions = 0, roots = 0, angles = 0;  ///< angles: sin, cos, atan2
  std::array<long, n_screw_operations> screws{};

  /// The number of all counted arithmetic operations; an operation of any kind counts as one.
  long total() const { return products + sums + divisions + roots + angles; }
  long operator[](ScrewOperation kind) const { return screws[static_cast<std::size_t>(kind)]; }
};

/// A number that counts the operations with it, also those with an exact 0 or 1; count() returns the counts.
class Counted {
 public:
  Counted() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number> Counted(Number value)
        : x_(static_cast<double>(value)) {}  // NOLINT(google-explicit-constructor): a constant
    explicit operator double() const { return x_; }

    /// The counts of this thread since they were last set; assign {} to start a new count.
    static Operations& count() {
      thread_local Operations operations;
      return operations;
    }

    friend Counted operator+(const Counted& a, const Counted& b) {
      return ++count().sums, Counted(a.x_ + b.x_);
    }
    friend Counted operator-(const Counted& a, const Counted& b) {
      return ++count().sums, Counted(a.x_ - b.x_);
    }
    friend Counted operator-(const Counted& a) { return Counted(-a.x_); }
    friend Counted operator*(const Counted& a, const Counted& b) {
      return ++count().products, Counted(a.x_ * b.x_);
    }
    friend Counted operator/(const Counted& a, const Counted& b) {
      return ++count().divisions, Counted(a.x_ / b.x_);
    }
    Counted& operator+=(const Counted& b) { return *this = *this + b; }
    Counted& operator-=(const Counted& b) { return *this = *this - b; }
    friend Counted sqrt(const Counted& a) { return ++count().roots, Counted(std::sqrt(a.x_)); }
    friend Counted sin(const Counted& a) { return ++count().angles, Counted(std::sin(a.x_)); }
    friend Counted cos(const Counted& a) { return ++count().angles, Counted(std::cos(a.x_)); }
    friend Counted atan2(const Counted& a, const Counted& b) {
      return ++count().angles, Counted(std::atan2(a.x_, b.x_));
    }
    friend bool operator<(const Counted& a, const Counted& b) { return a.x_ < b.x_; }
    friend bool operator>(const Counted& a, const Counted& b) { return a.x_ > b.x_; }
    friend bool operator<=(const Counted& a, const Counted& b) { return a.x_ <= b.x_; }
    friend Counted select(bool condition, const Counted& a, const Counted& b) { return condition ? a : b; }

   private:
    double x_ = 0;
};

/// Counts an operation on screws, unless it is part of another operation that is being counted.
template <> struct [[maybe_unused]] ScrewOperationScope<Counted> {
  explicit ScrewOperationScope(ScrewOperation kind) {
    if (depth()++ == 0) ++Counted::count().screws[static_cast<std::size_t>(kind)];
  }
  ~ScrewOperationScope() { --depth(); }
  ScrewOperationScope(const ScrewOperationScope&) = delete;
  ScrewOperationScope& operator=(const ScrewOperationScope&) = delete;

 private:
  static int& depth() {
    thread_local int operations_under_way = 0;
    return operations_under_way;
  }
};

template <> inline constexpr double unit_roundoff<Counted> = unit_roundoff<double>;

}  // namespace axode
