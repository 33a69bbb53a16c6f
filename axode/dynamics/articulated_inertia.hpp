#pragma once
#include "axode/dynamics/composite_inertia.hpp"
#include "axode/lie/mat3.hpp"

namespace axode {

/// A symmetric matrix [[A, B], [Bᵀ, L]] from twists to wrenches in Rep: the inertia that a body shows when
/// the joints behind it are free to give way.
template <class Rep, class T> struct ArticulatedInertia {
  Sym3<T> A;
  Mat3<T> B;
  Sym3<T> L;
};

template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T>& operator+=(ArticulatedInertia<Rep, T>& a,
                                                 const ArticulatedInertia<Rep, T>& b) {
  return a = {a.A + b.A, a.B + b.B, a.L + b.L};
}
template <class Rep, class T>
constexpr Wrench<Rep, T> operator*(const ArticulatedInertia<Rep, T>& M, const Twist<Rep, T>& V) {
  return {M.A * V.w + M.B * V.v, transposed_times(M.B, V.w) + M.L * V.v};
}
/// M - U Uᵀ / D: what remains of M when the direction of U = M S, D = Sᵀ U gives way.
template <class Rep, class T>
constexpr void give_way(ArticulatedInertia<Rep, T>& M, const Wrench<Rep, T>& U, const T& D) {
  const T d = T(-1) / D;
  M.A = M.A + d * square(U.m);
  M.B = M.B + d * outer_product(U.m, U.f);
  M.L = M.L + d * square(U.f);
}

/// The matrix of a rigid body's inertia(link, M).
template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T> articulated(const Link<Rep, T>& link, const Inertia<T>& M) {
  const Mat3<T> h = skew_matrix(M.h);
  if constexpr (std::same_as<Rep, Mixed>)
    return {M.Theta, h * transpose(link.R), identity_tensor(M.m)};
  else
    return {M.Theta, h, identity_tensor(M.m)};
}

/// The congruence with Ad_r: M about a point from which its own is at r, in the same axes.
template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T> transform(const Vec3<T>& r, const ArticulatedInertia<Rep, T>& M) {
  const Noted<T> noted(ScrewOperation::tensor_translation);
  const Mat3<T> B = M.B + cross(r, matrix(M.L));
  const Mat3<T> Br = cross(r, transpose(B));  // -B r̃, transposed
  const Mat3<T> rB = cross(r, transpose(M.B));
  return {M.A + T(0.5) * plus_transpose(rB + Br), B, M.L};
}

/// downᵀ M down: an articulated inertia as one of the predecessor.
template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T> up(const Link<Rep, T>& link, const ArticulatedInertia<Rep, T>& M) {
  if constexpr (std::same_as<Rep, Spatial>) {
    return M;
  } else if constexpr (std::same_as<Rep, Hybrid>) {
    return transform(link.r_pi, M);
  } else if constexpr (std::same_as<Rep, BodyFixed>) {
    const Noted<T> noted(ScrewOperation::tensor_transformation);
    const SO3<T>&R = link.C_pi.R, Rt = transpose(R);
    return transform(link.C_pi.r, ArticulatedInertia<Rep, T>{rotate(R, M.A), (R * M.B) * Rt, rotate(R, M.L)});
  } else {  // by way of the predecessor's axes
    const Noted<T> noted(ScrewOperation::tensor_transformation);
    const SO3<T> R_p = link.R_p, Rt_p = transpose(R_p);
    const ArticulatedInertia<Rep, T> M_p = transform(
        link.C_pi.r,
        ArticulatedInertia<Rep, T>{rotate(link.C_pi.R, M.A), (link.C_pi.R * M.B) * R_p, rotate(Rt_p, M.L)});
    return {M_p.A, M_p.B * Rt_p, M.L};
  }
}

}  // namespace axode
