#pragma once
#include "axode/lie/twist.hpp"

namespace axode {

/// The inertia of a rigid body in a frame: mass m (kg), first moment h = m c (kg m) with the centre of mass
/// c, and rotational inertia Θ (kg m²) about the origin, all in the axes of the frame. As a matrix it is M =
/// [[Θ, h̃], [-h̃, m I]] (Müller, eq. Mb).
template <class T = double> struct Inertia {
  T m{};
  Vec3<T> h;
  Sym3<T> Theta;
};

template <class T> constexpr Inertia<T> operator+(const Inertia<T>& a, const Inertia<T>& b) {
  return {a.m + b.m, a.h + b.h, a.Theta + b.Theta};
}
template <class T> constexpr Inertia<T>& operator+=(Inertia<T>& a, const Inertia<T>& b) { return a = a + b; }

/// Inertia in a body frame from the mass, the centre of mass c, and the rotational inertia about it, given in
/// axes rotated by R_bc relative to the body frame: the parallel-axis theorem (Müller, eqs. Mbc, Mb).
template <class T>
constexpr Inertia<T> inertia_from_com(const T& m, const Vec3<T>& c, const Sym3<T>& Theta_c,
                                      const SO3<T>& R_bc = {}) {
  return {m, m * c, rotate(R_bc, Theta_c) + (T(0.5) * m) * parallel_axis_tensor(c, c)};
}
/// The rotational inertia about the centre of mass, in the axes of the frame of M. The mass must not be 0.
template <class T> constexpr Sym3<T> inertia_about_com(const Inertia<T>& M) {
  return M.Theta - (T(0.5) / M.m) * parallel_axis_tensor(M.h, M.h);
}
/// The centre of mass in the frame of M. The mass must not be 0.
template <class T> constexpr Vec3<T> center_of_mass(const Inertia<T>& M) { return (T(1) / M.m) * M.h; }

/// Ad_R⁻ᵀ M Ad_R⁻¹: the inertia in rotated axes about the same point (Müller, eq. aWhRec).
template <class T> constexpr Inertia<T> transform(const SO3<T>& R, const Inertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_rotation);
  return {M.m, R * M.h, rotate(R, M.Theta)};
}
/// The inertia Ad_r⁻ᵀ M Ad_r⁻¹ about another point, in the same axes, where r is the vector from that point
/// to the origin of the frame of M.
template <class T> constexpr Inertia<T> transform(const Vec3<T>& r, const Inertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_translation);
  return {M.m, M.h + M.m * r, M.Theta + parallel_axis_tensor(M.h + (T(0.5) * M.m) * r, r)};
}
/// The inertia Ad_S⁻ᵀ M Ad_S⁻¹ in another frame, where S is the pose of the frame of M relative to that other
/// frame (Müller, eqs. Ms, Mb).
template <class T> constexpr Inertia<T> transform(const SE3<T>& S, const Inertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_transformation);
  return transform(S.r, transform(S.R, M));
}

/// The inertia in a frame whose origin is the centre of mass, M = diag(Θ, m I) (Müller, eq. Mbc).
template <class T = double> struct CentralInertia {
  T m{};
  Sym3<T> Theta;
  constexpr operator Inertia<T>() const {  // NOLINT(google-explicit-constructor): it is an inertia
    return {m, {}, Theta};
  }
};
/// Ad_R⁻ᵀ M Ad_R⁻¹ of a central inertia: the origin stays at the centre of mass.
template <class T> constexpr CentralInertia<T> transform(const SO3<T>& R, const CentralInertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_rotation);
  return {M.m, rotate(R, M.Theta)};
}
/// The inertia Ad_r⁻ᵀ M Ad_r⁻¹ about any point, in the same axes, from the inertia M about the centre of
/// mass. r is the vector from that point to the centre of mass.
template <class T> constexpr Inertia<T> transform(const Vec3<T>& r, const CentralInertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_translation);
  return {M.m, M.m * r, M.Theta + parallel_axis_tensor((T(0.5) * M.m) * r, r)};
}
/// The inertia Ad_S⁻ᵀ M Ad_S⁻¹ in any frame, from the inertia M about the centre of mass. S is the pose of
/// the frame of M, whose origin is the centre of mass, relative to that frame.
template <class T> constexpr Inertia<T> transform(const SE3<T>& S, const CentralInertia<T>& M) {
  const ScrewOperationScope<T> scope(ScrewOperation::tensor_transformation);
  return transform(S.r, transform(S.R, M));
}

/// The momentum Π = M V, in all representations of the twist V except the mixed one.
template <class Rep, class T>
constexpr Momentum<Rep, T> operator*(const Inertia<T>& M, const Twist<Rep, T>& V) {
  static_assert(!std::same_as<Rep, Mixed>, "the mixed inertia matrix has blocks in different axes");
  return {M.Theta * V.w + cross(M.h, V.v), M.m * V.v - cross(M.h, V.w)};
}
/// The wrench M V', the part of the Newton-Euler equations that is linear in the acceleration.
template <class Rep, class T>
constexpr Wrench<Rep, T> operator*(const Inertia<T>& M, const TwistRate<Rep, T>& dV) {
  static_assert(!std::same_as<Rep, Mixed>, "the mixed inertia matrix has blocks in different axes");
  return {M.Theta * dV.w + cross(M.h, dV.v), M.m * dV.v - cross(M.h, dV.w)};
}

/// M' = -ad_Vᵀ M - M ad_V, the rate of an inertia that moves with the twist V (Müller, eq. Msdot); its mass
/// is 0.
template <AtFrameOrigin Rep, class T>
constexpr Inertia<T> inertia_rate(const Twist<Rep, T>& V, const Inertia<T>& M) {
  const Sym3<T>& A = M.Theta;
  const Vec3<T> x = cross(V.w, Vec3<T>{A.xx, A.xy, A.xz}), y = cross(V.w, Vec3<T>{A.xy, A.yy, A.yz}),
                z = cross(V.w, Vec3<T>{A.xz, A.yz, A.zz});  // columns of ω̃ Θ, whose transpose is -Θ ω̃
  const Sym3<T> turned{x.x + x.x, y.y + y.y, z.z + z.z, x.y + y.x, x.z + z.x, y.z + z.y};
  return {T(0), cross(V.w, M.h) + M.m * V.v, turned + parallel_axis_tensor(M.h, V.v)};
}

/// Binet's inertia tensor ϑ = tr(Θ)/2 I - Θ, the second moments of mass.
template <class T> constexpr Sym3<T> binet_tensor(const Sym3<T>& Theta) {
  return identity_tensor(T(0.5) * trace(Theta)) - Theta;
}
/// Θ = tr(ϑ) I - ϑ, the rotational inertia whose Binet tensor is ϑ.
template <class T> constexpr Sym3<T> rotational_inertia(const Sym3<T>& binet) {
  return identity_tensor(trace(binet)) - binet;
}

/// The smallest and the largest eigenvalue of a symmetric tensor.
struct EigenvalueRange {
  double smallest, largest;
};
EigenvalueRange eigenvalue_range(const Sym3<double>& A);

/// A measure of whether a mass distribution with the inertia M exists: it exists if the result is at least 0.
/// The result is the smallest eigenvalue of Binet's tensor about the centre of mass, divided by the largest
/// principal moment about this point. A negative eigenvalue counts as 0 if it is within the rounding errors
/// of the rotational inertia about the origin of the frame, from which the tensor is computed. If all
/// principal moments are positive, the result is at least -0.5. The mass must be positive.
double realisability(const Inertia<double>& M);

}  // namespace axode
