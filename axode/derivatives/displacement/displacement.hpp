#pragma once
#include "axode/lie/inertia.hpp"
#include "axode/lie/mat3.hpp"

/// Derivatives of the wrenches on bodies when their subtree is displaced along a screw J, which may be a
/// joint screw or any other one. All quantities are in inertial axes about a point O, the present origin of
/// the body of the branch that is joined to the ground.
///
/// In a frame that is displaced with the subtree, a unit of displacement changes the twist V of each body of
/// the subtree by ψ' and the rate of V by ψ'' - [V, ψ']. ψ' and ψ'' are the first two time derivatives of J
/// as a screw that is fixed to the predecessor of the first body of the subtree. Hence the wrench on the body
/// changes by M ψ'' + B ψ', with its inertia M and Coriolis inertia B. For a twist X, B X = M' X - ad_Xᵀ M V
/// with the time derivative M' of M.
namespace axode {

/// A six-vector of se(3) in inertial axes about a point O, which may be a twist, the rate of a twist, a screw
/// or the rate of a screw.
template <class T> using Motion6 = Twist<Spatial, T>;

/// The first two time derivatives of a screw that coincides with J now and is fixed to a body with the twist
/// V_p, whose rate is V'_p: `first` is ψ' = [V_p, J], and `second` is ψ'' = [V'_p, J] + [V_p, ψ']. See (D1.4)
/// of docs/derivations.
template <class T> struct CarriedScrew {
  Motion6<T> first, second;

  CarriedScrew(const Motion6<T>& V_p, const Motion6<T>& dV_p, const Motion6<T>& J)
      : first(ad(V_p, J)), second(ad(dV_p, J) + ad(V_p, first)) {}
};

/// The Coriolis inertia B = 2 [[D, 0], [-p~, 0]] of rigid bodies, each with its own twist, in inertial axes
/// about a point O. For a twist X = (w; v), B X = 2 ∫ (r × (w × r'); w × r') dm is the wrench that gives the
/// mass elements dm, with the position r from O and the velocity r', the Coriolis acceleration 2 w × r'.
/// Hence D = tr(E) 1 - E with E = ∫ r' rᵀ dm, and p = ∫ r' dm. The 12 numbers of D and p can be summed over
/// bodies. See (D1.9) to (D1.12) of docs/derivations.
template <class T> struct CoriolisInertia {
  Mat3<T> D;
  Vec3<T> p;

  /// The Coriolis inertia B of one body with the inertia M and the twist V, both in inertial axes about the
  /// point O. For any twist X, B X = M' X - ad_Xᵀ M V, where M' is the time derivative of M.
  static constexpr CoriolisInertia of(const Inertia<T>& M, const Motion6<T>& V) {
    const Mat3<T> E = cross(V.w, matrix(binet_tensor(M.Theta))) + outer_product(V.v, M.h);
    return {
        {{E.y.y + E.z.z, -E.x.y, -E.x.z}, {-E.y.x, E.x.x + E.z.z, -E.y.z}, {-E.z.x, -E.z.y, E.x.x + E.y.y}},
        M.m * V.v + cross(V.w, M.h)};
  }
  constexpr Wrench<Spatial, T> operator*(const Motion6<T>& X) const {
    const Vec3<T> w = T(2) * X.w;
    return {D * w, cross(w, p)};
  }
  /// The moment 2 (Dᵀ w + p × v) of the wrench Bᵀ X for a twist X = (w; v); the force of this wrench is 0. B
  /// is the Coriolis inertia 2 [[D, 0], [-p~, 0]] of mass elements dm with the position r and the velocity
  /// r':
  ///   p = ∫ r' dm,   E = ∫ r' rᵀ dm,   D = tr(E) 1 - E.
  constexpr Vec3<T> transposed_times(const Motion6<T>& X) const {
    return T(2) * (transposed_times_(X.w) + cross(p, X.v));
  }
  /// The derivative of the Coriolis inertia B when the bodies are displaced along the screw J and the
  /// velocities r' of their mass elements dm turn with them. B is the matrix with B X = 2 ∫ (r × (w × r');
  /// w × r') dm for a twist X = (w; v), where r is the position of dm. See (D2.10) of docs/derivations.
  constexpr CoriolisInertia along(const Motion6<T>& J) const {
    const Vec3<T>& e = J.w;
    const T pv = dot(p, J.v);  // D' = e~ D - D e~ + p·v 1 - p vᵀ
    const Mat3<T> turned =
        cross(e, D) + Mat3<T>{e.y * D.z - e.z * D.y, e.z * D.x - e.x * D.z, e.x * D.y - e.y * D.x};
    const Mat3<T> moved{{pv, T(0), T(0)}, {T(0), pv, T(0)}, {T(0), T(0), pv}};
    return {turned + moved + outer_product(-p, J.v), cross(e, p)};
  }
  constexpr CoriolisInertia& operator+=(const CoriolisInertia& other) {
    D += other.D;
    p += other.p;
    return *this;
  }

 private:
  constexpr Vec3<T> transposed_times_(const Vec3<T>& w) const { return axode::transposed_times(D, w); }
};

}  // namespace axode
