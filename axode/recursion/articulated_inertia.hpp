#pragma once
#include "axode/lie/inertia.hpp"
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

/// How large the numbers of an inertia are, in every direction.
template <class Rep, class T> constexpr ArticulatedInertia<Rep, T> size_of(const Inertia<T>& M) {
  const T t = trace(M.Theta), o(0);
  return {{t, t, t, o, o, o}, {}, {M.m, M.m, M.m, o, o, o}};
}
/// The sizes F where S has given way: the congruence with V -> V - (Uᵀ V / D) S, where G = F S and the motion along S has
/// the size f = Sᵀ G, or more for what moves along with it beside this body; and the size of what is subtracted from M.
template <class Rep, class T>
constexpr void follow(ArticulatedInertia<Rep, T>& F, const Wrench<Rep, T>& G, const T& f,
                      const Wrench<Rep, T>& U, const T& D) {
  const T d = T(1) / D, a = d * dot(U.m, U.m), l = d * dot(U.f, U.f), o(0);
  const Wrench<Rep, T> Y = d * ((T(0.5) * f * d) * U - G);
  F.A = F.A + plus_transpose(outer_product(Y.m, U.m)) + Sym3<T>{a, a, a, o, o, o};
  F.B = F.B + outer_product(Y.m, U.f) + outer_product(U.m, Y.f);
  F.L = F.L + plus_transpose(outer_product(Y.f, U.f)) + Sym3<T>{l, l, l, o, o, o};
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

}  // namespace axode
