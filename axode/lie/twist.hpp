#pragma once
#include <array>
#include <concepts>
#include <string_view>
#include <utility>

#include "axode/lie/se3.hpp"

/// Twists, twist rates, wrenches and momenta, with types for the axes and reference points of components.
namespace axode {

struct BodyFixed {};  ///< axes of the body frame, about its origin: V^b
struct Spatial {};    ///< axes of the inertial frame, about its origin: V^s
struct Hybrid {};     ///< axes of the inertial frame, about the origin of the body frame: V^h
struct Mixed {};  ///< angular part in body axes, linear part in inertial axes, about the body's origin: V^m
struct InFrames {};  ///< measured at the origin of a frame j, resolved in a frame k: ^kV^j

/// The four representations in which recursions run: BodyFixed, Spatial, Hybrid, Mixed.
template <class Rep>
concept RecursionRepresentation = std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial> ||
    std::same_as<Rep, Hybrid> || std::same_as<Rep, Mixed>;
/// The representations in which a twist can be written: the four of the recursions, and InFrames.
template <class Rep>
concept TwistRepresentation = RecursionRepresentation<Rep> || std::same_as<Rep, InFrames>;

/// The four representations of the recursions as values, for programs that choose one at run time.
enum class Representation { body, spatial, hybrid, mixed };

/// Names of the representations on the command line, in JSON and in Python.
inline constexpr std::array<std::pair<std::string_view, Representation>, 4> representations{
    {{"body", Representation::body},
     {"spatial", Representation::spatial},
     {"hybrid", Representation::hybrid},
     {"mixed", Representation::mixed}}};
/// The name of a representation.
constexpr std::string_view word_for(Representation representation) {
  return representations[static_cast<std::size_t>(representation)].first;
}

/// Calls f(Rep{}) with the type of the given representation and returns the result.
template <class F> constexpr decltype(auto) with_representation(Representation representation, F&& f) {
  switch (representation) {
    case Representation::body: return f(BodyFixed{});
    case Representation::spatial: return f(Spatial{});
    case Representation::hybrid: return f(Hybrid{});
    case Representation::mixed: break;
  }
  return f(Mixed{});
}

/// The representations BodyFixed and Spatial, in which twists are screw coordinates in one frame.
template <class Rep>
concept AtFrameOrigin = std::same_as<Rep, BodyFixed> || std::same_as<Rep, Spatial>;

/// A twist V = (w; v): angular velocity in rad/s and linear velocity in m/s.
template <class Rep, class T = double> struct Twist {
  static_assert(TwistRepresentation<Rep>, "a twist is BodyFixed, Spatial, Hybrid, Mixed or InFrames");
  Vec3<T> w, v;
};
/// A twist rate V' = (w; v) in rad/s² and m/s²: the time derivative of the components of a twist.
template <class Rep, class T = double> struct TwistRate {
  static_assert(TwistRepresentation<Rep>, "a twist's rate is BodyFixed, Spatial, Hybrid, Mixed or InFrames");
  Vec3<T> w, v;
};
/// A wrench W = (m; f): moment in N m and force in N. It is dual to the twist of the same representation.
template <class Rep, class T = double> struct Wrench {
  static_assert(TwistRepresentation<Rep>, "a wrench is BodyFixed, Spatial, Hybrid, Mixed or InFrames");
  Vec3<T> m, f;
};
/// A momentum Π = (l; p), dual to a twist of the same representation: angular in N m s, linear in N s.
template <class Rep, class T = double> struct Momentum {
  static_assert(TwistRepresentation<Rep>, "a momentum is BodyFixed, Spatial, Hybrid, Mixed or InFrames");
  Vec3<T> l, p;
};

template <template <class, class> class Kind> inline constexpr bool is_screw_kind = false;
template <> inline constexpr bool is_screw_kind<Twist> = true;
template <> inline constexpr bool is_screw_kind<TwistRate> = true;
template <> inline constexpr bool is_screw_kind<Wrench> = true;
template <> inline constexpr bool is_screw_kind<Momentum> = true;

/// Twist or TwistRate: a map between frames at rest relative to each other transforms both in the same way.
template <template <class, class> class Kind>
concept Motion = is_screw_kind<Kind> && requires(Kind<BodyFixed, double> x) {
  x.w, x.v;
};

template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T> operator+(const Kind<Rep, T>& x, const Kind<Rep, T>& y) {
  const auto& [x1, x2] = x;
  const auto& [y1, y2] = y;
  return {x1 + y1, x2 + y2};
}
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T> operator-(const Kind<Rep, T>& x, const Kind<Rep, T>& y) {
  const auto& [x1, x2] = x;
  const auto& [y1, y2] = y;
  return {x1 - y1, x2 - y2};
}

/// Always false: the condition of static assertions against sums of quantities in different representations.
template <class...> inline constexpr bool addable = false;
template <template <class, class> class Kind, class Rep, class Other, class T>
  requires(is_screw_kind<Kind> && !std::same_as<Rep, Other>)
constexpr Kind<Rep, T> operator+(const Kind<Rep, T>& x, const Kind<Other, T>&) {
  static_assert(
      addable<Rep, Other>,
      "the two are in different representations; bring one into that of the other with change<To>(C, x)");
  return x;
}
template <template <class, class> class Kind, class Rep, class Other, class T>
  requires(is_screw_kind<Kind> && !std::same_as<Rep, Other>)
constexpr Kind<Rep, T> operator-(const Kind<Rep, T>& x, const Kind<Other, T>&) {
  static_assert(
      addable<Rep, Other>,
      "the two are in different representations; bring one into that of the other with change<To>(C, x)");
  return x;
}
template <template <class, class> class Kind, template <class, class> class Another, class Rep, class Other,
          class T>
  requires(is_screw_kind<Kind>&& is_screw_kind<Another> && !std::same_as<Kind<Rep, T>, Another<Rep, T>>)
constexpr Kind<Rep, T> operator+(const Kind<Rep, T>& x, const Another<Other, T>&) {
  static_assert(addable<Rep, Other>,
                "a twist, a twist rate, a wrench and a momentum do not add to one another");
  return x;
}
template <template <class, class> class Kind, template <class, class> class Another, class Rep, class Other,
          class T>
  requires(is_screw_kind<Kind>&& is_screw_kind<Another> && !std::same_as<Kind<Rep, T>, Another<Rep, T>>)
constexpr Kind<Rep, T> operator-(const Kind<Rep, T>& x, const Another<Other, T>&) {
  static_assert(addable<Rep, Other>,
                "a twist, a twist rate, a wrench and a momentum do not subtract from one another");
  return x;
}

template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T> operator-(const Kind<Rep, T>& x) {
  const auto& [x1, x2] = x;
  return {-x1, -x2};
}
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T> operator*(const T& s, const Kind<Rep, T>& x) {
  const auto& [x1, x2] = x;
  return {s * x1, s * x2};
}
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T>& operator+=(Kind<Rep, T>& x, const Kind<Rep, T>& y) { return x = x + y; }
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr Kind<Rep, T>& operator-=(Kind<Rep, T>& x, const Kind<Rep, T>& y) { return x = x - y; }

/// W | V, the power of a wrench on a twist in W.
template <class Rep, class T> constexpr T operator|(const Wrench<Rep, T>& W, const Twist<Rep, T>& V) {
  return dot(W.m, V.w) + dot(W.f, V.v);
}
/// Π | V in J, which is twice the kinetic energy if Π = M V.
template <class Rep, class T> constexpr T operator|(const Momentum<Rep, T>& Pi, const Twist<Rep, T>& V) {
  return dot(Pi.l, V.w) + dot(Pi.p, V.v);
}

/// The screw coordinates of a body-fixed or spatial twist.
template <AtFrameOrigin Rep, class T> constexpr Screw<T> screw(const Twist<Rep, T>& V) { return {V.w, V.v}; }
/// The body-fixed or spatial twist with the screw coordinates X.
template <AtFrameOrigin Rep, class T> constexpr Twist<Rep, T> twist(const Screw<T>& X) { return {X.w, X.v}; }

/// The Lie bracket ad_V1 V2 = [V1, V2] of two twists in one representation (Müller, eq. ScrewProd).
template <AtFrameOrigin Rep, class T>
constexpr Twist<Rep, T> ad(const Twist<Rep, T>& V1, const Twist<Rep, T>& V2) {
  return twist<Rep>(ad(screw(V1), screw(V2)));
}
/// The wrench -ad_Vᵀ Π: the rate of a momentum Π that moves with a body of the twist V.
template <AtFrameOrigin Rep, class T>
constexpr Wrench<Rep, T> coad(const Twist<Rep, T>& V, const Momentum<Rep, T>& Pi) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {cross(V.w, Pi.l) + cross(V.v, Pi.p), cross(V.w, Pi.p)};
}
/// The wrench -ad_Xᵀ W: the counterpart of the Lie bracket ad_X for wrenches.
template <AtFrameOrigin Rep, class T>
constexpr Wrench<Rep, T> coad(const Twist<Rep, T>& X, const Wrench<Rep, T>& W) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {cross(X.w, W.m) + cross(X.v, W.f), cross(X.w, W.f)};
}

