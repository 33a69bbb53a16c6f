#pragma once
#include "axode/lie/exponential_series.hpp"
#include "axode/lie/vec3.hpp"

namespace axode {

/// A rotation matrix R, stored by columns. It maps coordinates in the rotated frame to outer coordinates.
template <class T = double> struct SO3 {
  Vec3<T> x{T(1), T(0), T(0)}, y{T(0), T(1), T(0)}, z{T(0), T(0), T(1)};
};

template <class T> constexpr Vec3<T> operator*(const SO3<T>& R, const Vec3<T>& a) {
  return {R.x.x * a.x + R.y.x * a.y + R.z.x * a.z, R.x.y * a.x + R.y.y * a.y + R.z.y * a.z,
          R.x.z * a.x + R.y.z * a.y + R.z.z * a.z};
}
template <class T> constexpr SO3<T> operator*(const SO3<T>& A, const SO3<T>& B) {
  return {A * B.x, A * B.y, A * B.z};
}
/// Rᵀ, which is the inverse of R.
template <class T> constexpr SO3<T> transpose(const SO3<T>& R) {
  return {{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}};
}
/// The rotated tensor R A Rᵀ.
template <class T> constexpr Sym3<T> rotate(const SO3<T>& R, const Sym3<T>& A) {
  const SO3<T> rows = transpose(R);
  const Vec3<T>&x = rows.x, &y = rows.y, &z = rows.z;
  const Vec3<T> Ax = A * x, Ay = A * y, Az = A * z;  // columns of A Rᵀ
  return {dot(x, Ax), dot(y, Ay), dot(z, Az), dot(x, Ay), dot(x, Az), dot(y, Az)};
}
template <class T> constexpr SO3<T> select(bool condition, const SO3<T>& A, const SO3<T>& B) {
  return {select(condition, A.x, B.x), select(condition, A.y, B.y), select(condition, A.z, B.z)};
}

/// exp: so(3) → SO(3), Rodrigues' formula; ξ is the rotation vector in rad.
template <class T> constexpr SO3<T> exp_SO3(const Vec3<T>& xi) {
  const ScrewOperator<T> R = exp_operator(dot(xi, xi));
  const Vec3<T> x{T(1), T(0), T(0)}, y{T(0), T(1), T(0)}, z{T(0), T(0), T(1)};
  return {apply(R, xi, x), apply(R, xi, y), apply(R, xi, z)};
}
/// dexp_ξ z: the right-trivialised differential, ω^s = dexp_ξ ξ'.
template <class T> constexpr Vec3<T> dexp(const Vec3<T>& xi, const Vec3<T>& z) {
  return apply(dexp_operator(dot(xi, xi)), xi, z);
}
/// dexp_ξ⁻¹ z. The map is singular at the angles 2π, 4π, ...
template <class T> constexpr Vec3<T> dexp_inv(const Vec3<T>& xi, const Vec3<T>& z) {
  return apply(dexp_inv_operator(dot(xi, xi)), xi, z);
}
/// The derivative of dexp_ξ z when ξ moves along η.
template <class T> constexpr Vec3<T> ddexp(const Vec3<T>& xi, const Vec3<T>& eta, const Vec3<T>& z) {
  return apply(dexp_operator(dot(xi, xi)), xi, eta, z);
}
/// The derivative of dexp_ξ⁻¹ z when ξ moves along η.
template <class T> constexpr Vec3<T> ddexp_inv(const Vec3<T>& xi, const Vec3<T>& eta, const Vec3<T>& z) {
  return apply(dexp_inv_operator(dot(xi, xi)), xi, eta, z);
}

/// The shortest rotation that takes e_z to the unit vector n. If n = -e_z it is half a turn about e_x.
template <class T> constexpr SO3<T> rotation_to(const Vec3<T>& n) {
  const T s = n.x * n.x + n.y * n.y;                                      // sin² of the angle
  const T k = select(n.z > T(0), T(1) / (T(1) + n.z), (T(1) - n.z) / s);  // (1 - cos)/sin², no cancellation
  const SO3<T> R{
      {T(1) - k * n.x * n.x, -k * n.x * n.y, -n.x}, {-k * n.x * n.y, T(1) - k * n.y * n.y, -n.y}, n};
  const SO3<T> half_turn{{T(1), T(0), T(0)}, {T(0), T(-1), T(0)}, {T(0), T(0), T(-1)}};
  return select(s > T(0) || n.z > T(0), R, half_turn);
}

}  // namespace axode
