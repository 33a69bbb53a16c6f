#pragma once
#include "axode/lie/twist.hpp"

/// change<To>(C, x) converts the twist, wrench or momentum x of a body with pose C to the representation To
/// (Müller, eqs. VhVb, VsVb, Vmbhs). change<To>(C, V, V') converts the rate V' of the components of the twist
/// V, and needs V for this. Both convert to the body-fixed representation first.
namespace axode {

/// Two moving frames F_j and F_k, for twists ^kV^j, which are measured at the origin of F_j and resolved in
/// the axes of F_k. All vectors of this struct are in inertial axes. ^kV^j is the spatial twist if both are
/// the inertial frame, the body-fixed one if both are the body frame, and the hybrid one if F_j is the body
/// and F_k the inertial frame.
template <class T = double> struct FramePair {
  Vec3<T> r_j;   ///< position of the origin of F_j, m
  Vec3<T> dr_j;  ///< velocity of the origin of F_j, m/s
  SO3<T> R_k;    ///< rotation of F_k
  Vec3<T> w_k;   ///< angular velocity of F_k, rad/s
  /// The pose with the axes of F_k and the origin of F_j.
  constexpr SE3<T> pose() const { return {R_k, r_j}; }
};

namespace detail {

template <class Rep> struct Change;  // changes from body-fixed to Rep (to) and back (from)

template <> struct Change<BodyFixed> {
  template <class T> static constexpr Twist<BodyFixed, T> to(const SE3<T>&, const Twist<BodyFixed, T>& V) {
    return V;
  }
  template <class T> static constexpr Twist<BodyFixed, T> from(const SE3<T>&, const Twist<BodyFixed, T>& V) {
    return V;
  }
  template <class T>
  static constexpr TwistRate<BodyFixed, T> to(const SE3<T>&, const Twist<BodyFixed, T>&,
                                              const TwistRate<BodyFixed, T>& dV) {
    return dV;
  }
  template <class T>
  static constexpr TwistRate<BodyFixed, T> from(const SE3<T>&, const Twist<BodyFixed, T>&,
                                                const TwistRate<BodyFixed, T>& dV) {
    return dV;
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<BodyFixed, T> coscrew_to(const SE3<T>&, const CoScrew<BodyFixed, T>& W) {
    return W;
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<BodyFixed, T> coscrew_from(const SE3<T>&, const CoScrew<BodyFixed, T>& W) {
    return W;
  }
};

template <> struct Change<Spatial> {
  template <class T> static constexpr Twist<Spatial, T> to(const SE3<T>& C, const Twist<BodyFixed, T>& V) {
    return Ad(C, V);
  }
  template <class T> static constexpr Twist<BodyFixed, T> from(const SE3<T>& C, const Twist<Spatial, T>& V) {
    return Ad_inv(C, V);
  }
  template <class T>
  static constexpr TwistRate<Spatial, T> to(const SE3<T>& C, const Twist<BodyFixed, T>&,
                                            const TwistRate<BodyFixed, T>& dV) {
    const Screw<T> X = Ad(C, Screw<T>{dV.w, dV.v});  // ad_V V = 0
    return {X.w, X.v};
  }
  template <class T>
  static constexpr TwistRate<BodyFixed, T> from(const SE3<T>& C, const Twist<BodyFixed, T>&,
                                                const TwistRate<Spatial, T>& dV) {
    const Screw<T> X = Ad_inv(C, Screw<T>{dV.w, dV.v});
    return {X.w, X.v};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<Spatial, T> coscrew_to(const SE3<T>& C, const CoScrew<BodyFixed, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::transformation);
    const auto& [m, f] = W;
    const Vec3<T> f_s = C.R * f;
    return {C.R * m + cross(C.r, f_s), f_s};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<BodyFixed, T> coscrew_from(const SE3<T>& C, const CoScrew<Spatial, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::transformation);
    const auto& [m, f] = W;
    const SO3<T> Rt = transpose(C.R);
    return {Rt * (m - cross(C.r, f)), Rt * f};
  }
};

template <> struct Change<Hybrid> {
  template <class T> static constexpr Twist<Hybrid, T> to(const SE3<T>& C, const Twist<BodyFixed, T>& V) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {C.R * V.w, C.R * V.v};
  }
  template <class T> static constexpr Twist<BodyFixed, T> from(const SE3<T>& C, const Twist<Hybrid, T>& V) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const SO3<T> Rt = transpose(C.R);
    return {Rt * V.w, Rt * V.v};
  }
  template <class T>
  static constexpr TwistRate<Hybrid, T> to(const SE3<T>& C, const Twist<BodyFixed, T>& V,
                                           const TwistRate<BodyFixed, T>& dV) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {C.R * dV.w, C.R * (dV.v + cross(V.w, V.v))};
  }
  template <class T>
  static constexpr TwistRate<BodyFixed, T> from(const SE3<T>& C, const Twist<BodyFixed, T>& V,
                                                const TwistRate<Hybrid, T>& dV) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const SO3<T> Rt = transpose(C.R);
    return {Rt * dV.w, Rt * dV.v - cross(V.w, V.v)};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<Hybrid, T> coscrew_to(const SE3<T>& C, const CoScrew<BodyFixed, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const auto& [m, f] = W;
    return {C.R * m, C.R * f};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<BodyFixed, T> coscrew_from(const SE3<T>& C, const CoScrew<Hybrid, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const auto& [m, f] = W;
    const SO3<T> Rt = transpose(C.R);
    return {Rt * m, Rt * f};
  }
};

template <> struct Change<Mixed> {
  template <class T> static constexpr Twist<Mixed, T> to(const SE3<T>& C, const Twist<BodyFixed, T>& V) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {V.w, C.R * V.v};
  }
  template <class T> static constexpr Twist<BodyFixed, T> from(const SE3<T>& C, const Twist<Mixed, T>& V) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {V.w, transpose(C.R) * V.v};
  }
  template <class T>
  static constexpr TwistRate<Mixed, T> to(const SE3<T>& C, const Twist<BodyFixed, T>& V,
                                          const TwistRate<BodyFixed, T>& dV) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {dV.w, C.R * (dV.v + cross(V.w, V.v))};
  }
  template <class T>
  static constexpr TwistRate<BodyFixed, T> from(const SE3<T>& C, const Twist<BodyFixed, T>& V,
                                                const TwistRate<Mixed, T>& dV) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    return {dV.w, transpose(C.R) * dV.v - cross(V.w, V.v)};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<Mixed, T> coscrew_to(const SE3<T>& C, const CoScrew<BodyFixed, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const auto& [m, f] = W;
    return {m, C.R * f};
  }
  template <template <class, class> class CoScrew, class T>
  static constexpr CoScrew<BodyFixed, T> coscrew_from(const SE3<T>& C, const CoScrew<Mixed, T>& W) {
    const ScrewOperationScope<T> scope(ScrewOperation::rotation);
    const auto& [m, f] = W;
    return {m, transpose(C.R) * f};
  }
};

}  // namespace detail

