#pragma once
#include "axode/constraints/loops/subgroup_closure.hpp"

namespace axode::loops {

/// A universal joint: the axes z of the two frames intersect at a constant angle. Its wrenches are the three
/// forces of a ball joint and one couple perpendicular to both axes.
struct Universal {
  double cosine = 0;  ///< cosine of the angle between the axes
  static constexpr SubgroupClosure ball{{true, true, true}};

  static constexpr int rows() { return 4; }
  static constexpr int residuals() { return 4; }

  template <class T> void residual(const LoopFrames<T>& at, T* r) const {
    ball.residual(at, r);
    r[3] = (T(cosine) - dot(at.a.R.z, at.b.R.z)) / sine<T>();
  }
  template <class T> void wrenches(const LoopFrames<T>& at, SpatialWrench<T>* W) const {
    ball.wrenches(at, W);
    W[3] = couple(at);
  }
  template <class T> void residual_wrenches(const LoopFrames<T>& at, SpatialWrench<T>* R) const {
    ball.residual_wrenches(at, R);
    R[3] = couple(at);
  }
  template <class T>
  void bias(const LoopFrames<T>& at, const SpatialWrench<T>* W, const EndMotion<T>& m, T* gamma) const {
    ball.bias(at, W, m, gamma);
    const Vec3<T>&x = at.a.R.z, &y = at.b.R.z;
    const Vec3<T> dm = cross(cross(m.V_i.w, x), y) + cross(x, cross(m.V_j.w, y));
    gamma[3] = power(W[3], m.dV_j - m.dV_i) + dot(dm, m.V_j.w - m.V_i.w) / sine<T>();
  }

 private:
  template <class T> T sine() const { return sqrt(T(1) - T(cosine) * T(cosine)); }
  template <class T> SpatialWrench<T> couple(const LoopFrames<T>& at) const {
    return {(T(1) / sine<T>()) * cross(at.a.R.z, at.b.R.z), {}};
  }
};

}  // namespace axode::loops
