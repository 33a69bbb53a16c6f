#pragma once
#include "axode/lie/packed.hpp"
#include "axode/recursion/articulated_inertia.hpp"

/// Articulated inertias stored in registers of four lanes: symmetric matrices [[A, B], [Bᵀ, L]] in inertial
/// axes about the origin of a body. The steps of the articulated-body algorithm are written for them and for
/// ArticulatedInertia.
namespace axode {

/// An articulated inertia [[A, B], [Bᵀ, L]] with all four blocks, stored by their columns.
template <class T> struct PackedArticulatedInertia {
  using Vector = packed::Vector<T>;
  using Spread = packed::Spread<T>;
  packed::Matrix<T> A, B, Bt, L;
};

namespace packed {

/// Subtracts a bᵀ from A.
template <class T> void subtract_product(Matrix<T>& A, const Vector<T>& a, const Spread<T>& b) {
  A.x = Vector<T>(A.x.x - a.x * b.x.x);
  A.y = Vector<T>(A.y.x - a.x * b.y.x);
  A.z = Vector<T>(A.z.x - a.x * b.z.x);
}
/// The matrix A - B r~.
template <class T> Matrix<T> minus_product(const Matrix<T>& A, const Matrix<T>& B, const Spread<T>& r) {
  return {Vector<T>(A.x.x - B.y.x * r.z.x + B.z.x * r.y.x), Vector<T>(A.y.x + B.x.x * r.z.x - B.z.x * r.x.x),
          Vector<T>(A.z.x - B.x.x * r.y.x + B.y.x * r.x.x)};
}
/// The matrix A + r~ B.
template <class T> Matrix<T> plus_product(const Matrix<T>& A, const Factor<T>& r, const Matrix<T>& B) {
  return {A.x + cross(r, Factor<T>(B.x)), A.y + cross(r, Factor<T>(B.y)), A.z + cross(r, Factor<T>(B.z))};
}
template <class T> Matrix<T> operator+(const Matrix<T>& A, const Matrix<T>& B) {
  return {A.x + B.x, A.y + B.y, A.z + B.z};
}
/// The rotated matrix R A Rᵀ.
template <class T> Matrix<T> rotate(const Matrix<T>& R, const Sym3<T>& A) {
  const Matrix<T> P{R * Spread<T>(Vec3<T>{A.xx, A.xy, A.xz}), R * Spread<T>(Vec3<T>{A.xy, A.yy, A.yz}),
                    R * Spread<T>(Vec3<T>{A.xz, A.yz, A.zz})};
  const Spread<T> x(R.x), y(R.y), z(R.z);
  return {Vector<T>(P.x.x * x.x.x + P.y.x * y.x.x + P.z.x * z.x.x),
          Vector<T>(P.x.x * x.y.x + P.y.x * y.y.x + P.z.x * z.y.x),
          Vector<T>(P.x.x * x.z.x + P.y.x * y.z.x + P.z.x * z.z.x)};
}

}  // namespace packed

/// The inertia matrix of a rigid body with rotational inertia Theta, first moment h and mass m.
template <class T>
PackedArticulatedInertia<T> articulated(const packed::Matrix<T>& Theta, const packed::Vector<T>& h, T m) {
  using V = packed::Vector<T>;
  const V x(packed::permute<3, 2, 1, 3>(h).x * V(T(0), T(1), T(-1)).x),
      y(packed::permute<2, 3, 0, 3>(h).x * V(T(-1), T(0), T(1)).x),
      z(packed::permute<1, 0, 3, 3>(h).x * V(T(1), T(-1), T(0)).x);
  return {Theta,
          {x, y, z},
          {-x, -y, -z},
          {m * V(T(1), T(0), T(0)), m * V(T(0), T(1), T(0)), m * V(T(0), T(0), T(1))}};
}
template <class T>
ArticulatedInertia<Hybrid, T> articulated(const Sym3<T>& Theta, const Vec3<T>& h, const T& m) {
  return {Theta, skew_matrix(h), identity_tensor(m)};
}

/// The product M (n; 0) for the unit vector n, as a pair (moment, force).
template <class T> auto about_axis(const PackedArticulatedInertia<T>& M, const packed::Vector<T>& n) {
  const packed::Spread<T> s(n);
  return std::pair(M.A * s, M.Bt * s);
}
template <class T> auto about_axis(const ArticulatedInertia<Hybrid, T>& M, const Vec3<T>& n) {
  return std::pair(M.A * n, transposed_times(M.B, n));
}
/// The product M (w; v) of an articulated inertia and a twist, as a pair (moment, force).
template <class T>
auto along_twist(const PackedArticulatedInertia<T>& M, const packed::Vector<T>& w,
                 const packed::Vector<T>& v) {
  const packed::Spread<T> a(w), b(v);
  return std::pair(M.A * a + M.B * b, M.Bt * a + M.L * b);
}
template <class T>
auto along_twist(const ArticulatedInertia<Hybrid, T>& M, const Vec3<T>& w, const Vec3<T>& v) {
  return std::pair(M.A * w + M.B * v, transposed_times(M.B, w) + M.L * v);
}

/// Eliminates a joint screw S with U = M S and the pivot D: subtracts K Uᵀ with K = U / D from M.
template <class T>
[[gnu::always_inline]] inline void eliminate(PackedArticulatedInertia<T>& M, const packed::Vector<T>& U_m,
                                             const packed::Vector<T>& U_f, const packed::Vector<T>& K_m,
                                             const packed::Vector<T>& K_f) {
  const packed::Spread<T> s_m(U_m), s_f(U_f);
  subtract_product(M.A, K_m, s_m);
  subtract_product(M.B, K_m, s_f);
  subtract_product(M.Bt, K_f, s_m);
  subtract_product(M.L, K_f, s_f);
}
template <class T>
[[gnu::always_inline]] inline void eliminate(ArticulatedInertia<Hybrid, T>& M, const Vec3<T>& U_m,
                                             const Vec3<T>& U_f, const Vec3<T>& K_m, const Vec3<T>& K_f) {
  M.A = {M.A.xx - K_m.x * U_m.x, M.A.yy - K_m.y * U_m.y, M.A.zz - K_m.z * U_m.z,
         M.A.xy - K_m.x * U_m.y, M.A.xz - K_m.x * U_m.z, M.A.yz - K_m.y * U_m.z};
  M.B = {M.B.x - U_f.x * K_m, M.B.y - U_f.y * K_m, M.B.z - U_f.z * K_m};
  M.L = {M.L.xx - K_f.x * U_f.x, M.L.yy - K_f.y * U_f.y, M.L.zz - K_f.z * U_f.z,
         M.L.xy - K_f.x * U_f.y, M.L.xz - K_f.x * U_f.z, M.L.yz - K_f.y * U_f.z};
}

/// Replaces the articulated inertia M by that about another point, in the same axes. r is the vector from
/// that point to the point about which M is given.
template <class T>
[[gnu::always_inline]] inline void shift(PackedArticulatedInertia<T>& M, const packed::Vector<T>& r) {
  const packed::Spread<T> s(r);
  const packed::Factor<T> r_(r);
  const auto Bt = minus_product(M.Bt, M.L, s);
  M = {plus_product(minus_product(M.A, M.B, s), r_, Bt), plus_product(M.B, r_, M.L), Bt, M.L};
}
// Numbers may be registers with a state in each lane. They are assigned one by one, because GCC copies
// structures of many registers by calls of memcpy().
template <class T>
[[gnu::always_inline]] inline void shift(ArticulatedInertia<Hybrid, T>& M, const Vec3<T>& r) {
  const Mat3<T>&B = M.B, G = B + cross(r, matrix(M.L));  // A + r~ Gᵀ + (r~ Bᵀ)ᵀ by its entries
  M.A.xx = M.A.xx + (r.y * (G.z.x + B.z.x) - r.z * (G.y.x + B.y.x));
  M.A.yy = M.A.yy + (r.z * (G.x.y + B.x.y) - r.x * (G.z.y + B.z.y));
  M.A.zz = M.A.zz + (r.x * (G.y.z + B.y.z) - r.y * (G.x.z + B.x.z));
  M.A.xy = M.A.xy + (r.y * G.z.y - r.z * G.y.y + r.z * B.x.x - r.x * B.z.x);
  M.A.xz = M.A.xz + (r.y * G.z.z - r.z * G.y.z + r.x * B.y.x - r.y * B.x.x);
  M.A.yz = M.A.yz + (r.z * G.x.z - r.x * G.z.z + r.x * B.y.y - r.y * B.x.y);
  M.B.x = G.x;
  M.B.y = G.y;
  M.B.z = G.z;
}

template <class T>
PackedArticulatedInertia<T>& operator+=(PackedArticulatedInertia<T>& a,
                                        const PackedArticulatedInertia<T>& b) {
  return a = {a.A + b.A, a.B + b.B, a.Bt + b.Bt, a.L + b.L};
}

}  // namespace axode
