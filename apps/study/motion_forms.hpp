#pragma once
#include "axode/recursion/forward_kinematics.hpp"

/// Accelerations of all bodies in body-fixed and in hybrid twists, each by three equivalent recursions of A.
/// Müller's paper (see docs/notation.md). The three recursions differ only in the terms that depend on the
/// velocities. There are also recursions for the jerks of all bodies in body-fixed, spatial, hybrid and mixed
/// twists.
namespace axode::command {

/// The terms of V'_i = down V'_p + S a + bias in which the forms differ. U is down V_p.
template <class Rep, class T> struct BiasOf { Twist<Rep, T> V_p, U, V, Sv; };
template <class T> constexpr TwistRate<BodyFixed, T> rate_of(const Twist<BodyFixed, T>& X) {
  return {X.w, X.v};
}
/// The bracket [X, S v] of a hinge, whose S v = (0, 0, s; 0) is known to be sparse.
template <class T>
TwistRate<BodyFixed, T> bracket_with_hinge(const Twist<BodyFixed, T>& X, const Twist<BodyFixed, T>& Sv) {
  const ScrewOperationScope<T> scope(ScrewOperation::bracket);
  const T& s = Sv.w.z;
  return {{X.w.y * s, -(X.w.x * s), T(0)}, {X.v.y * s, -(X.v.x * s), T(0)}};
}

/// [Ad V_p, S v] (Müller, eq. arecVbi).
struct FormA {
  template <class T> static TwistRate<BodyFixed, T> bias(const BiasOf<BodyFixed, T>& of, bool) {
    return rate_of(ad(of.U, of.Sv));
  }
};
/// [Ad V_p, V_i] (Müller, eq. brecVbi).
struct FormB {
  template <class T> static TwistRate<BodyFixed, T> bias(const BiasOf<BodyFixed, T>& of, bool) {
    return rate_of(ad(of.U, of.V));
  }
};
/// [V_i, S v] (Müller, eq. crecVbi).
struct FormC {
  template <class T> static TwistRate<BodyFixed, T> bias(const BiasOf<BodyFixed, T>& of, bool) {
    return rate_of(ad(of.V, of.Sv));
  }
};
/// Forms a and c, if the screw of a hinge is known to be sparse.
struct SparseFormA {
  template <class T> static TwistRate<BodyFixed, T> bias(const BiasOf<BodyFixed, T>& of, bool is_hinge) {
    return is_hinge ? bracket_with_hinge(of.U, of.Sv) : FormA::bias(of, false);
  }
};
struct SparseFormC {
  template <class T> static TwistRate<BodyFixed, T> bias(const BiasOf<BodyFixed, T>& of, bool is_hinge) {
    return is_hinge ? bracket_with_hinge(of.V, of.Sv) : FormC::bias(of, false);
  }
};
/// ad_{r'_ip} V_p + ad_ω S v (Müller, eq. recVhdot1).
struct Form1 {
  template <class T> static TwistRate<Hybrid, T> bias(const BiasOf<Hybrid, T>& of, bool) {
    return {cross(of.V.w, of.Sv.w), cross(of.V_p.v - of.V.v, of.V_p.w) + cross(of.V.w, of.Sv.v)};
  }
};
/// ad_{r'_p} V_p - ad_{r'_i} V_i + ad_{V_i} S v (Müller, eq. recVhdot2).
struct Form2 {
  template <class T> static TwistRate<Hybrid, T> bias(const BiasOf<Hybrid, T>& of, bool) {
    return {cross(of.V.w, of.Sv.w), cross(of.V_p.v, of.V_p.w) - cross(of.V.v, of.V.w) +
                                        (cross(of.V.v, of.Sv.w) + cross(of.V.w, of.Sv.v))};
  }
};
/// Computes the part of the hybrid twist rate that is due to velocities as ad_{r'_ip} V_i + (ad_{V_i} -
/// ad_{r'_p}) S v (Müller, eq. recVhdot3), where V_i is the hybrid twist of body i, p its predecessor, S v
/// the joint's twist, and r'_ip = r'_p - r'_i the difference of the velocities of the origins.
struct Form3 {
  template <class T> static TwistRate<Hybrid, T> bias(const BiasOf<Hybrid, T>& of, bool) {
    const Vec3<T> dr = of.V_p.v - of.V.v;
    return {cross(of.V.w, of.Sv.w), cross(dr, of.V.w) - cross(dr, of.Sv.w) + cross(of.V.w, of.Sv.v)};
  }
};

/// Twists and accelerations of all bodies, with the ground at rest.
template <class Form, class Rep, class T>
void put_accelerations(const Tree<T>& tree, const TreeMotion<Rep, T>& out, const T* q, const T* v,
                       const T* a) {
  joint_motion(tree, q, v, a, out.joints);
  const auto& [link, V, dV] = out.bodies;
  link[0] = Link<Rep, T>::root();
  V[0] = {};
  dV[0] = {};
  for (int i = 1; i <= tree->n; ++i) {
    const int p = tree->parent[i];
    link[i] = link[p].child(out.joints.C_pi[i]);
    const Twist<Rep, T> Sv = push(link[i], out.joints.Sv[i]), U = link[i].down(V[p]);
    V[i] = U + Sv;
    dV[i] = link[i].down(dV[p]) + push(link[i], out.joints.Sa[i]) +
            Form::bias(BiasOf<Rep, T>{V[p], U, V[i], Sv}, tree->kind[i] == Subgroup::revolute);
  }
}

/// Twists, accelerations and jerks V'' of all bodies, with the ground at rest.
template <class Rep, class T> struct Jerks {
  TreeMotion<Rep, T> motion;
  TwistRate<BodyFixed, T>* Sj;
  TwistRate<Rep, T>* ddV;

  explicit Jerks(Arena& arena)
      : motion(arena),
        Sj(arena.per_body<TwistRate<BodyFixed, T>>()),
        ddV(arena.per_body<TwistRate<Rep, T>>()) {}

  /// `rates` are the rows v, a and jerk of nv numbers.
  void run(const Tree<T>& tree, const T* q, const T* rates) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    joint_motion(tree, q, rates, rates + nv, motion.joints);
    joint_screws(tree, rates + 2 * nv, Sj);
    const auto& [link, V, dV] = motion.bodies;
    link[0] = Link<Rep, T>::root();
    V[0] = {};
    dV[0] = ddV[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      link[i] = link[p].child(motion.joints.C_pi[i]);
      const auto as_twist = [](const auto& X) { return Twist<Rep, T>{X.w, X.v}; };
      const Twist<Rep, T> S[3] = {push(link[i], motion.joints.Sv[i]),
                                  as_twist(push(link[i], motion.joints.Sa[i])),
                                  as_twist(push(link[i], Sj[i]))};
      const Twist<Rep, T> of_p[3] = {V[p], as_twist(dV[p]), as_twist(ddV[p])};
      Twist<Rep, T> of_i[3];
      put(link[i], of_p, S, of_i);
      V[i] = of_i[0];
      dV[i] = {of_i[1].w, of_i[1].v};
      ddV[i] = {of_i[2].w, of_i[2].v};
    }
  }

