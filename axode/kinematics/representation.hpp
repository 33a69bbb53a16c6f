#pragma once
#include "axode/lie/twist.hpp"

/// The table of representations: what one body contributes to any recursion over a tree.
///
///             body-fixed            spatial         hybrid                    mixed
///   push      identity              Ad_C            Ad_R                      diag(I, R)        body screw -> rep
///   down      Ad_{C_ip}             identity        Ad_{r_ip}                 block of the two  twist of p -> at i
///   up        Ad_{C_ip}ᵀ            identity        Ad_{r_ip}ᵀ                its transpose     wrench of i -> at p
///   bias      ad_V (S v)            ad_V (S v)      ad_{r'_ip} V_p + ad_ω Sv  from definition   V'_i - down(V'_p) - S a
///
/// A Link is that for body i with predecessor p. A frame on a body is a body that never moves against it: its
/// Link is the child of the body's, with S v = 0.
namespace axode {

template <class Rep, class T> struct Link;

/// V^b = Ad_{C_ip} V_p^b + X v (eq. VbRec).
template <class T> struct Link<BodyFixed, T> {
  SE3<T> C_pi;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C) const { return {C}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<BodyFixed, T> down(const V<BodyFixed, T>& V_p) const {
    const Screw<T> X = Ad_inv(C_pi, Screw<T>{V_p.w, V_p.v});
    return {X.w, X.v};
  }
  constexpr Wrench<BodyFixed, T> up(const Wrench<BodyFixed, T>& W) const {
    const Noted<T> noted(ScrewOperation::transformation);
    const Vec3<T> f = C_pi.R * W.f;
    return {C_pi.R * W.m + cross(C_pi.r, f), f};
  }
  template <class Screwlike> constexpr Screwlike push(const Screwlike& X) const { return X; }
  constexpr Wrench<BodyFixed, T> pull(const Wrench<BodyFixed, T>& W) const { return W; }
  /// [V_i, X v] (eqs. crecVbi, cVbRec2).
  constexpr TwistRate<BodyFixed, T> bias(const Twist<BodyFixed, T>&, const Twist<BodyFixed, T>& V,
                                         const Twist<BodyFixed, T>& Sv) const {
    const Twist<BodyFixed, T> X = ad(V, Sv);
    return {X.w, X.v};
  }
};

/// V^s = V_p^s + J^s v (eqs. Vsrec, Vsirec).
template <class T> struct Link<Spatial, T> {
  SE3<T> C;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C_pi) const { return {C * C_pi}; }

  template <class Screwlike> constexpr Screwlike down(const Screwlike& V_p) const { return V_p; }
  constexpr Wrench<Spatial, T> up(const Wrench<Spatial, T>& W) const { return W; }
  /// J^s = Ad_C X (eq. bVsRec).
  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Spatial, T> push(const V<BodyFixed, T>& X) const {
    const Screw<T> J = Ad(C, Screw<T>{X.w, X.v});
    return {J.w, J.v};
  }
  constexpr Wrench<Spatial, T> push(const Wrench<BodyFixed, T>& W) const { return coAd(C, W); }
  constexpr Wrench<BodyFixed, T> pull(const Wrench<Spatial, T>& W) const { return coAd_inv(C, W); }
  /// [V_i, J v] (eqs. timeDerJs, Visdotrec).
  constexpr TwistRate<Spatial, T> bias(const Twist<Spatial, T>&, const Twist<Spatial, T>& V,
                                       const Twist<Spatial, T>& Sv) const {
    const Twist<Spatial, T> X = ad(V, Sv);
    return {X.w, X.v};
  }
};