/// The twist V of a body with pose C, in the representation To.
template <class To, class From, class T>
constexpr Twist<To, T> change(const SE3<T>& C, const Twist<From, T>& V) {
  return detail::Change<To>::to(C, detail::Change<From>::from(C, V));
}
/// The rate V' of the twist V of a body with pose C, in the representation To.
template <class To, class From, class T>
constexpr TwistRate<To, T> change(const SE3<T>& C, const Twist<From, T>& V, const TwistRate<From, T>& dV) {
  const Twist<BodyFixed, T> V_b = detail::Change<From>::from(C, V);
  return detail::Change<To>::to(C, V_b, detail::Change<From>::from(C, V_b, dV));
}
/// The wrench W on a body with pose C, in the representation To. The power W | V does not change.
template <class To, class From, class T>
constexpr Wrench<To, T> change(const SE3<T>& C, const Wrench<From, T>& W) {
  return detail::Change<To>::coscrew_to(C, detail::Change<From>::coscrew_from(C, W));
}
/// The momentum Π of a body with pose C, in the representation To.
template <class To, class From, class T>
constexpr Momentum<To, T> change(const SE3<T>& C, const Momentum<From, T>& Pi) {
  return detail::Change<To>::coscrew_to(C, detail::Change<From>::coscrew_from(C, Pi));
}

