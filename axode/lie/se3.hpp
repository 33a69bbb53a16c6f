#pragma once
#include "axode/lie/quaternion.hpp"
#include "axode/lie/screw_operation_scope.hpp"
#include "axode/lie/so3.hpp"

namespace axode {

/// A pose C = (R, r) of a frame relative to a reference frame, r in m: a point with the coordinates p in the
/// posed frame has the coordinates R p + r in the reference frame.
template <class T = double> struct SE3 {
  SO3<T> R;
  Vec3<T> r;
};

/// The composition A B: the pose of a frame that has the pose B relative to a frame with the pose A.
template <class T> constexpr SE3<T> operator*(const SE3<T>& A, const SE3<T>& B) {
  return {A.R * B.R, A.r + A.R * B.r};
}
/// Coordinates in the reference frame of the point with coordinates p in the posed frame.
template <class T> constexpr Vec3<T> operator*(const SE3<T>& C, const Vec3<T>& p) { return C.r + C.R * p; }
/// C⁻¹, the pose of the reference frame relative to the posed frame.
template <class T> constexpr SE3<T> inverse(const SE3<T>& C) {
  const SO3<T> Rt = transpose(C.R);
  return {Rt, -(Rt * C.r)};
}

/// Screw coordinates X = (w; v), angular before linear, such as joint screws and arguments of exp. The
/// velocity of a body is a Twist.
template <class T = double> struct Screw { Vec3<T> w, v; };

template <class T> constexpr Screw<T> operator+(const Screw<T>& a, const Screw<T>& b) {
  return {a.w + b.w, a.v + b.v};
}
template <class T> constexpr Screw<T> operator-(const Screw<T>& a, const Screw<T>& b) {
  return {a.w - b.w, a.v - b.v};
}
template <class T> constexpr Screw<T> operator-(const Screw<T>& a) { return {-a.w, -a.v}; }
template <class T> constexpr Screw<T> operator*(const T& s, const Screw<T>& a) { return {s * a.w, s * a.v}; }

/// Ad_C X, the frame transformation of screws (Müller, eq. Ad).
template <class T> constexpr Screw<T> Ad(const SE3<T>& C, const Screw<T>& X) {
  const ScrewOperationScope<T> scope(ScrewOperation::transformation);
  const Vec3<T> w = C.R * X.w;
  return {w, C.R * X.v + cross(C.r, w)};
}
/// Ad_C⁻¹ X, the inverse frame transformation of screws.
template <class T> constexpr Screw<T> Ad_inv(const SE3<T>& C, const Screw<T>& X) {
  const ScrewOperationScope<T> scope(ScrewOperation::transformation);
  const SO3<T> Rt = transpose(C.R);
  return {Rt * X.w, Rt * (X.v - cross(C.r, X.w))};
}
/// Ad_R X, the rotational part of Ad (Müller, eq. AdRr).
template <class T> constexpr Screw<T> Ad(const SO3<T>& R, const Screw<T>& X) {
  const ScrewOperationScope<T> scope(ScrewOperation::rotation);
  return {R * X.w, R * X.v};
}
/// Ad_r X, the translational part of Ad (Müller, eq. AdRr).
template <class T> constexpr Screw<T> Ad(const Vec3<T>& r, const Screw<T>& X) {
  const ScrewOperationScope<T> scope(ScrewOperation::translation);
  return {X.w, X.v + cross(r, X.w)};
}
/// ad_X Z = [X, Z], the Lie bracket or screw product (Müller, eqs. ScrewProd, adse3).
template <class T> constexpr Screw<T> ad(const Screw<T>& X, const Screw<T>& Z) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {cross(X.w, Z.w), cross(X.v, Z.w) + cross(X.w, Z.v)};
}
/// X ⊙ Z, the reciprocal product of two screws.
template <class T> constexpr T reciprocal_product(const Screw<T>& X, const Screw<T>& Z) {
  return dot(X.w, Z.v) + dot(X.v, Z.w);
}

/// exp: se(3) → SE(3), the displacement of the screw motion X.
template <class T> constexpr SE3<T> exp(const Screw<T>& X) { return {exp_SO3(X.w), dexp(X.w, X.v)}; }
/// log: SE(3) → se(3), the inverse of exp with the angle in [0, π].
template <class T> constexpr Screw<T> log(const SE3<T>& C) {
  const Vec3<T> w = log_SO3(C.R);
  return {w, dexp_inv(w, C.r)};
}

/// Computes P_X Z for an operator P_X on se(3) that is made from an operator P_ξ = I + β ξ̃ + γ ξ̃² on so(3),
/// where β and γ are functions of ‖ξ‖². With the angular part ξ of the screw X, the two diagonal 3×3 blocks
/// of P_X are P_ξ. Its lower left block is the derivative of P_ξ along the linear part of X, and its upper
/// right block is 0.
template <class T> constexpr Screw<T> apply(const ScrewOperator<T>& P, const Screw<T>& X, const Screw<T>& Z) {
  return {apply(P, X.w, Z.w), apply(P, X.w, Z.v) + apply(P, X.w, X.v, Z.w)};
}
/// Computes D_U P_X Z, the derivative of P_X Z when the screw X moves along U. The operator P_X on se(3) is
/// made from an operator P_ξ = I + β ξ̃ + γ ξ̃² on so(3), where β and γ are functions of ‖ξ‖². With the
/// angular part ξ of X, the two diagonal 3×3 blocks of P_X are P_ξ. Its lower left block is the derivative of
/// P_ξ along the linear part of X, and its upper right block is 0.
template <class T>
constexpr Screw<T> apply(const ScrewOperator<T>& P, const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  return {apply(P, X.w, U.w, Z.w),
          apply(P, X.w, U.w, Z.v) + apply(P, X.w, U.v, Z.w) + apply(P, X.w, X.v, U.w, Z.w)};
}
/// dexp_X Z: the right-trivialised differential, (d/dt exp X) exp(-X) = dexp_X X' (Müller, eq. Vdexp).
template <class T> constexpr Screw<T> dexp(const Screw<T>& X, const Screw<T>& Z) {
  return apply(dexp_operator(dot(X.w, X.w)), X, Z);
}
/// dexp_X⁻¹ Z. The map is singular at the angles 2π, 4π, ...
template <class T> constexpr Screw<T> dexp_inv(const Screw<T>& X, const Screw<T>& Z) {
  return apply(dexp_inv_operator(dot(X.w, X.w)), X, Z);
}
/// The derivative of dexp_X Z when X moves along U.
template <class T> constexpr Screw<T> ddexp(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  return apply(dexp_operator(dot(X.w, X.w)), X, U, Z);
}
/// The derivative of dexp_X⁻¹ Z when X moves along U.
template <class T> constexpr Screw<T> ddexp_inv(const Screw<T>& X, const Screw<T>& U, const Screw<T>& Z) {
  return apply(dexp_inv_operator(dot(X.w, X.w)), X, U, Z);
}

}  // namespace axode
