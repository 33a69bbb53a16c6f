#pragma once
#include "axode/lie/so3.hpp"

namespace axode {

/// A unit quaternion. The order is x y z w everywhere (vector part first); q and -q are the same rotation.
template <class T = double> struct Quaternion { T x{0}, y{0}, z{0}, w{1}; };

/// The quaternion of the product of two rotations: first b, then a.
template <class T> constexpr Quaternion<T> operator*(const Quaternion<T>& a, const Quaternion<T>& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
/// The inverse rotation of a unit quaternion.
template <class T> constexpr Quaternion<T> conjugate(const Quaternion<T>& a) {
  return {-a.x, -a.y, -a.z, a.w};
}
template <class T> constexpr T norm(const Quaternion<T>& a) {
  return sqrt(a.x * a.x + a.y * a.y + a.z * a.z + a.w * a.w);
}
template <class T>
constexpr Quaternion<T> select(bool condition, const Quaternion<T>& a, const Quaternion<T>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z),
          select(condition, a.w, b.w)};
}

/// The rotation matrix of a unit quaternion. The quaternion is not normalised before.
template <class T> constexpr SO3<T> rotation(const Quaternion<T>& a) {
  const T x2 = a.x + a.x, y2 = a.y + a.y, z2 = a.z + a.z;
  const T xx = a.x * x2, yy = a.y * y2, zz = a.z * z2, xy = a.x * y2, xz = a.x * z2, yz = a.y * z2;
  const T wx = a.w * x2, wy = a.w * y2, wz = a.w * z2;
  return {{T(1) - yy - zz, xy + wz, xz - wy},
          {xy - wz, T(1) - xx - zz, yz + wx},
          {xz + wy, yz - wx, T(1) - xx - yy}};
}

/// The unit quaternion with w >= 0 of a rotation matrix, computed from its largest component (Shepperd 1978).
template <class T> constexpr Quaternion<T> quaternion(const SO3<T>& R) {
  const T xx = R.x.x, yy = R.y.y, zz = R.z.z;
  const T wx = R.y.z - R.z.y, wy = R.z.x - R.x.z, wz = R.x.y - R.y.x;  // 4wx, 4wy, 4wz
  const T xy = R.x.y + R.y.x, xz = R.x.z + R.z.x, yz = R.y.z + R.z.y;  // 4xy, 4xz, 4yz
  const T W = T(1) + xx + yy + zz, X = T(1) + xx - yy - zz, Y = T(1) - xx + yy - zz, Z = T(1) - xx - yy + zz;
  const bool w_or_x = W + X > Y + Z, w = W > X, y = Y > Z;
  const Quaternion<T> q =
      select(w_or_x, select(w, Quaternion<T>{wx, wy, wz, W}, Quaternion<T>{X, xy, xz, wx}),
             select(y, Quaternion<T>{xy, Y, yz, wy}, Quaternion<T>{xz, yz, Z, wz}));
  const T scale = T(1) / norm(q), k = select(q.w < T(0), -scale, scale);
  return {k * q.x, k * q.y, k * q.z, k * q.w};
}

/// exp: so(3) → unit quaternions; ξ is the rotation vector in rad.
template <class T> constexpr Quaternion<T> exp_quaternion(const Vec3<T>& xi) {
  const T s = T(0.25) * dot(xi, xi);  // square of half the angle
  const ExponentialCoefficients<T> half(s);
  const T k = T(0.5) * half.a()[0];
  return {k * xi.x, k * xi.y, k * xi.z, T(1) - s * half.b()[0]};
}

/// The logarithm of a unit quaternion: the rotation vector (rad), whose length is the angle, from 0 to π. The
/// axis is accurate also at the angle π, where both of its directions are right.
template <class T> constexpr Vec3<T> log_quaternion(const Quaternion<T>& a) {
  const T sign = select(a.w < T(0), T(-1), T(1)), w = sign * a.w;
  const Vec3<T> v{sign * a.x, sign * a.y, sign * a.z};
  const T ss = dot(v, v), r = norm(a), y = ss / (T(2) * r * (r + w));  // sin² of a quarter of the angle
  const auto near = y < T(0.0125);
  const T n = sqrt(select(near, T(1), ss));
  return (T(2) * select(near, series::sum(series::half_angle_over_sine, y) / r, atan2(n, w) / n)) * v;
}

/// log: SO(3) → so(3), the inverse of exp_SO3 with the angle in [0, π].
template <class T> constexpr Vec3<T> log_SO3(const SO3<T>& R) { return log_quaternion(quaternion(R)); }

}  // namespace axode
