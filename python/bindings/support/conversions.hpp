#pragma once
#include <algorithm>
#include <concepts>
#include <span>
#include <vector>

#include "axode/eigen.hpp"
#include "python/bindings/support/array.hpp"

/// Conversions to arrays of numpy and back: vectors (3,), twists and wrenches (6,) with the angular part
/// first, poses (4, 4), inertia matrices (6, 6), quaternions (4,) in the order x y z w.
namespace axode::python {

inline void write(const Vec3<>& a, double* to) {
  to[0] = a.x;
  to[1] = a.y;
  to[2] = a.z;
}
template <class Screwlike> void write_screw(const Screwlike& X, double* to) {
  const auto& [a, b] = X;
  write(a, to);
  write(b, to + 3);
}
void write(const SE3<>& C, double* to);

/// The deviation of a matrix from a rotation; infinite if products of its entries overflow.
double rotation_error(const SO3<>& R);
/// A pose from 16 numbers, the 4 × 4 matrix row by row. Throws nb::value_error, which names the argument, if
/// the rotation is not exact to 1e-6 or if the last row is not (0, 0, 0, 1).
SE3<> pose_from(const std::string& argument, const double* matrix);
inline Vec3<> vector_from(const double* x) { return {x[0], x[1], x[2]}; }

Array to_array(std::span<const double> numbers);
inline Array to_array(const std::vector<double>& numbers) { return to_array(std::span(numbers)); }
Array to_array(const Vec3<>& a);
Array to_array(const SE3<>& C);
Array to_array(const Inertia<>& M);
template <std::same_as<Eigen::VectorXd> Vector> Array to_array(const Vector& x) {
  return to_array(as_span(x));
}
/// The matrix as an array, row by row, whatever the order in which the matrix is stored.
Array to_array(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

/// An array of six rows with a column for each screw.
template <class Screwlike> Array columns(std::span<const Screwlike> screws) {
  NewArray out({static_cast<nb::ssize_t>(screws.size()), 6});
  double* to = out.data();
  for (const Screwlike& X : screws) {
    write_screw(X, to);
    to += 6;
  }
  return out.transposed();
}

inline void put(const std::vector<double>& numbers, std::span<double> out) {
  std::copy(numbers.begin(), numbers.end(), out.begin());
}

/// A span of numbers as a span of screws: each screw consists of six consecutive numbers.
template <class Screwlike> std::span<Screwlike> screws(std::span<double> numbers) {
  static_assert(sizeof(Screwlike) == 6 * sizeof(double));
  return {reinterpret_cast<Screwlike*>(numbers.data()), numbers.size() / 6};
}
template <class Screwlike> std::span<const Screwlike> screws(std::span<const double> numbers) {
  return {reinterpret_cast<const Screwlike*>(numbers.data()), numbers.size() / 6};
}

}  // namespace axode::python
