#pragma once
#include "axode/lie/newton_euler.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/recursion/articulated_inertia.hpp"

/// Link<Rep>: the transformations of twists and wrenches between body i and its predecessor p, and the
/// Newton-Euler equations of the body, in each representation. C = (R, r) is the pose of body i in the
/// inertial frame, C_ip that of p in body i, and r_ip the vector from the origin of i to that of p. The twist
/// of body i is V = (ω; v), that of its joint is S v, and M is the body-fixed inertia. push() converts from
/// body-fixed coordinates to Rep, and pull() converts back; the table has the matrix of push() for twists.
///
///                body-fixed  spatial       hybrid                   mixed
///  push, pull    identity    Ad_C          Ad_R                     diag(I, R)       body-fixed <-> Rep
///  down          Ad_{C_ip}   identity      Ad_{r_ip}                see Link<Mixed>  twist of p -> at i
///  up            Ad_{C_ip}ᵀ  identity      Ad_{r_ip}ᵀ               transpose of down wrench of i -> at p
///  bias          ad_V (S v)  ad_V (S v)    ad_{r'_ip} V_p + ad_ω Sv see Link<Mixed>  V'_i - down(V'_p) - S a
///  inertia       M           Ad_C⁻ᵀMAd_C⁻¹ Ad_R⁻ᵀMAd_R⁻¹            M (body-fixed)   inertia of body i
///  newton_euler  eq. NEb     eq. NEs       eq. NEh                  eq. NEcmixed     wrench on body i
///
/// `down` and `up` are dual to each other, see (D4.1) of docs/derivations. Names of equations are the labels
/// in Müller's paper, see docs/notation.md.
namespace axode {

template <class Rep, class T> struct Link;

/// The transformations between body i and its predecessor p (Link) in body-fixed representation: V_i^b =
/// Ad_{C_ip} V_p^b + X v for the joint velocities v, with the body-fixed screws X of the joint and the pose
/// C_ip of p relative to i (Müller, eq. VbRec).
template <class T> struct Link<BodyFixed, T> {
  SE3<T> C_pi;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C) const { return {C}; }
  constexpr SE3<T> body_pose() const { return {}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<BodyFixed, T> down(const V<BodyFixed, T>& V_p) const {
    const Screw<T> X = Ad_inv(C_pi, Screw<T>{V_p.w, V_p.v});
    return {X.w, X.v};
  }
  constexpr Wrench<BodyFixed, T> up(const Wrench<BodyFixed, T>& W) const {
    const ScrewOperationScope<T> scope(ScrewOperation::transformation);
    const Vec3<T> f = C_pi.R * W.f;
    return {C_pi.R * W.m + cross(C_pi.r, f), f};
  }
  constexpr Inertia<T> up(const Inertia<T>& M) const { return transform(C_pi, M); }
  constexpr ArticulatedInertia<BodyFixed, T> up(const ArticulatedInertia<BodyFixed, T>& M) const {
    const ScrewOperationScope<T> scope(ScrewOperation::tensor_transformation);
    const SO3<T>&R = C_pi.R, Rt = transpose(R);
    return transform(C_pi.r,
                     ArticulatedInertia<BodyFixed, T>{rotate(R, M.A), (R * M.B) * Rt, rotate(R, M.L)});
  }
  /// The bias [V_i, X v] of V'_i, where X v is the joint motion (Müller, eqs. crecVbi, cVbRec2).
  constexpr TwistRate<BodyFixed, T> bias(const Twist<BodyFixed, T>&, const Twist<BodyFixed, T>& V,
                                         const Twist<BodyFixed, T>& Sv) const {
    const Twist<BodyFixed, T> X = ad(V, Sv);
    return {X.w, X.v};
  }
  template <class InertiaOfBody> constexpr Inertia<T> inertia(const InertiaOfBody& M) const { return M; }
  template <class InertiaOfBody>
  constexpr Wrench<BodyFixed, T> newton_euler(const InertiaOfBody& M, const Twist<BodyFixed, T>& V,
                                              const TwistRate<BodyFixed, T>& dV) const {
    return axode::newton_euler(M, V, dV);
  }
};

/// The transformations between body i and its predecessor p (Link) in spatial representation: V_i^s = V_p^s +
/// J^s v for the joint velocities v, with the spatial screws J^s of the joint (Müller, eqs. Vsrec, Vsirec).
template <class T> struct Link<Spatial, T> {
  SE3<T> C;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C_pi) const { return {C * C_pi}; }
  constexpr const SE3<T>& body_pose() const { return C; }

