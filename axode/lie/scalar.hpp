#pragma once
#include <cmath>
#include <concepts>
#include <limits>

/// The functions of numbers that this library uses. Its algorithms accept every number type T that has + - *
/// /, sqrt, sin, cos, atan2 and select(condition, a, b). Such types are double, float and the types of
/// axode/scalar/.
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