 private:
  using V6 = Twist<Rep, T>;

  /// (Ad)' = -ad_S Ad (see (D3.1) to (D3.5) of docs/derivations).
  static void put(const Link<BodyFixed, T>& link, const V6* of_p, const V6* S, V6* out) {
    const V6 U[3] = {link.down(of_p[0]), link.down(of_p[1]), link.down(of_p[2])};
    const V6 U_1 = U[1] - ad(S[0], U[0]);
    out[0] = U[0] + S[0];
    out[1] = U_1 + S[1];
    out[2] = U[2] - ad(S[0], U[1]) - ad(S[1], U[0]) - ad(S[0], U_1) + S[2];
  }
  /// J' = ad_V J.
  static void put(const Link<Spatial, T>&, const V6* of_p, const V6* J, V6* out) {
    out[0] = of_p[0] + J[0];
    const V6 dJ = ad(out[0], J[0]);
    out[1] = of_p[1] + J[1] + dJ;
    out[2] = of_p[2] + J[2] + T(2) * ad(out[0], J[1]) + ad(out[1], J[0]) + ad(out[0], dJ);
  }
  /// Vectors in inertial axes: those of the joint turn with the body, and d is the distance of the origins.
  static void put(const Link<Hybrid, T>& link, const V6* of_p, const V6* S, V6* out) {
    const Vec3<T>& d = link.r_pi;
    out[0] = link.down(of_p[0]) + S[0];
    const Vec3<T>& w = out[0].w;
    const Vec3<T> dd = out[0].v - of_p[0].v;
    const V6 dS{cross(w, S[0].w), cross(w, S[0].v)};
    out[1] = {of_p[1].w + S[1].w + dS.w,
              of_p[1].v + cross(of_p[1].w, d) + cross(of_p[0].w, dd) + S[1].v + dS.v};
    const Vec3<T>&dw = out[1].w, ddd = out[1].v - of_p[1].v;
    const auto of_joint = [&](const Vec3<T>& s, const Vec3<T>& ds, const Vec3<T>& s_1, const Vec3<T>& s_2) {
      return s_2 + T(2) * cross(w, s_1) + cross(dw, s) + cross(w, ds);
    };
    out[2] = {of_p[2].w + of_joint(S[0].w, dS.w, S[1].w, S[2].w),
              of_p[2].v + cross(of_p[2].w, d) + T(2) * cross(of_p[1].w, dd) + cross(of_p[0].w, ddd) +
                  of_joint(S[0].v, dS.v, S[1].v, S[2].v)};
  }
  /// Angular components turn with the bodies, linear ones are inertial.
  static void put(const Link<Mixed, T>& link, const V6* of_p, const V6* S, V6* out) {
    const SO3<T> Ct = transpose(link.C_pi.R), Rt = transpose(link.R), Rt_p = transpose(link.R_p);
    const Vec3<T>&c = link.C_pi.r, &w_p = of_p[0].w, &dw_p = of_p[1].w;
    const Vec3<T> U = Ct * w_p, A_1 = Ct * dw_p, U_1 = A_1 - cross(S[0].w, U), w = U + S[0].w,
                  dw = U_1 + S[1].w;
    out[0] = {w, of_p[0].v + link.R_p * cross(w_p, c) + S[0].v};
    const Vec3<T> dc = Rt_p * (out[0].v - of_p[0].v), y = Rt * S[0].v, w_y = cross(w, y);
    out[1] = {dw, of_p[1].v + link.R_p * (cross(dw_p, c) + cross(w_p, dc)) + S[1].v + link.R * w_y};
    const Vec3<T> ddc = Rt_p * (out[1].v - of_p[1].v), y_1 = Rt * S[1].v;
    out[2] = {
        Ct * of_p[2].w - cross(S[0].w, A_1) - cross(S[1].w, U) - cross(S[0].w, U_1) + S[2].w,
        of_p[2].v +
            link.R_p * (cross(of_p[2].w + cross(w_p, dw_p), c) + T(2) * cross(dw_p, dc) + cross(w_p, ddc)) +
            S[2].v + link.R * (T(2) * cross(w, y_1) + cross(dw, y) + cross(w, w_y))};
  }
};

}  // namespace axode::command
