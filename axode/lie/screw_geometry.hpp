#pragma once
#include <limits>

#include "axode/lie/twist.hpp"

namespace axode {

/// The geometry of a screw: a line with the unit direction e through the point p (m), a pitch h in m/rad and
/// a magnitude. An infinite pitch marks a translation or a couple; p is then 0.
template <class T = double> struct ScrewAxis {
  Vec3<T> e, p;
  T h{};
  T magnitude{};
};

/// Plücker coordinates of a line: the direction e and the moment p × e.
template <class T = double> struct PlueckerLine { Vec3<T> e, moment; };

/// The line of a screw axis with a finite pitch.
template <class T> constexpr PlueckerLine<T> pluecker(const ScrewAxis<T>& axis) {
  return {axis.e, cross(axis.p, axis.e)};
}

/// Screw coordinates: the magnitude times (e; p × e + h e), or times (0; e) for an infinite pitch h, with the
/// direction e and the point p of the axis.
template <class T> constexpr Screw<T> screw(const ScrewAxis<T>& a) {
  const bool finite = a.h < std::numeric_limits<T>::infinity();
  const T h = select(finite, a.h, T(0));
  const Screw<T> X{a.e, cross(a.p, a.e) + h * a.e}, translation{Vec3<T>{}, a.e};
  return a.magnitude * (finite ? X : translation);
}
/// The joint screw (e; p × e + h e) of a line with direction e (unit) through p, with pitch h in m/rad.
template <class T> constexpr Screw<T> screw(const Vec3<T>& e, const Vec3<T>& p, const T& h = T(0)) {
  return {e, cross(p, e) + h * e};
}

/// Direction, point, pitch and magnitude of a screw X = (w; v). The point is the one of the axis nearest to
/// the origin; the magnitude is ‖w‖, or ‖v‖ if w = 0. The zero screw has magnitude 0 and direction 0.
template <class T> constexpr ScrewAxis<T> screw_axis(const Screw<T>& X) {
  const T w2 = dot(X.w, X.w);
  if (w2 > T(0)) {
    const T w = sqrt(w2);
    return {(T(1) / w) * X.w, (T(1) / w2) * cross(X.w, X.v), dot(X.w, X.v) / w2, w};
  }
  const T v = norm(X.v);
  const Vec3<T> e = v > T(0) ? (T(1) / v) * X.v : Vec3<T>{};
  return {e, Vec3<T>{}, std::numeric_limits<T>::infinity(), v};
}
/// The instantaneous screw axis of a body, in the frame of its twist V: body-fixed or spatial.
template <AtFrameOrigin Rep, class T> constexpr ScrewAxis<T> screw_axis(const Twist<Rep, T>& V) {
  return screw_axis(Screw<T>{V.w, V.v});
}
/// The central axis of a wrench, with the pitch moment·force/‖force‖², which is infinite for a couple.
template <AtFrameOrigin Rep, class T> constexpr ScrewAxis<T> screw_axis(const Wrench<Rep, T>& W) {
  return screw_axis(Screw<T>{W.f, W.m});
}

}  // namespace axode
