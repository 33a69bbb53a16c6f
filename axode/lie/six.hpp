#pragma once
#include <array>

#include "axode/lie/twist.hpp"

namespace axode {

/// Component k of a vector, k = 0, 1, 2.
template <class T> constexpr T& entry(Vec3<T>& a, int k) { return k == 0 ? a.x : k == 1 ? a.y : a.z; }
template <class T> constexpr const T& entry(const Vec3<T>& a, int k) {
  return k == 0 ? a.x : k == 1 ? a.y : a.z;
}

/// Component k of a twist, twist rate, wrench or momentum, angular before linear, k = 0 to 5.
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr T& entry(Kind<Rep, T>& x, int k) {
  auto& [a, b] = x;
  return k < 3 ? entry(a, k) : entry(b, k - 3);
}
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
constexpr const T& entry(const Kind<Rep, T>& x, int k) {
  const auto& [a, b] = x;
  return k < 3 ? entry(a, k) : entry(b, k - 3);
}

/// The six coordinates of a screw or wrench, angular before linear.
template <class T> using Six = std::array<T, 6>;
template <class T> constexpr Six<T> six(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x, a.y, a.z, b.x, b.y, b.z};
}

/// A 6×6 matrix that maps twists to wrenches, stored by its columns.
template <class Rep, class T> struct TwistToWrench {
  std::array<Wrench<Rep, T>, 6> column;

  /// The matrix of a linear map f from twists to wrenches.
  template <class Map> static TwistToWrench of(const Map& f) {
    const Vec3<T> x{T(1), T(0), T(0)}, y{T(0), T(1), T(0)}, z{T(0), T(0), T(1)}, o;
    using V = Twist<Rep, T>;
    return {{f(V{x, o}), f(V{y, o}), f(V{z, o}), f(V{o, x}), f(V{o, y}), f(V{o, z})}};
  }
  TwistToWrench& operator+=(const TwistToWrench& other) {
    for (std::size_t k = 0; k < 6; ++k) column[k] += other.column[k];
    return *this;
  }
  Wrench<Rep, T> operator*(const Twist<Rep, T>& X) const {
    return X.w.x * column[0] + X.w.y * column[1] + X.w.z * column[2] + X.v.x * column[3] + X.v.y * column[4] +
           X.v.z * column[5];
  }
  /// The wrench Aᵀ X for this matrix A.
  Wrench<Rep, T> transposed_times(const Twist<Rep, T>& X) const {
    return {{column[0] | X, column[1] | X, column[2] | X}, {column[3] | X, column[4] | X, column[5] | X}};
  }
};

}  // namespace axode