/// V^h = Ad_{r_ip} V_p^h + Ad_R X v (eq. VhRec); r_pi from p to i, in inertial axes.
template <class T> struct Link<Hybrid, T> {
  SO3<T> R;
  Vec3<T> r_pi;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C_pi) const { return {R * C_pi.R, R * C_pi.r}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Hybrid, T> down(const V<Hybrid, T>& V_p) const {
    const Noted<T> noted(ScrewOperation::translation);
    return {V_p.w, V_p.v + cross(V_p.w, r_pi)};
  }
  constexpr Wrench<Hybrid, T> up(const Wrench<Hybrid, T>& W) const {
    const Noted<T> noted(ScrewOperation::translation);
    return {W.m + cross(r_pi, W.f), W.f};
  }
  /// ^0X^i = Ad_R X (eq. bVhRec2).
  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Hybrid, T> push(const V<BodyFixed, T>& X) const {
    const Noted<T> noted(ScrewOperation::rotation);
    return {R * X.w, R * X.v};
  }
  constexpr Wrench<Hybrid, T> push(const Wrench<BodyFixed, T>& W) const {
    const Noted<T> noted(ScrewOperation::rotation);
    return {R * W.m, R * W.f};
  }
  constexpr Wrench<BodyFixed, T> pull(const Wrench<Hybrid, T>& W) const {
    const Noted<T> noted(ScrewOperation::rotation);
    const SO3<T> Rt = transpose(R);
    return {Rt * W.m, Rt * W.f};
  }
  /// ad_{r'_ip} V_p + ad_ω (X v) with r'_ip = r'_p - r'_i (eqs. recVhdot1, dVhRec2).
  constexpr TwistRate<Hybrid, T> bias(const Twist<Hybrid, T>& V_p, const Twist<Hybrid, T>& V,
                                      const Twist<Hybrid, T>& Sv) const {
    Noted<T>{ScrewOperation::bracket};
    Noted<T>{ScrewOperation::bracket};
    return {cross(V.w, Sv.w), cross(V_p.v - V.v, V_p.w) + cross(V.w, Sv.v)};
  }
};

/// V^m = (ω^b, r'): the angular part of body-fixed, the linear part of hybrid twists.
template <class T> struct Link<Mixed, T> {
  SE3<T> C_pi;
  SO3<T> R_p, R;

  static constexpr Link root() { return {}; }
  constexpr Link child(const SE3<T>& C) const { return {C, R, R * C.R}; }

  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Mixed, T> down(const V<Mixed, T>& V_p) const {
    const Noted<T> noted(ScrewOperation::transformation);
    return {transpose(C_pi.R) * V_p.w, V_p.v + R_p * cross(V_p.w, C_pi.r)};
  }
  constexpr Wrench<Mixed, T> up(const Wrench<Mixed, T>& W) const {
    const Noted<T> noted(ScrewOperation::transformation);
    return {C_pi.R * W.m + cross(C_pi.r, transpose(R_p) * W.f), W.f};
  }
  template <template <class, class> class V>
    requires Motion<V>
  constexpr V<Mixed, T> push(const V<BodyFixed, T>& X) const {
    const Noted<T> noted(ScrewOperation::rotation);
    return {X.w, R * X.v};
  }
  constexpr Wrench<Mixed, T> push(const Wrench<BodyFixed, T>& W) const {
    const Noted<T> noted(ScrewOperation::rotation);
    return {W.m, R * W.f};
  }
  constexpr Wrench<BodyFixed, T> pull(const Wrench<Mixed, T>& W) const {
    const Noted<T> noted(ScrewOperation::rotation);
    return {W.m, transpose(R) * W.f};
  }
  /// The hybrid bias with its angular part in body axes, where (Rᵀ)' ω^s = -ω × ω = 0 leaves ω_i × (S v).
  constexpr TwistRate<Mixed, T> bias(const Twist<Mixed, T>& V_p, const Twist<Mixed, T>& V,
                                     const Twist<Mixed, T>& Sv) const {
    Noted<T>{ScrewOperation::bracket};
    Noted<T>{ScrewOperation::bracket};
    return {cross(V.w, Sv.w), cross(V_p.v - V.v, R_p * V_p.w) + cross(R * V.w, Sv.v)};
  }
};

}  // namespace axode
