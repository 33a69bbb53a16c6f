#pragma once
#include "axode/lie.hpp"
#include "axode/scalar/taylor.hpp"

/// Derivatives of functions of screws along a line, by Taylor series.
namespace axode::test {

/// A + t B, whose functions carry their derivative at t = 0.
template <class T> using Line = Taylor<T, 2>;
template <class T> Vec3<Line<T>> line(const Vec3<T>& a, const Vec3<T>& b) {
  return {Line<T>({a.x, b.x}), Line<T>({a.y, b.y}), Line<T>({a.z, b.z})};
}
template <class T> Screw<Line<T>> line(const Screw<T>& A, const Screw<T>& B) {
  return {line(A.w, B.w), line(A.v, B.v)};
}
template <class T> Vec3<T> slope(const Vec3<Line<T>>& a) { return {a.x.c[1], a.y.c[1], a.z.c[1]}; }
template <class T> Screw<T> slope(const Screw<Line<T>>& A) { return {slope(A.w), slope(A.v)}; }
template <class T> SE3<T> slope(const SE3<Line<T>>& C) {
  return {{slope(C.R.x), slope(C.R.y), slope(C.R.z)}, slope(C.r)};
}
/// dC C⁻¹ as a screw; for the tangent dC of a curve of poses.
template <class T> Screw<T> right_trivialised(const SE3<T>& dC, const SE3<T>& C) {
  const SO3<T> w = dC.R * transpose(C.R);
  return {{w.y.z, w.z.x, w.x.y}, dC.r - w * C.r};
}

}  // namespace axode::test
