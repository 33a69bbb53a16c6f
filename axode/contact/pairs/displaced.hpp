#pragma once
#include <Eigen/Core>

#include "axode/lie/se3.hpp"
#include "axode/scalar/dual.hpp"

/// Number type for the automatic differentiation of contact points by the displacement of one body relative
/// to the other.
namespace axode {

/// A number and its derivatives along the six components of the displacement of a body.
using Displaced = Dual<double, 6>;

inline double value(double x) { return x; }
inline double value(const Displaced& x) { return x.x; }
template <class T> Vec3<> value(const Vec3<T>& a) { return {value(a.x), value(a.y), value(a.z)}; }
template <class T> SO3<> value(const SO3<T>& R) { return {value(R.x), value(R.y), value(R.z)}; }
template <class T> SE3<> value(const SE3<T>& C) { return {value(C.R), value(C.r)}; }

inline Eigen::Matrix<double, 1, 6> derivatives(const Displaced& x) {
  return Eigen::Map<const Eigen::Matrix<double, 1, 6>>(x.dx.data());
}
inline Eigen::Matrix<double, 3, 6> derivatives(const Vec3<Displaced>& a) {
  Eigen::Matrix<double, 3, 6> out;
  out << derivatives(a.x), derivatives(a.y), derivatives(a.z);
  return out;
}

/// The length of a vector; at the vector 0 the derivatives of the length are set to 0 instead of NaN.
template <class T> T length(const Vec3<T>& a) {
  const T square = dot(a, a);
  return square > T(0) ? sqrt(square) : T(0);
}

}  // namespace axode