/// ^kV_i^j, the twist measured at F_j and resolved in F_k, from the spatial twist V.
template <class T> constexpr Twist<InFrames, T> change(const FramePair<T>& jk, const Twist<Spatial, T>& V) {
  const Screw<T> X = Ad_inv(jk.pose(), screw(V));
  return {X.w, X.v};
}
/// The spatial twist from the twist V measured at F_j and resolved in F_k.
template <class T> constexpr Twist<Spatial, T> change(const FramePair<T>& jk, const Twist<InFrames, T>& V) {
  return twist<Spatial>(Ad(jk.pose(), Screw<T>{V.w, V.v}));
}
/// The rate of the twist ^kV_i^j of a body, measured at the origin of F_j and resolved in the axes of F_k,
/// both of which may move, from its spatial twist V and the rate of V (Müller, eq. inl:jVdot from kVdot with
/// erratum 19 of docs/errata.md).
template <class T>
constexpr TwistRate<InFrames, T> change(const FramePair<T>& jk, const Twist<Spatial, T>& V,
                                        const TwistRate<Spatial, T>& dV) {
  const SO3<T> Rt = transpose(jk.R_k);
  const Vec3<T> v_j = V.v + cross(V.w, jk.r_j);
  const Vec3<T> dv_j = dV.v + cross(dV.w, jk.r_j) + cross(V.w, jk.dr_j);
  return {Rt * (dV.w - cross(jk.w_k, V.w)), Rt * (dv_j - cross(jk.w_k, v_j))};
}
/// The rate of the spatial twist from the twist V measured at F_j and resolved in F_k and the rate of V.
template <class T>
constexpr TwistRate<Spatial, T> change(const FramePair<T>& jk, const Twist<InFrames, T>& V,
                                       const TwistRate<InFrames, T>& dV) {
  const Vec3<T> w = jk.R_k * V.w, v_j = jk.R_k * V.v;
  const Vec3<T> dw = jk.R_k * dV.w + cross(jk.w_k, w);
  const Vec3<T> dv_j = jk.R_k * dV.v + cross(jk.w_k, v_j);
  return {dw, dv_j - cross(dw, jk.r_j) - cross(w, jk.dr_j)};
}
/// The wrench measured at F_j and resolved in F_k, from the spatial wrench W.
template <class T> constexpr Wrench<InFrames, T> change(const FramePair<T>& jk, const Wrench<Spatial, T>& W) {
  const Wrench<BodyFixed, T> W_jk = coAd_inv(jk.pose(), W);
  return {W_jk.m, W_jk.f};
}
/// The spatial wrench from the wrench W measured at F_j and resolved in F_k.
template <class T> constexpr Wrench<Spatial, T> change(const FramePair<T>& jk, const Wrench<InFrames, T>& W) {
  return coAd(jk.pose(), Wrench<BodyFixed, T>{W.m, W.f});
}
/// The momentum measured at F_j and resolved in F_k, from the spatial momentum Π.
template <class T>
constexpr Momentum<InFrames, T> change(const FramePair<T>& jk, const Momentum<Spatial, T>& Pi) {
  const auto Pi_jk = detail::Change<Spatial>::coscrew_from(jk.pose(), Pi);
  return {Pi_jk.l, Pi_jk.p};
}
/// The spatial momentum from the momentum Π measured at F_j and resolved in F_k.
template <class T>
constexpr Momentum<Spatial, T> change(const FramePair<T>& jk, const Momentum<InFrames, T>& Pi) {
  return detail::Change<Spatial>::coscrew_to(jk.pose(), Momentum<BodyFixed, T>{Pi.l, Pi.p});
}

}  // namespace axode
