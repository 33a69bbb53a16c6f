#pragma once
#include "axode/constraints/loops/loop_frames.hpp"

namespace axode::loops {

/// A massless rod with ball joints at its ends, which are the origins of the two frames of the loop joint. It
/// has one equation, whose constraint wrench is a force along the rod.
struct Rod {
  double length = 0;  ///< length of the rod, m

  static constexpr int rows() { return 1; }
  static constexpr int residuals() { return 1; }

  template <class T> void residual(const LoopFrames<T>& at, T* r) const {
    r[0] = norm(at.b.r - at.a.r) - T(length);
  }
  template <class T> void wrenches(const LoopFrames<T>& at, SpatialWrench<T>* W) const {
    const Vec3<T> d = at.b.r - at.a.r;
    W[0] = force_at(at.b.r, (T(1) / norm(d)) * d);
  }
  template <class T>
  void wrench_rates(const LoopFrames<T>& at, const EndMotion<T>& m, SpatialWrench<T>* dW) const {
    const Vec3<T> d = at.b.r - at.a.r, dp = velocity(m.V_j, at.b.r), slip = dp - velocity(m.V_i, at.a.r);
    const T inverse_distance = T(1) / norm(d);
    const Vec3<T> u = inverse_distance * d, du = inverse_distance * (slip - dot(u, slip) * u);
    dW[0] = force_rate(at.b.r, dp, u, du);
  }
};

}  // namespace axode::loops