  template <class Screwlike> constexpr Screwlike down(const Screwlike& V_p) const { return V_p; }
  template <class Anything> constexpr const Anything& up(const Anything& W) const { return W; }
  /// The bias [V_i, J v] of V'_i, where J v is the joint motion (Müller, eqs. timeDerJs, Visdotrec).
  constexpr TwistRate<Spatial, T> bias(const Twist<Spatial, T>&, const Twist<Spatial, T>& V,
                                       const Twist<Spatial, T>& Sv) const {
    const Twist<Spatial, T> X = ad(V, Sv);
    return {X.w, X.v};
  }
  template <class InertiaOfBody> constexpr Inertia<T> inertia(const InertiaOfBody& M) const {
    return transform(C, M);
  }
  template <class InertiaOfBody>
  constexpr Wrench<Spatial, T> newton_euler(const InertiaOfBody& M, const Twist<Spatial, T>& V,
                                            const TwistRate<Spatial, T>& dV) const {
    return axode::newton_euler(transform(C, M), V, dV);
  }
};

/// The transformations between body i and its predecessor p (Link) in hybrid representation: V_i^h =
/// Ad_{r_ip} V_p^h + Ad_R X v for the joint velocities v, with the body-fixed screws X of the joint (Müller,
/// eq. VhRec). The rotation R maps the axes of body i to inertial axes. r_pi is the vector from the origin of
/// p to that of i in inertial axes, and r_ip = -r_pi.
template <class T> struct Link<Hybrid, T> {
  SO3<T> R;
  Vec3<T> r_pi;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C_pi) const { return {R * C_pi.R, R * C_pi.r}; }
  constexpr SE3<T> body_pose() const { return {R, {}}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Hybrid, T> down(const V<Hybrid, T>& V_p) const {
    const ScrewOperationScope<T> scope(ScrewOperation::translation);
    return {V_p.w, V_p.v + cross(V_p.w, r_pi)};
  }
  constexpr Wrench<Hybrid, T> up(const Wrench<Hybrid, T>& W) const {
    const ScrewOperationScope<T> scope(ScrewOperation::translation);
    return {W.m + cross(r_pi, W.f), W.f};
  }
  constexpr Inertia<T> up(const Inertia<T>& M) const { return transform(r_pi, M); }
  constexpr ArticulatedInertia<Hybrid, T> up(const ArticulatedInertia<Hybrid, T>& M) const {
    return transform(r_pi, M);
  }
  /// The part ad_{r'_ip} V_p + ad_ω (X v) of the hybrid twist rate V'_i of body i that is due to velocities
  /// (equations recVhdot1 and dVhRec2 of Müller's paper, see docs/notation.md). V_p is the hybrid twist of
  /// the predecessor p, ω the angular velocity of body i, and X v the twist of the joint in inertial axes.
  /// r'_ip = r'_p - r'_i is the difference of the velocities of the origins of p and i.
  constexpr TwistRate<Hybrid, T> bias(const Twist<Hybrid, T>& V_p, const Twist<Hybrid, T>& V,
                                      const Twist<Hybrid, T>& Sv) const {
    ScrewOperationScope<T>{ScrewOperation::bracket};
    ScrewOperationScope<T>{ScrewOperation::bracket};
    return {cross(V.w, Sv.w), cross(V_p.v - V.v, V_p.w) + cross(V.w, Sv.v)};
  }
  template <class InertiaOfBody> constexpr Inertia<T> inertia(const InertiaOfBody& M) const {
    return transform(R, M);
  }
  template <class InertiaOfBody>
  constexpr Wrench<Hybrid, T> newton_euler(const InertiaOfBody& M, const Twist<Hybrid, T>& V,
                                           const TwistRate<Hybrid, T>& dV) const {
    return axode::newton_euler(transform(R, M), V, dV);
  }
};

