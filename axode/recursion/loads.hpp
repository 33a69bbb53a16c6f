#pragma once
#include <span>

#include "axode/lie/twist.hpp"

namespace axode {

/// A wrench applied to a frame: moment m in N m and force f in N. Its representation says where they are
/// given: in the axes of the frame about its origin (BodyFixed); in inertial axes about the inertial origin
/// (Spatial) or about the origin of the frame (Hybrid); or with the moment in the axes of the frame and the
/// force in inertial axes (Mixed). Its power along the twist of the frame enters the system.
template <class T = double> struct AppliedWrench {
  int frame;
  Representation representation;
  Vec3<T> m, f;

  template <class Rep>
  constexpr AppliedWrench(int on_frame, const Wrench<Rep, T>& W)
      : frame(on_frame), representation(value_of(Rep{})), m(W.m), f(W.f) {}
  constexpr AppliedWrench(int on_frame, Representation in, const Vec3<T>& moment, const Vec3<T>& force)
      : frame(on_frame), representation(in), m(moment), f(force) {}

 private:
  static constexpr Representation value_of(BodyFixed) { return Representation::body; }
  static constexpr Representation value_of(Spatial) { return Representation::spatial; }
  static constexpr Representation value_of(Hybrid) { return Representation::hybrid; }
  static constexpr Representation value_of(Mixed) { return Representation::mixed; }
};

/// Loads on a system, which act in addition to drives and gravity.
template <class T = double> struct Loads {
  std::span<const AppliedWrench<T>> wrenches = {};
  /// Whether the losses of joints act: damping (proportional to v), Coulomb friction (with the sign of v) and
  /// the losses of gears (D9.8).
  bool joint_losses = false;
};

}  // namespace axode