/// The spatial twist V^s = Ad_C V^b of a body with pose C from its body-fixed twist (Müller, eq. VsVb).
template <class T> constexpr Twist<Spatial, T> Ad(const SE3<T>& C, const Twist<BodyFixed, T>& V) {
  return twist<Spatial>(Ad(C, screw(V)));
}
/// The body-fixed twist V^b = Ad_C⁻¹ V^s of a body with pose C from its spatial twist (Müller, eq. VsVb).
template <class T> constexpr Twist<BodyFixed, T> Ad_inv(const SE3<T>& C, const Twist<Spatial, T>& V) {
  return twist<BodyFixed>(Ad_inv(C, screw(V)));
}
/// W^s = Ad_C⁻ᵀ W^b: the wrench about the inertial origin from the wrench W^b about the origin of a body
/// frame with pose C.
template <class T> constexpr Wrench<Spatial, T> coAd(const SE3<T>& C, const Wrench<BodyFixed, T>& W) {
  const ScrewOperationScope<T> scope(ScrewOperation::transformation);
  const Vec3<T> f = C.R * W.f;
  return {C.R * W.m + cross(C.r, f), f};
}
/// W^b = Ad_Cᵀ W^s: the wrench about the origin of a body frame with pose C from the wrench W^s about the
/// inertial origin.
template <class T> constexpr Wrench<BodyFixed, T> coAd_inv(const SE3<T>& C, const Wrench<Spatial, T>& W) {
  const ScrewOperationScope<T> scope(ScrewOperation::transformation);
  const SO3<T> Rt = transpose(C.R);
  return {Rt * (W.m - cross(C.r, W.f)), Rt * W.f};
}

}  // namespace axode