/// The transformations between body i and its predecessor (Link) in mixed representation: twists V^m = (ω^b,
/// r') have the angular part of body-fixed and the linear part of hybrid twists.
template <class T> struct Link<Mixed, T> {
  SE3<T> C_pi;
  SO3<T> R_p, R;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C) const { return {C, R, R * C.R}; }
  constexpr SE3<T> body_pose() const { return {R, {}}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Mixed, T> down(const V<Mixed, T>& V_p) const {
    const ScrewOperationScope<T> scope(ScrewOperation::transformation);
    return {transpose(C_pi.R) * V_p.w, V_p.v + R_p * cross(V_p.w, C_pi.r)};
  }
  constexpr Wrench<Mixed, T> up(const Wrench<Mixed, T>& W) const {
    const ScrewOperationScope<T> scope(ScrewOperation::transformation);
    return {C_pi.R * W.m + cross(C_pi.r, transpose(R_p) * W.f), W.f};
  }
  constexpr Inertia<T> up(const Inertia<T>& M) const { return transform(C_pi, M); }
  /// The articulated inertia M, moved to the origin of the predecessor.
  constexpr ArticulatedInertia<Mixed, T> up(const ArticulatedInertia<Mixed, T>& M) const {
    const ScrewOperationScope<T> scope(ScrewOperation::tensor_transformation);
    const SO3<T> Rt_p = transpose(R_p);
    const ArticulatedInertia<Mixed, T> M_p = transform(
        C_pi.r, ArticulatedInertia<Mixed, T>{rotate(C_pi.R, M.A), (C_pi.R * M.B) * R_p, rotate(Rt_p, M.L)});
    return {M_p.A, M_p.B * Rt_p, M.L};
  }
  /// The part of the twist rate V'_i that is due to velocities. The angular part is ω × s in axes of body i,
  /// with the angular velocities ω of body i and s of the joint. The linear part, as for hybrid twists, is
  /// the vector (r'_p - r'_i) × ω_p + ω × u in inertial axes, with the velocities r' of the origins of body i
  /// and its predecessor p, the angular velocity ω_p of p and the linear velocity u of the joint.
  constexpr TwistRate<Mixed, T> bias(const Twist<Mixed, T>& V_p, const Twist<Mixed, T>& V,
                                     const Twist<Mixed, T>& Sv) const {
    ScrewOperationScope<T>{ScrewOperation::bracket};
    ScrewOperationScope<T>{ScrewOperation::bracket};
    return {cross(V.w, Sv.w), cross(V_p.v - V.v, R_p * V_p.w) + cross(R * V.w, Sv.v)};
  }
  /// The inertia in body axes, from which impulse() and articulated() make the mixed one.
  template <class InertiaOfBody> constexpr Inertia<T> inertia(const InertiaOfBody& M) const { return M; }
  template <class InertiaOfBody>
  constexpr Wrench<Mixed, T> newton_euler(const InertiaOfBody& M, const Twist<Mixed, T>& V,
                                          const TwistRate<Mixed, T>& dV) const {
    return axode::newton_euler(M, R, V, dV);
  }
};

/// Converts a joint screw from body-fixed coordinates to the representation Rep: for example the twist S v of
/// a joint, or the part S a of its rate, with the unit screws S, velocities v and accelerations a of the
/// joint (Müller, eqs. bVsRec, bVhRec2). The terms of the rate that are due to velocities are in
/// Link::bias().
template <template <class, class> class V, class Rep, class T>
  requires Motion<V>
constexpr V<Rep, T> push(const Link<Rep, T>& link, const V<BodyFixed, T>& X) {
  const Twist<Rep, T> J = change<Rep>(link.body_pose(), Twist<BodyFixed, T>{X.w, X.v});
  return {J.w, J.v};
}
/// Converts a body-fixed wrench to Rep.
template <class Rep, class T>
constexpr Wrench<Rep, T> push(const Link<Rep, T>& link, const Wrench<BodyFixed, T>& W) {
  return change<Rep>(link.body_pose(), W);
}
/// Converts a wrench in Rep to the body-fixed wrench.
template <class Rep, class T>
constexpr Wrench<BodyFixed, T> pull(const Link<Rep, T>& link, const Wrench<Rep, T>& W) {
  return change<BodyFixed>(link.body_pose(), W);
}

/// The impulse M V that gives a body at rest the twist V. M is the inertia that Link::inertia() returns.
template <class Rep, class T>
constexpr Wrench<Rep, T> impulse(const Link<Rep, T>& link, const Inertia<T>& M, const Twist<Rep, T>& V) {
  if constexpr (std::same_as<Rep, Mixed>) {
    const Momentum<BodyFixed, T> Pi = M * Twist<BodyFixed, T>{V.w, transpose(link.R) * V.v};
    return {Pi.l, link.R * Pi.p};
  } else {
    const Momentum<Rep, T> Pi = M * V;
    return {Pi.l, Pi.p};
  }
}

/// The wrench that a body needs to keep its twist V. M is the inertia that Link::inertia() returns.
template <class Rep, class T>
constexpr Wrench<Rep, T> velocity_wrench(const Link<Rep, T>& link, const Inertia<T>& M,
                                         const Twist<Rep, T>& V) {
  if constexpr (std::same_as<Rep, Mixed>)
    return velocity_wrench(M, link.R, V);
  else
    return velocity_wrench(M, V);
}

/// The inertia matrix of a rigid body in Rep. M is the inertia that Link::inertia() returns.
template <class Rep, class T>
constexpr ArticulatedInertia<Rep, T> articulated(const Link<Rep, T>& link, const Inertia<T>& M) {
  const Mat3<T> h = skew_matrix(M.h);
  if constexpr (std::same_as<Rep, Mixed>)
    return {M.Theta, h * transpose(link.R), identity_tensor(M.m)};
  else
    return {M.Theta, h, identity_tensor(M.m)};
}

}  // namespace axode
