#pragma once
#include "axode/kinematics/representation.hpp"
#include "axode/lie/inertia.hpp"

/// Inertia in the table of representations: what a body's inertia is in Rep, what it is at the predecessor,
/// and the wrench for a unit of time that gives it a twist. The mixed inertia matrix has blocks in different
/// axes and is kept by the inertia in body axes.
namespace axode {

/// M_i in Rep (eqs. Ms, aWsRec, aWhRec).
template <class Rep, class T, class InertiaOfBody>
constexpr Inertia<T> inertia(const Link<Rep, T>& link, const InertiaOfBody& M) {
  if constexpr (std::same_as<Rep, Spatial>)
    return transform(link.C, M);
  else if constexpr (std::same_as<Rep, Hybrid>)
    return transform(link.R, M);
  else
    return M;
}

/// downᵀ M down: the inertia of a body as one of its predecessor.
template <class Rep, class T> constexpr Inertia<T> up(const Link<Rep, T>& link, const Inertia<T>& M) {
  if constexpr (std::same_as<Rep, Spatial>)
    return M;
  else if constexpr (std::same_as<Rep, Hybrid>)
    return transform(link.r_pi, M);
  else
    return transform(link.C_pi, M);
}

/// M V, as the impulse that gives M the twist V from rest.
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

}  // namespace axode
