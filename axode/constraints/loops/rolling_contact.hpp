#pragma once
#include "axode/constraints/loops/loop_frames.hpp"

namespace axode::loops {

/// A sphere or a wheel on the second body that rolls without slip on a plane of the first body. z of the
/// first frame is the normal of the plane, and z of the second frame the axis of the wheel. There are three
/// equations. The equation along the normal has a residual, the distance from the plane; the two tangential
/// equations constrain velocities but have no residual.
struct RollingContact {
  double radius = 0;  ///< radius of the sphere or wheel, m
  bool wheel = false;

  static constexpr int rows() { return 3; }
  static constexpr int residuals() { return 1; }

  template <class T> void residual(const LoopFrames<T>& at, T* r) const {
    r[0] = dot(at.a.R.z, contact(at).p - at.a.r);
  }
  template <class T> void wrenches(const LoopFrames<T>& at, SpatialWrench<T>* W) const {
    const Vec3<T> p = contact(at).p;
    for (const Vec3<T>* e : {&at.a.R.z, &at.a.R.x, &at.a.R.y}) *W++ = force_at(p, *e);
  }
  /// Computes the time derivatives of the constraint wrenches of a sphere or wheel that rolls on a plane.
  /// They are not 0, because the contact point moves along the plane and along the surface of the sphere
  /// or the rim of the wheel. (D6.9) gives the rate d' of the unit vector d from the contact point to the
  /// centre of the sphere or wheel.
  template <class T>
  void wrench_rates(const LoopFrames<T>& at, const EndMotion<T>& m, SpatialWrench<T>* dW) const {
    const Vec3<T>&n = at.a.R.z, &k = at.b.R.z;
    const Vec3<T> dn = cross(m.V_i.w, n), dk = cross(m.V_j.w, k);
    const Contact<T> c = contact(at);
    Vec3<T> dd = dn;
    if (wheel) {
      const Vec3<T> dy = dn - dot(k, n) * dk - (dot(dk, n) + dot(k, dn)) * k;
      dd = (T(1) / norm(c.y)) * (dy - dot(c.d, dy) * c.d);
    }
    const Vec3<T> dp = velocity(m.V_j, at.b.r) - T(radius) * dd;
    for (const Vec3<T>* e : {&at.a.R.z, &at.a.R.x, &at.a.R.y})
      *dW++ = force_rate(c.p, dp, *e, cross(m.V_i.w, *e));
  }

 private:
  /// The contact point p, the unit vector d from p to the centre of the sphere or wheel, and y, the normal
  /// of the plane without its component along the axis of a wheel. y is a multiple of d.
  template <class T> struct Contact { Vec3<T> d, p, y; };
  template <class T> Contact<T> contact(const LoopFrames<T>& at) const {
    const Vec3<T>&n = at.a.R.z, &k = at.b.R.z;
    if (!wheel) return {n, at.b.r - T(radius) * n, n};
    const Vec3<T> y = n - dot(k, n) * k, d = (T(1) / norm(y)) * y;
    return {d, at.b.r - T(radius) * d, y};
  }
};

}  // namespace axode::loops
