#pragma once
#include "axode/lie/scalar.hpp"

namespace axode {

/// Three coordinates of a vector, resolved in a frame that the context names.
template <class T = double> struct Vec3 { T x{}, y{}, z{}; };

template <class T> constexpr Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T> constexpr Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T> constexpr Vec3<T> operator-(const Vec3<T>& a) { return {-a.x, -a.y, -a.z}; }
template <class T> constexpr Vec3<T> operator*(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T> constexpr Vec3<T>& operator+=(Vec3<T>& a, const Vec3<T>& b) { return a = a + b; }
template <class T> constexpr Vec3<T>& operator-=(Vec3<T>& a, const Vec3<T>& b) { return a = a - b; }

template <class T> constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// a × b, the paper's ã b.
template <class T> constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T> constexpr T norm(const Vec3<T>& a) { return sqrt(dot(a, a)); }

template <class T> constexpr Vec3<T> select(bool condition, const Vec3<T>& a, const Vec3<T>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

/// A symmetric 3×3 tensor, e.g. the rotational inertia Θ. xy is the entry (1,2) of the matrix, sign included.
template <class T = double> struct Sym3 { T xx{}, yy{}, zz{}, xy{}, xz{}, yz{}; };

template <class T> constexpr Sym3<T> operator+(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}
template <class T> constexpr Sym3<T> operator-(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
}
template <class T> constexpr Sym3<T> operator*(const T& s, const Sym3<T>& a) {
  return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz};
}
template <class T> constexpr Vec3<T> operator*(const Sym3<T>& A, const Vec3<T>& a) {
  return {A.xx * a.x + A.xy * a.y + A.xz * a.z, A.xy * a.x + A.yy * a.y + A.yz * a.z,
          A.xz * a.x + A.yz * a.y + A.zz * a.z};
}
template <class T> constexpr T trace(const Sym3<T>& A) { return A.xx + A.yy + A.zz; }
template <class T> constexpr Sym3<T> identity_tensor(const T& s) { return {s, s, s, T(0), T(0), T(0)}; }
/// The symmetric tensor a bᵀ + b aᵀ.
template <class T> constexpr Sym3<T> symmetric_product(const Vec3<T>& a, const Vec3<T>& b) {
  return {T(2) * a.x * b.x,      T(2) * a.y * b.y,      T(2) * a.z * b.z,
          a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y};
}
/// -ã b̃ - b̃ ã = 2 (a·b) I - a bᵀ - b aᵀ, the symmetric tensor of the parallel-axis theorem.
template <class T> constexpr Sym3<T> parallel_axis_tensor(const Vec3<T>& a, const Vec3<T>& b) {
  return identity_tensor(T(2) * dot(a, b)) - symmetric_product(a, b);
}

}  // namespace axode
