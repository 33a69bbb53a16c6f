#pragma once
#include "axode/lie/inertia.hpp"
#include "axode/lie/representation_change.hpp"

/// The Newton-Euler equations of one rigid body in all representations of its twist: the resultant wrench W
/// that gives a body with inertia M and twist V the acceleration V'. The body frame may be any frame that
/// moves with the body.
namespace axode {

/// The wrench -ad_Vᵀ M V that a body needs to keep its body-fixed or spatial twist V.
template <AtFrameOrigin Rep, class T>
constexpr Wrench<Rep, T> velocity_wrench(const Inertia<T>& M, const Twist<Rep, T>& V) {
  return coad(V, M * V);
}
/// The part ad_ω M (ω; 0) of the wrench in the hybrid Newton-Euler equations that is due to velocities: the
/// wrench that a body needs if the rate of its hybrid twist V is zero. ω is the angular velocity, and M is
/// the inertia about the origin of the body frame in inertial axes.
template <class T>
constexpr Wrench<Hybrid, T> velocity_wrench(const Inertia<T>& M, const Twist<Hybrid, T>& V) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  const Momentum<Hybrid, T> Pi = M * Twist<Hybrid, T>{V.w, {}};
  return {cross(V.w, Pi.l), cross(V.w, Pi.p)};
}
/// The wrench that a body with rotation R needs to keep its mixed twist V; M is in the body frame.
template <class T>
constexpr Wrench<Mixed, T> velocity_wrench(const Inertia<T>& M, const SO3<T>& R, const Twist<Mixed, T>& V) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {cross(V.w, M.Theta * V.w), R * cross(V.w, cross(V.w, M.h))};
}

/// The Newton-Euler equations. In body-fixed and spatial twists W = M V' - ad_Vᵀ M V (Müller, eqs. NEs, NEb,
/// NEb0), with the inertia M of the body in the frame of V. In hybrid twists W^h = M^h V'^h + ad_ω M^h (ω; 0)
/// (Müller, eqs. NEh, NEh0), with the angular velocity ω and the inertia M^h = Ad_R⁻ᵀ M^b Ad_R⁻¹ in inertial
/// axes.
template <class Rep, class T>
  requires(AtFrameOrigin<Rep> || std::same_as<Rep, Hybrid>)
constexpr Wrench<Rep, T> newton_euler(const Inertia<T>& M, const Twist<Rep, T>& V,
                                      const TwistRate<Rep, T>& dV) {
  return M * dV + velocity_wrench(M, V);
}

/// The Newton-Euler equations in mixed representation: moments and angular velocities are in body axes,
/// forces and linear velocities in inertial axes (Müller, eqs. NEm rot, NEm trans, NEcmixed). M is the
/// inertia of the body in the body frame, whose origin may be any point of the body, and R is the rotation of
/// the body frame.
template <class T>
constexpr Wrench<Mixed, T> newton_euler(const Inertia<T>& M, const SO3<T>& R, const Twist<Mixed, T>& V,
                                        const TwistRate<Mixed, T>& dV) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {M.Theta * dV.w + cross(V.w, M.Theta * V.w) + cross(M.h, transpose(R) * dV.v),
          M.m * dV.v + R * (cross(dV.w, M.h) + cross(V.w, cross(V.w, M.h)))};
}

/// The Newton-Euler equations about the centre of mass (Müller, eqs. NEb0, NEhCOM, NEhCOM2 with erratum 15 of
/// docs/errata.md, NEcmixed). Euler's equation for the moment does not contain the linear motion, and
/// Newton's equation for the force does not contain the inertia tensor.
template <class T>
constexpr Wrench<BodyFixed, T> newton_euler(const CentralInertia<T>& M, const Twist<BodyFixed, T>& V,
                                            const TwistRate<BodyFixed, T>& dV) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {M.Theta * dV.w + cross(V.w, M.Theta * V.w), M.m * (dV.v + cross(V.w, V.v))};
}
template <class T>
constexpr Wrench<Hybrid, T> newton_euler(const CentralInertia<T>& M, const Twist<Hybrid, T>& V,
                                         const TwistRate<Hybrid, T>& dV) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {M.Theta * dV.w + cross(V.w, M.Theta * V.w), M.m * dV.v};
}
template <class T>
constexpr Wrench<Mixed, T> newton_euler(const CentralInertia<T>& M, const SO3<T>&, const Twist<Mixed, T>& V,
                                        const TwistRate<Mixed, T>& dV) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  return {M.Theta * dV.w + cross(V.w, M.Theta * V.w), M.m * dV.v};
}

/// The Newton-Euler equations for twists that are measured at the origin of a frame F_j and resolved in the
/// axes of a frame F_k (Müller, eq. NEij, and eq. u:NE (j,k) boxed with erratum 19 of docs/errata.md): W = M
/// (V' + (ad_{V_j} + ad_{ω_k - ω_j}) V) - ad_Vᵀ M V, with the inertia M = ^kM_i^j about the origin of F_j in
/// the axes of F_k, the twist V_j of F_j, and the angular velocities ω_j and ω_k of the frames. Of the motion
/// of the frames the equations need only the velocity of the origin of F_j and the angular velocity of F_k.
template <class T>
constexpr Wrench<InFrames, T> newton_euler(const Inertia<T>& M, const FramePair<T>& jk,
                                           const Twist<InFrames, T>& V, const TwistRate<InFrames, T>& dV) {
  const SO3<T> Rt = transpose(jk.R_k);
  const Screw<T> moved = ad(Screw<T>{Rt * jk.w_k, Rt * jk.dr_j}, Screw<T>{V.w, V.v});
  const Momentum<InFrames, T> Pi = M * V;
  return M * TwistRate<InFrames, T>{dV.w + moved.w, dV.v + moved.v} +
         Wrench<InFrames, T>{cross(V.w, Pi.l) + cross(V.v, Pi.p), cross(V.w, Pi.p)};
}

