#pragma once
#include "axode/lie/inertia.hpp"
#include "axode/lie/mat3.hpp"

namespace axode {

/// The articulated inertia of a body, which is its inertia if the joints of its subtree are free to move: a
/// symmetric matrix [[A, B], [Bᵀ, L]] from twists to wrenches in representation Rep.
template <class Rep, class T> struct ArticulatedInertia {
  Sym3<T> A;
  Mat3<T> B;
  Sym3<T> L;
};

template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T>& operator+=(ArticulatedInertia<Rep, T>& a,
                                                 const ArticulatedInertia<Rep, T>& b) {
  a.A = a.A + b.A;
  a.B = a.B + b.B;
  a.L = a.L + b.L;
  return a;
}
template <class Rep, class T>
constexpr Wrench<Rep, T> operator*(const ArticulatedInertia<Rep, T>& M, const Twist<Rep, T>& V) {
  return {M.A * V.w + M.B * V.v, transposed_times(M.B, V.w) + M.L * V.v};
}
/// Replaces M by M - U Uᵀ / D, the articulated inertia after the elimination of a joint screw S with U = M S
/// and the pivot D. See (D4.5) of docs/derivations.
template <class Rep, class T>
constexpr void eliminate(ArticulatedInertia<Rep, T>& M, const Wrench<Rep, T>& U, const T& D) {
  const T d = T(-1) / D;
  M.A = M.A + d * square(U.m);
  M.B = M.B + d * outer_product(U.m, U.f);
  M.L = M.L + d * square(U.f);
}

/// An estimate of the entries of a rigid inertia M, against which rounding errors are compared: tr Θ for
/// rotations and the mass m for translations, the same in every direction.
template <class Rep, class T> constexpr ArticulatedInertia<Rep, T> size_of(const Inertia<T>& M) {
  const T t = trace(M.Theta), o(0);
  return {{t, t, t, o, o, o}, {}, {M.m, M.m, M.m, o, o, o}};
}
/// Updates F for the elimination of a joint screw S from the articulated inertia M, with the pivot D and the
/// wrench U = M S, whose moment is U_m and whose force is U_f. F is a symmetric matrix against which rounding
/// errors of M are compared: Sᵀ F S is the magnitude of the numbers that are added and subtracted to compute
/// Sᵀ M S. G is F S. The number f is Sᵀ G plus the magnitude of inertias that move with S but are not part of
/// M, such as the armature. By (D4.9) of docs/derivations, with the 3×3 identity 1,
///   F ← F + Y Uᵀ + U Yᵀ + diag(|U_m|² 1, |U_f|² 1) / D  with  Y = (f U / (2 D) - G) / D.
template <class Rep, class T>
constexpr void update_scale(ArticulatedInertia<Rep, T>& F, const Wrench<Rep, T>& G, const T& f,
                            const Wrench<Rep, T>& U, const T& D) {
  const T d = T(1) / D, a = d * dot(U.m, U.m), l = d * dot(U.f, U.f), o(0);
  const Wrench<Rep, T> Y = d * ((T(0.5) * f * d) * U - G);
  F.A = F.A + plus_transpose(outer_product(Y.m, U.m)) + Sym3<T>{a, a, a, o, o, o};
  F.B = F.B + outer_product(Y.m, U.f) + outer_product(U.m, Y.f);
  F.L = F.L + plus_transpose(outer_product(Y.f, U.f)) + Sym3<T>{l, l, l, o, o, o};
}

/// The articulated inertia M about another point, in the same axes. r is the vector from that point to the
/// point about which M is given.
template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T> transform(const Vec3<T>& r, const ArticulatedInertia<Rep, T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_translation);
  const Mat3<T> B = M.B + cross(r, matrix(M.L));
  const Mat3<T> Br = cross(r, transpose(B));  // (-B r̃)ᵀ
  const Mat3<T> rB = cross(r, transpose(M.B));
  return {M.A + T(0.5) * plus_transpose(rB + Br), B, M.L};
}

}  // namespace axode
