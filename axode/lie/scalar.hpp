#pragma once
#include <cmath>
#include <concepts>
#include <limits>

/// Functions by which this library computes with any type T of numbers that has + - * /, sqrt, sin, cos,
/// atan2 and select. double and float are such types; axode/scalar/ has more.
namespace axode {

using std::abs;
using std::atan2;
using std::cos;
using std::sin;
using std::sqrt;

/// `a` if the condition holds, else `b`. Both are evaluated, so that no kernel branches on a scalar.
template <std::floating_point T> constexpr T select(bool condition, T a, T b) { return condition ? a : b; }

/// The relative rounding error of a number (machine epsilon). Every scalar type specialises this constant.
template <class T> inline constexpr double unit_roundoff = std::numeric_limits<T>::epsilon();

}  // namespace axode
