#pragma once
#include <array>

#include "axode/lie/twist.hpp"
#include "axode/scalar/dual.hpp"

/// The interface of the types of loop joints. Their members are templates over the scalar. The argument
/// `at` has the frames of the joint on its first body i and on its second body j. The argument m has the
/// twists V_i and V_j of these bodies and the rates V'_i and V'_j of the twists. A is the Jacobian of the
/// loop equations, r is the residual of the loop, and W are the constraint wrenches on the second body for
/// unit multipliers:
///   rows(), residuals()            numbers of equations A v = 0 and of residuals r
///   residual(at, r)                computes r, which vanishes if the loop is closed
///   wrenches(at, W)                computes W, with A v = Wᵀ (V_j - V_i)
/// The following members are optional:
///   residual_wrenches(at, R)       computes R with r' = Rᵀ (V_j - V_i); by default the first columns of W
///   wrench_rates(at, m, dW)        computes W' for moving bodies; by default W is evaluated on dual numbers
///   bias(at, W, m, gamma)          computes γ = Wᵀ (V'_j - V'_i) + W'ᵀ (V_j - V_i)
/// A, γ and r are the same in all representations. For multipliers λ, the wrench W λ acts on the second
/// body, and -W λ on the first body.
namespace axode::loops {

template <class T> using SpatialWrench = Wrench<Spatial, T>;
template <class T> using LoopWrenches = std::array<SpatialWrench<T>, 6>;

/// The frames of a loop joint on its first body (a) and its second body (b), in inertial axes, with origins
/// relative to a point O that is fixed in space.
template <class T> struct LoopFrames { SE3<T> a, b; };
/// The twists of the two bodies of a loop joint in inertial axes about a point O that is fixed in space, the
/// same for both bodies, and the rates of these twists. Joint accelerations may be left out of the rates.
template <class T> struct EndMotion { Screw<T> V_i, V_j, dV_i, dV_j; };

template <class T> T power(const SpatialWrench<T>& W, const Screw<T>& X) {
  return dot(W.m, X.w) + dot(W.f, X.v);
}
template <class T> Vec3<T> velocity(const Screw<T>& V, const Vec3<T>& p) { return V.v + cross(V.w, p); }
/// The wrench of a force f at the point p, and its rate for the rates dp and df of p and f.
template <class T> SpatialWrench<T> force_at(const Vec3<T>& p, const Vec3<T>& f) { return {cross(p, f), f}; }
template <class T>
SpatialWrench<T> force_rate(const Vec3<T>& p, const Vec3<T>& dp, const Vec3<T>& f, const Vec3<T>& df) {
  return {cross(dp, f) + cross(p, df), df};
}

/// Make dual numbers of a vector, a screw or a pose and of its rate, which for a pose is a spatial twist.
template <class T> Vec3<Dual<T, 1>> lift(const Vec3<T>& x, const Vec3<T>& dx) {
  return {{x.x, {dx.x}}, {x.y, {dx.y}}, {x.z, {dx.z}}};
}
template <class T> Screw<Dual<T, 1>> lift(const Screw<T>& X, const Screw<T>& dX) {
  return {lift(X.w, dX.w), lift(X.v, dX.v)};
}
template <class T> SE3<Dual<T, 1>> lift(const SE3<T>& C, const Screw<T>& V) {
  const auto axis = [&](const Vec3<T>& e) { return lift(e, cross(V.w, e)); };
  return {{axis(C.R.x), axis(C.R.y), axis(C.R.z)}, lift(C.r, velocity(V, C.r))};
}
/// value_of() is the value of a wrench of dual numbers, and rate_of() is its derivative.
template <class T> SpatialWrench<T> value_of(const SpatialWrench<Dual<T, 1>>& W) {
  return {{W.m.x.x, W.m.y.x, W.m.z.x}, {W.f.x.x, W.f.y.x, W.f.z.x}};
}
template <class T> SpatialWrench<T> rate_of(const SpatialWrench<Dual<T, 1>>& W) {
  return {{W.m.x.dx[0], W.m.y.dx[0], W.m.z.dx[0]}, {W.f.x.dx[0], W.f.y.dx[0], W.f.z.dx[0]}};
}

template <class Joint, class T>
void residual_wrenches(const Joint& joint, const LoopFrames<T>& at, SpatialWrench<T>* R) {
  if constexpr (requires { joint.residual_wrenches(at, R); }) {
    joint.residual_wrenches(at, R);
  } else {
    joint.wrenches(at, R);
  }
}

template <class Joint, class T>
void wrench_rates(const Joint& joint, const LoopFrames<T>& at, const EndMotion<T>& m, SpatialWrench<T>* dW) {
  if constexpr (requires { joint.wrench_rates(at, m, dW); }) {
    joint.wrench_rates(at, m, dW);
  } else {
    LoopWrenches<Dual<T, 1>> W;
    joint.wrenches(LoopFrames<Dual<T, 1>>{lift(at.a, m.V_i), lift(at.b, m.V_j)}, W.data());
    for (std::size_t k = 0; k < static_cast<std::size_t>(joint.rows()); ++k) dW[k] = rate_of(W[k]);
  }
}

template <class Joint, class T>
void bias(const Joint& joint, const LoopFrames<T>& at, const SpatialWrench<T>* W, const EndMotion<T>& m,
          T* gamma) {
  if constexpr (requires { joint.bias(at, W, m, gamma); }) {
    joint.bias(at, W, m, gamma);
  } else {
    LoopWrenches<T> dW;
    wrench_rates(joint, at, m, dW.data());
    const Screw<T> X = m.V_j - m.V_i, dX = m.dV_j - m.dV_i;
    for (std::size_t k = 0; k < static_cast<std::size_t>(joint.rows()); ++k)
      gamma[k] = power(W[k], dX) + power(dW[k], X);
  }
}

}  // namespace axode::loops
