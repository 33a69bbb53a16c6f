#pragma once
#include "axode/lie/so3.hpp"

namespace axode {

/// A 3×3 matrix, stored by its columns.
template <class T = double> struct Mat3 { Vec3<T> x, y, z; };

template <class T> constexpr Mat3<T> operator+(const Mat3<T>& A, const Mat3<T>& B) {
  return {A.x + B.x, A.y + B.y, A.z + B.z};
}
template <class T> constexpr Mat3<T>& operator+=(Mat3<T>& A, const Mat3<T>& B) { return A = A + B; }
template <class T> constexpr Mat3<T> operator*(const T& s, const Mat3<T>& A) {
  return {s * A.x, s * A.y, s * A.z};
}
template <class T> constexpr Vec3<T> operator*(const Mat3<T>& A, const Vec3<T>& a) {
  return a.x * A.x + a.y * A.y + a.z * A.z;
}
template <class T> constexpr Mat3<T> operator*(const SO3<T>& R, const Mat3<T>& A) {
  return {R * A.x, R * A.y, R * A.z};
}
template <class T> constexpr Mat3<T> operator*(const Mat3<T>& A, const SO3<T>& R) {
  return {A * R.x, A * R.y, A * R.z};
}
template <class T> constexpr Mat3<T> transpose(const Mat3<T>& A) {
  return {{A.x.x, A.y.x, A.z.x}, {A.x.y, A.y.y, A.z.y}, {A.x.z, A.y.z, A.z.z}};
}
/// The product Aᵀ a.
template <class T> constexpr Vec3<T> transposed_times(const Mat3<T>& A, const Vec3<T>& a) {
  return {dot(A.x, a), dot(A.y, a), dot(A.z, a)};
}
/// The skew matrix ã of a vector.
template <class T> constexpr Mat3<T> skew_matrix(const Vec3<T>& a) {
  return {{T(0), a.z, -a.y}, {-a.z, T(0), a.x}, {a.y, -a.x, T(0)}};
}
/// The matrix r̃ A: every column of A is multiplied by r ×.
template <class T> constexpr Mat3<T> cross(const Vec3<T>& r, const Mat3<T>& A) {
  return {cross(r, A.x), cross(r, A.y), cross(r, A.z)};
}
/// The matrix a bᵀ.
template <class T> constexpr Mat3<T> outer_product(const Vec3<T>& a, const Vec3<T>& b) {
  return {b.x * a, b.y * a, b.z * a};
}
/// The symmetric tensor A + Aᵀ.
template <class T> constexpr Sym3<T> plus_transpose(const Mat3<T>& A) {
  return {A.x.x + A.x.x, A.y.y + A.y.y, A.z.z + A.z.z, A.x.y + A.y.x, A.x.z + A.z.x, A.y.z + A.z.y};
}
/// A symmetric tensor as a matrix.
template <class T> constexpr Mat3<T> matrix(const Sym3<T>& A) {
  return {{A.xx, A.xy, A.xz}, {A.xy, A.yy, A.yz}, {A.xz, A.yz, A.zz}};
}
/// The symmetric tensor a aᵀ.
template <class T> constexpr Sym3<T> square(const Vec3<T>& a) {
  return {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.x * a.z, a.y * a.z};
}

}  // namespace axode