/// ^kM_i^j: the inertia of a body with pose C, about the origin of a frame F_j and in the axes of a frame F_k
/// (Müller, eq. u:kMij with erratum 20 of docs/errata.md). M is the inertia in the body frame.
template <class T>
constexpr Inertia<T> inertia_in_frames(const FramePair<T>& jk, const SE3<T>& C, const Inertia<T>& M) {
  return transform(inverse(jk.pose()) * C, M);
}

/// The resultant wrench on a body from its twist V and the rate V' of the components of V, by the
/// Newton-Euler equations. V, V' and the wrench are in the representation Rep: body-fixed, spatial, hybrid or
/// mixed. M is the inertia of the body in the body frame, and C is the pose of the body frame relative to the
/// inertial frame.
template <class Rep, class T>
constexpr Wrench<Rep, T> wrench(const SE3<T>& C, const Inertia<T>& M, const Twist<Rep, T>& V,
                                const TwistRate<Rep, T>& dV) {
  if constexpr (std::same_as<Rep, BodyFixed>)
    return newton_euler(M, V, dV);
  else if constexpr (std::same_as<Rep, Spatial>)
    return newton_euler(transform(C, M), V, dV);
  else if constexpr (std::same_as<Rep, Hybrid>)
    return newton_euler(transform(C.R, M), V, dV);
  else
    return newton_euler(M, C.R, V, dV);
}
/// The resultant wrench on a body from its twist V and the rate V' of the components of V, all measured at
/// the origin of a frame F_j and resolved in the axes of a frame F_k. Both frames may move. `jk` has the
/// position and velocity of the origin of F_j, and the rotation and angular velocity of F_k, all relative to
/// the inertial frame and in inertial axes. The body has the pose C relative to the inertial frame, and M is
/// its inertia in the body frame.
template <class T>
constexpr Wrench<InFrames, T> wrench(const SE3<T>& C, const Inertia<T>& M, const FramePair<T>& jk,
                                     const Twist<InFrames, T>& V, const TwistRate<InFrames, T>& dV) {
  return newton_euler(inertia_in_frames(jk, C, M), jk, V, dV);
}

/// A⁻¹ of a symmetric tensor, the adjugate divided by the determinant. A must not be singular.
template <class T> constexpr Sym3<T> inverse(const Sym3<T>& A) {
  const T xx = A.yy * A.zz - A.yz * A.yz, xy = A.xz * A.yz - A.xy * A.zz, xz = A.xy * A.yz - A.xz * A.yy;
  const T i = T(1) / (A.xx * xx + A.xy * xy + A.xz * xz);
  return {i * xx, i * (A.xx * A.zz - A.xz * A.xz), i * (A.xx * A.yy - A.xy * A.xy), i * xy,
          i * xz, i * (A.xy * A.xz - A.xx * A.yz)};
}

/// Solves M V' = W for the rate V' of a twist, where W is the resultant wrench minus the velocity-dependent
/// terms of the Newton-Euler equations. The equations are solved about the centre of mass. The mass and the
/// rotational inertia about the centre of mass must not be singular.
template <class Rep, class T>
constexpr TwistRate<Rep, T> solve(const Inertia<T>& M, const Wrench<Rep, T>& W) {
  static_assert(!std::same_as<Rep, Mixed>, "the mixed inertia matrix has blocks in different axes");
  const Vec3<T> c = center_of_mass(M), dw = inverse(inertia_about_com(M)) * (W.m - cross(c, W.f));
  return {dw, (T(1) / M.m) * W.f - cross(dw, c)};
}

/// The rate V' of the components of the twist V of a body under the resultant wrench W, by the Newton-Euler
/// equations. V, V' and W are in the representation Rep: body-fixed, spatial, hybrid or mixed. M is the
/// inertia of the body in the body frame, and C is the pose of the body frame relative to the inertial frame.
template <class Rep, class T>
constexpr TwistRate<Rep, T> acceleration(const SE3<T>& C, const Inertia<T>& M, const Twist<Rep, T>& V,
                                         const Wrench<Rep, T>& W) {
  const Twist<BodyFixed, T> V_b = change<BodyFixed>(C, V);
  return change<Rep>(C, V_b, solve(M, change<BodyFixed>(C, W) - coad(V_b, M * V_b)));
}
/// The rate V' of the components of the twist V of a body under the resultant wrench W, all measured at the
/// origin of a frame F_j and resolved in the axes of a frame F_k. Both frames may move. `jk` has the position
/// and velocity of the origin of F_j, and the rotation and angular velocity of F_k, all relative to the
/// inertial frame and in inertial axes. The body has the pose C relative to the inertial frame, and M is its
/// inertia in the body frame.
template <class T>
constexpr TwistRate<InFrames, T> acceleration(const SE3<T>& C, const Inertia<T>& M, const FramePair<T>& jk,
                                              const Twist<InFrames, T>& V, const Wrench<InFrames, T>& W) {
  const Twist<Spatial, T> V_s = change(jk, V);
  return change(jk, V_s, acceleration(C, M, V_s, change(jk, W)));
}

}  // namespace axode
