#pragma once
#include "axode/lie/se3.hpp"

/// Cayley's map on SO(3) and SE(3), its right-trivialised differential, and the derivatives of this
/// differential (D14 of docs/derivations). The maps are rational and need no series for small angles. A
/// rotation vector w has the angle 2 atan(‖w‖/2), so that half a turn is at infinity.
///
/// There are two maps on SE(3). cay(X) is (1 - X̂/2)⁻¹ (1 + X̂/2) with the 4×4 matrix X̂. cay_of_ad(X) is the
/// pose C for which Ad_C = (1 - ad_X/2)⁻¹ (1 + ad_X/2). Both have the same rotation; their positions differ
/// if X has a linear part along its angular part.
namespace axode {

/// σ = 1/(1 + ‖w‖²/4), with which all of Cayley's maps are polynomials.
template <class T> constexpr T cayley_factor(const Vec3<T>& w) { return T(1) / (T(1) + T(0.25) * dot(w, w)); }

// -------------------------------------------------------------------------------------------- SO(3)

/// (1 - w̃/2)⁻¹ z = σ (z + w × z/2 + (w·z) w/4) with σ = 1/(1 + ‖w‖²/4) (D14.2).
template <class T> constexpr Vec3<T> cayley_solve(const Vec3<T>& w, const Vec3<T>& z) {
  return cayley_factor(w) * (z + T(0.5) * cross(w, z) + (T(0.25) * dot(w, z)) * w);
}
/// cay: so(3) → SO(3), (1 - w̃/2)⁻¹ (1 + w̃/2) = 1 + σ (w̃ + w̃²/2) with σ = 1/(1 + ‖w‖²/4) (D14.3).
template <class T> constexpr SO3<T> cay_SO3(const Vec3<T>& w) {
  const T sigma = cayley_factor(w);
  const auto column = [&](const Vec3<T>& e) {
    const Vec3<T> w_e = cross(w, e);
    return e + sigma * (w_e + T(0.5) * cross(w, w_e));
  };
  return {column({T(1), T(0), T(0)}), column({T(0), T(1), T(0)}), column({T(0), T(0), T(1)})};
}
/// cay: so(3) → unit quaternions: the quaternion of the rotation cay_SO3(w).
template <class T> constexpr Quaternion<T> cay_quaternion(const Vec3<T>& w) {
  const T half = T(0.5) / sqrt(T(1) + T(0.25) * dot(w, w));
  return {half * w.x, half * w.y, half * w.z, T(2) * half};
}
/// The w with cay_SO3(w) = R: the axis times 2 tan of half the angle; not finite for half a turn.
template <class T> constexpr Vec3<T> cay_inv_SO3(const SO3<T>& R) {
  const Quaternion<T> a = quaternion(R);
  return (T(2) / a.w) * Vec3<T>{a.x, a.y, a.z};
}
/// dcay_w z = σ (z + w × z/2) with σ = 1/(1 + ‖w‖²/4), the right-trivialised differential of cay_SO3 (D14.4):
/// R = cay w has the spatial angular velocity dcay_w w'.
template <class T> constexpr Vec3<T> dcay(const Vec3<T>& w, const Vec3<T>& z) {
  return cayley_factor(w) * (z + T(0.5) * cross(w, z));
}
/// dcay_w⁻¹ z = z - w × z/2 + (w·z) w/4.
template <class T> constexpr Vec3<T> dcay_inv(const Vec3<T>& w, const Vec3<T>& z) {
  return z - T(0.5) * cross(w, z) + (T(0.25) * dot(w, z)) * w;
}
/// The derivative of dcay_w z when w moves along u.
template <class T> constexpr Vec3<T> ddcay(const Vec3<T>& w, const Vec3<T>& u, const Vec3<T>& z) {
  const T sigma = cayley_factor(w);
  return T(0.5) * sigma * (cross(u, z) - (sigma * dot(w, u)) * (z + T(0.5) * cross(w, z)));
}
/// The derivative of dcay_w⁻¹ z when w moves along u.
template <class T> constexpr Vec3<T> ddcay_inv(const Vec3<T>& w, const Vec3<T>& u, const Vec3<T>& z) {
  return T(-0.5) * cross(u, z) + T(0.25) * (dot(u, z) * w + dot(w, z) * u);
}

// ------------------------------------------------------------------------- SE(3), of the 4×4 matrix

/// cay: se(3) → SE(3), (1 - X̂/2)⁻¹ (1 + X̂/2) (D14.3).
template <class T> constexpr SE3<T> cay(const Screw<T>& X) { return {cay_SO3(X.w), cayley_solve(X.w, X.v)}; }
/// The X with cay(X) = C. It is infinite or not a number for half a turn.
template <class T> constexpr Screw<T> cay_inv(const SE3<T>& C) {
  const Vec3<T> w = cay_inv_SO3(C.R);
  return {w, C.r - T(0.5) * cross(w, C.r)};
}
/// log(cay(X)), the exponential coordinates of the pose cay(X), by the quaternion of its rotation.
template <class T> constexpr Screw<T> log_cay(const Screw<T>& X) {
  const Vec3<T> w = log_quaternion(cay_quaternion(X.w));
  return {w, dexp_inv(w, cayley_solve(X.w, X.v))};
}
/// dcay_X Z, the right-trivialised differential (D14.5): C = cay X has the spatial twist dcay_X X' and the
/// body-fixed twist dcay_{-X} X'.
template <class T> constexpr Screw<T> dcay(const Screw<T>& X, const Screw<T>& Z) {
  const Vec3<T> omega = dcay(X.w, Z.w);
  return {omega, T(0.5) * cross(X.v, omega) + cayley_solve(X.w, Z.v)};
}
/// dcay_X⁻¹ Z, the screw of (1 - X̂/2) Ẑ (1 + X̂/2) (D14.6).
template <class T> constexpr Screw<T> dcay_inv(const Screw<T>& X, const Screw<T>& Z) {
  const T w_z = dot(X.w, Z.w);
  const Screw<T> bracket = ad(X, Z);
  return {Z.w - T(0.5) * bracket.w + (T(0.25) * w_z) * X.w,
          Z.v - T(0.5) * bracket.v + T(0.25) * (w_z * X.v - dot(X.w, X.v) * Z.w)};
}
/// The derivative of dcay_X Z when X moves along U.
template <class T> constexpr Screw<T> ddcay(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  const Vec3<T>&w = X.w, &u = U.w, &zeta = Z.v;
  const T sigma = cayley_factor(w), w_u = dot(w, u);
  const Vec3<T> omega = dcay(w, Z.w), d_omega = ddcay(w, u, Z.w);
  const Vec3<T> d_solved = T(0.5) * cross(u, zeta) + T(0.25) * (dot(u, zeta) * w + dot(w, zeta) * u) -
                           (T(0.5) * w_u) * cayley_solve(w, zeta);
  return {d_omega, T(0.5) * (cross(U.v, omega) + cross(X.v, d_omega)) + sigma * d_solved};
}
/// The derivative of dcay_X⁻¹ Z when X moves along U.
template <class T> constexpr Screw<T> ddcay_inv(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  const T w_z = dot(X.w, Z.w), u_z = dot(U.w, Z.w);
  const Screw<T> bracket = ad(U, Z);
  return {T(-0.5) * bracket.w + T(0.25) * (u_z * X.w + w_z * U.w),
          T(-0.5) * bracket.v + T(0.25) * (u_z * X.v + w_z * U.v - (dot(U.w, X.v) + dot(X.w, U.v)) * Z.w)};
}
/// dcay_Xᵀ W for coordinates W = (moment; force) of a wrench or momentum (D14.7).
template <class T> constexpr Screw<T> dcay_transpose(const Screw<T>& X, const Screw<T>& W) {
  return {dcay(-X.w, W.w - T(0.5) * cross(X.v, W.v)), cayley_solve(-X.w, W.v)};
}

// ------------------------------------------------------------------------------------- SE(3), of ad

/// The pose C with Ad_C = (1 - ad_X/2)⁻¹ (1 + ad_X/2) (D14.8). For X = (w; v) its rotation is cay_SO3(w) and
/// its position dcay_w v, like exp_SO3(w) and dexp_w v of exp(X).
template <class T> constexpr SE3<T> cay_of_ad(const Screw<T>& X) { return {cay_SO3(X.w), dcay(X.w, X.v)}; }
/// The inverse of cay_of_ad(): the X with Ad_C = (1 - ad_X/2)⁻¹ (1 + ad_X/2). It is infinite or not a number
/// for half a turn.
template <class T> constexpr Screw<T> cay_of_ad_inv(const SE3<T>& C) {
  const Vec3<T> w = cay_inv_SO3(C.R);
  return {w, dcay_inv(w, C.r)};
}
/// The right-trivialised differential at X, applied to Z, of the map cay_of_ad() from X to the pose C with
/// Ad_C = (1 - ad_X/2)⁻¹ (1 + ad_X/2). As a 6×6 matrix it has dcay of SO(3) in its diagonal blocks; its lower
/// left block is the derivative of dcay along the linear part of X.
template <class T> constexpr Screw<T> dcay_of_ad(const Screw<T>& X, const Screw<T>& Z) {
  return {dcay(X.w, Z.w), dcay(X.w, Z.v) + ddcay(X.w, X.v, Z.w)};
}
/// The inverse of dcay_of_ad at X, applied to Z: the Y with ad_Y = (1 - ad_X/2) ad_Z (1 + ad_X/2).
template <class T> constexpr Screw<T> dcay_inv_of_ad(const Screw<T>& X, const Screw<T>& Z) {
  return {dcay_inv(X.w, Z.w), dcay_inv(X.w, Z.v) + ddcay_inv(X.w, X.v, Z.w)};
}
/// The derivative of dcay_of_ad(X, Z) when X moves along U.
template <class T> constexpr Screw<T> ddcay_of_ad(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  const Vec3<T>&w = X.w, &v = X.v, &u = U.w, &z = Z.w;
  const T sigma = cayley_factor(w), w_u = dot(w, u), w_v = dot(w, v);
  const T both = dot(u, v) - sigma * w_u * w_v;
  const Vec3<T> coupled = w_u * cross(v, z) + w_v * cross(u, z) + both * (T(2) * z + cross(w, z));
  // The last term is the second derivative of dcay_w z, along u and v.
  return {ddcay(w, u, z), ddcay(w, u, Z.v) + ddcay(w, U.v, z) - (T(0.25) * sigma * sigma) * coupled};
}
/// The derivative of dcay_inv_of_ad(X, Z) when X moves along U.
template <class T>
constexpr Screw<T> ddcay_inv_of_ad(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  const Vec3<T> second = T(0.25) * (dot(U.w, Z.w) * X.v + dot(X.v, Z.w) * U.w);  // along u and v
  return {ddcay_inv(X.w, U.w, Z.w), ddcay_inv(X.w, U.w, Z.v) + ddcay_inv(X.w, U.v, Z.w) + second};
}

}  // namespace axode
