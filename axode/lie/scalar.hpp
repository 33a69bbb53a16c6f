#pragma once
#include <cmath>
#include <concepts>
#include <limits>

/// Everything in this library is written for any scalar T closed under + - * /, sqrt, sin, cos, atan2 and
/// select. double and float are such scalars; axode/scalar/ has more.
namespace axode {

using std::abs;
using std::atan2;
using std::cos;
using std::sin;
using std::sqrt;

/// `a` where the condition holds, else `b`; both are evaluated, so that no kernel branches on a scalar.
template <std::floating_point T> constexpr T select(bool condition, T a, T b) { return condition ? a : b; }

/// The relative size of what rounding leaves of a number; every scalar has its own.
template <class T> inline constexpr double unit_roundoff = std::numeric_limits<T>::epsilon();

}  // namespace axode
