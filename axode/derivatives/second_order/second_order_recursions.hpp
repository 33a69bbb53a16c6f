#pragma once
#include "axode/derivatives/displacement/load_stiffness.hpp"
#include "axode/fast/any_joint.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

/// Computes τ, τ' and τ'' of a motion by the Newton-Euler recursion, differentiated twice (Müller, section
/// 6.3). `rates` are the rows v, a, jerk and snap of nv numbers each. The results are three rows of nv
/// forces. O(n).
namespace axode {

/// A load W (an external wrench) and the first two time derivatives of its components, all as wrenches on the
/// body in body axes. The components of the load in its own representation (body-fixed, spatial, hybrid or
/// mixed) are constant. If the frame on which it acts has the twist V, its components in that frame change at
/// the rate L(V) W, the change of W if the frame is displaced along V (see load_change() and (D3.4) of
/// docs/derivations).
template <class T> struct LoadRates {
  Wrench<BodyFixed, T> W[3];

  /// Computes the load `on` and its derivatives for a body with the twist V and its rate dV.
  LoadRates(const ResolvedLoad<T>& on, const Twist<BodyFixed, T>& V, const Twist<BodyFixed, T>& dV) {
    const Twist<BodyFixed, T> V_f = on.there(V), dV_f = on.there(dV);
    const auto L = [&](const Twist<BodyFixed, T>& X, const Wrench<BodyFixed, T>& F) {
      return load_change(on.representation, F, X);
    };
    const Wrench<BodyFixed, T> first = L(V_f, on.W), second = L(dV_f, on.W) + L(V_f, first);
    W[0] = on.back(on.W);
    W[1] = on.back(first);
    W[2] = on.back(second);
  }
};

/// Calls f with each load as a wrench on a body at the configuration q. `poses` receives the poses of the
/// bodies, unless there are no loads.
template <class T, class F>
void each_load(const Tree<T>& tree, const T* q, const Loads<T>& loads, BodyPoses<T>& poses,
               const F& f) noexcept {
  if (loads.wrenches.empty()) return;
  poses.run(tree, q);
  for (const AppliedWrench<T>& load : loads.wrenches) f(ResolvedLoad<T>(tree, load, poses.C));
}

/// Computes the joint forces of armatures and losses and their first two time derivatives, and writes them to
/// the three rows of tau.
template <class T> void drive_rates(const Tree<T>& tree, const T* rates, bool joint_losses, T* tau) noexcept {
  const int nv = tree->nv;
  joint_terms(tree, rates, rates + nv, joint_losses, tau);
  for (std::ptrdiff_t k = 1; k < 3; ++k)
    for (int c = 0; c < nv; ++c)
      tau[k * nv + c] = tree.armature[c] * rates[(k + 1) * nv + c] +
                        (joint_losses ? tree.damping[c] * rates[k * nv + c] : T(0));
}

template <class Rep, class T> struct SecondOrderRecursion;

/// Computes the joint forces τ and their first two time derivatives τ' and τ'' by a recursion with twists and
/// wrenches in body axes ((D3.1) to (D3.5) of docs/derivations). The time derivative of a twist or wrench has
/// the derivatives of its components in the moving axes of its body.
template <class T> struct SecondOrderRecursion<BodyFixed, T> {
  using V6 = Twist<BodyFixed, T>;
  using W6 = Wrench<BodyFixed, T>;
  struct Body {
    SE3<T> C;   ///< pose relative to the predecessor
    V6 S, dS;   ///< joint twist and its derivative
    V6 V[4];    ///< twist and its derivatives, gravity not included
    Vec3<T> g;  ///< gravity in axes of the body
    W6 F[3];    ///< wrench transmitted by the joint, and its derivatives
  };
  Body* body;
  BodyPoses<T> poses;

  explicit SecondOrderRecursion(Arena& arena) : body(arena.per_body<Body>()), poses(arena) {}

  void run(const Tree<T>& tree, const T* q, const T* rates, const Loads<T>& loads, T* tau) noexcept {
    const int nv = tree->nv;
    body[0] = {};
    body[0].g = tree.g;
    for (int i = 1; i <= tree->n; ++i) {
      const Body& p = body[tree->parent[i]];
      Body& b = body[i];
      b.C = joint_pose(tree, i, q);
      V6 S[4], A[4];
      for (int k = 0; k < 4; ++k) {
        S[k] = any_joint_twist(tree, i, rates + static_cast<std::ptrdiff_t>(k) * nv);
        const Screw<T> X = Ad_inv(b.C, Screw<T>{p.V[k].w, p.V[k].v});
        A[k] = {X.w, X.v};
      }
      const V6 U = A[0], U_1 = A[1] - ad(S[0], U);
      const V6 A_1 = A[2] - ad(S[0], A[1]), U_2 = A_1 - ad(S[1], U) - ad(S[0], U_1);
      const V6 A_2 = A[3] - ad(S[0], A[2]), U_3 = A_2 - ad(S[1], A[1]) - ad(S[0], A_1) - ad(S[2], U) -
                                                  T(2) * ad(S[1], U_1) - ad(S[0], U_2);
      b.S = S[0];
      b.dS = S[1];
      b.V[0] = U + S[0];
      b.V[1] = U_1 + S[1];
      b.V[2] = U_2 + S[2];
      b.V[3] = U_3 + S[3];
      b.g = transpose(b.C.R) * p.g;

      const auto M = [&](const V6& X) {
        const auto Pi = tree.M[i] * X;
        return W6{Pi.l, Pi.p};
      };
      const auto& V = b.V;
      const W6 Pi[4] = {M(V[0]), M(V[1]), M(V[2]), M(V[3])};
      const Vec3<T> dg = cross(b.g, V[0].w), ddg = cross(b.g, V[1].w) + cross(dg, V[0].w);
      b.F[0] = Pi[1] + coad(V[0], Pi[0]) - M({{}, b.g});
      b.F[1] = Pi[2] + coad(V[1], Pi[0]) + coad(V[0], Pi[1]) - M({{}, dg});
      b.F[2] = Pi[3] + coad(V[2], Pi[0]) + T(2) * coad(V[1], Pi[1]) + coad(V[0], Pi[2]) - M({{}, ddg});
    }
    each_load(tree, q, loads, poses, [&](const ResolvedLoad<T>& on) {
      const LoadRates<T> rates_of(on, body[on.body].V[0], body[on.body].V[1]);
      for (int k = 0; k < 3; ++k) body[on.body].F[k] -= rates_of.W[k];
    });
    drive_rates(tree, rates, loads.joint_losses, tau);
    for (int i = tree->n; i > 0; --i) {
      const auto& [C, S, dS, V, g, F] = body[i];
      for (int k = 0; k < 3; ++k)
        project_on_any_joint<T>(tree, i, F[k], tau + static_cast<std::ptrdiff_t>(k) * nv);
      const auto to_predecessor = [&, &C = C](const W6& X) {
        const auto Y = coAd(C, X);
        return W6{Y.m, Y.f};
      };
      const W6 carried = coad(S, F[0]);
      W6* const to = body[tree->parent[i]].F;
      to[0] += to_predecessor(F[0]);
      to[1] += to_predecessor(F[1] + carried);
      to[2] += to_predecessor(F[2] + T(2) * coad(S, F[1]) + coad(dS, F[0]) + coad(S, carried));
    }
  }
};

/// Computes the joint forces τ and their first two time derivatives τ' and τ'' by a recursion with hybrid
/// twists ((D3.6) to (D3.8) of docs/derivations). The axes are inertial, so that the time derivatives of the
/// components of a vector are the components of its time derivative.
template <class T> struct SecondOrderRecursion<Hybrid, T> {
  using V6 = Twist<Hybrid, T>;
  using W6 = Wrench<Hybrid, T>;
  struct Body {
    SO3<T> R;
    Vec3<T> d[3];
    V6 V[4];
    W6 F[3];
  };
  Body* body;
  BodyPoses<T> poses;

  explicit SecondOrderRecursion(Arena& arena) : body(arena.per_body<Body>()), poses(arena) {}

  void run(const Tree<T>& tree, const T* q, const T* rates, const Loads<T>& loads, T* tau) noexcept {
    const int nv = tree->nv;
    body[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const Body& p = body[tree->parent[i]];
      Body& b = body[i];
      const SE3<T> C = joint_pose(tree, i, q);
      b.R = p.R * C.R;
      V6 J[4];  // products of J with v, a, jerk and snap
      for (int k = 0; k < 4; ++k) {
        const auto X = any_joint_twist(tree, i, rates + static_cast<std::ptrdiff_t>(k) * nv);
        J[k] = {b.R * X.w, b.R * X.v};
      }
      auto& d = b.d;
      auto& V = b.V;
      const auto shifted = [&](int k) { return V6{p.V[k].w, p.V[k].v + cross(p.V[k].w, d[0])}; };
      const auto linear = [](const Vec3<T>& v) { return V6{{}, v}; };
      d[0] = p.R * C.r;
      V[0] = shifted(0) + J[0];
      const Vec3<T>&w = V[0].w, &w_p = p.V[0].w, &dw_p = p.V[1].w, &ddw_p = p.V[2].w;
      d[1] = V[0].v - p.V[0].v;
      const V6 dJ_v = turn(w, J[0]), S_1 = J[1] + dJ_v;
      V[1] = shifted(1) + linear(cross(w_p, d[1])) + S_1;
      const Vec3<T>& dw = V[1].w;
      d[2] = V[1].v - p.V[1].v;
      const V6 dJ_a = turn(w, J[1]), S_2 = J[2] + dJ_a + turn(dw, J[0]) + turn(w, S_1);
      V[2] = shifted(2) + linear(T(2) * cross(dw_p, d[1]) + cross(w_p, d[2])) + S_2;
      const Vec3<T>& ddw = V[2].w;
      const Vec3<T> d_3 = V[2].v - p.V[2].v;
      const V6 S_3 = J[3] + turn(w, J[2]) + turn(dw, J[1]) + turn(w, J[2] + dJ_a) + turn(ddw, J[0]) +
                     T(2) * turn(dw, S_1) + turn(w, S_2);
      V[3] = shifted(3) + linear(T(3) * (cross(ddw_p, d[1]) + cross(dw_p, d[2])) + cross(w_p, d_3)) + S_3;

      const auto rate = [](const Vec3<T>& turning, const Inertia<T>& M) {
        return inertia_rate(Twist<Spatial, T>{turning, {}}, M);
      };
      const Inertia<T> M = transform(SE3<T>{b.R, {}}, tree.M[i]), M_1 = rate(w, M),
                       M_2 = rate(dw, M) + rate(w, M_1),
                       M_3 = rate(ddw, M) + rate(dw, M_1) + rate(dw, M_1) + rate(w, M_2);
      const auto times = [](const Inertia<T>& X, const V6& Y) {
        const auto Pi = X * Y;
        return W6{Pi.l, Pi.p};
      };
      const W6 Pi = times(M, V[0]), Pi_1 = times(M_1, V[0]) + times(M, V[1]),
               Pi_2 = times(M_2, V[0]) + T(2) * times(M_1, V[1]) + times(M, V[2]),
               Pi_3 = times(M_3, V[0]) + T(3) * (times(M_2, V[1]) + times(M_1, V[2])) + times(M, V[3]);
      b.F[0] = {Pi_1.m + cross(V[0].v, Pi.f) - cross(M.h, tree.g), Pi_1.f - M.m * tree.g};
      b.F[1] = {Pi_2.m + cross(V[1].v, Pi.f) + cross(V[0].v, Pi_1.f) - cross(M_1.h, tree.g), Pi_2.f};
      b.F[2] = {Pi_3.m + cross(V[2].v, Pi.f) + T(2) * cross(V[1].v, Pi_1.f) + cross(V[0].v, Pi_2.f) -
                    cross(M_2.h, tree.g),
                Pi_3.f};
    }
    each_load(tree, q, loads, poses, [&](const ResolvedLoad<T>& on) { apply(on, body[on.body]); });
    drive_rates(tree, rates, loads.joint_losses, tau);
    for (int i = tree->n; i > 0; --i) {
      const auto& [R, d, V, F] = body[i];
      const Vec3<T>&w = V[0].w, &dw = V[1].w;
      // τ = J|F with J' = ω × J, in axes of the body.
      const W6 F_1 = F[1] - turn(w, F[0]), F_2 = F[2] - turn(dw, F[0]) - turn(w, F[1]) - turn(w, F_1);
      project(tree, i, F[0], tau);
      project(tree, i, F_1, tau + nv);
      project(tree, i, F_2, tau + 2 * static_cast<std::ptrdiff_t>(nv));
      W6* const to = body[tree->parent[i]].F;
      to[0] += W6{F[0].m + cross(d[0], F[0].f), F[0].f};
      to[1] += W6{F[1].m + cross(d[1], F[0].f) + cross(d[0], F[1].f), F[1].f};
      to[2] += W6{F[2].m + cross(d[2], F[0].f) + T(2) * cross(d[1], F[1].f) + cross(d[0], F[2].f), F[2].f};
    }
  }

 private:
  template <class X> static X turn(const Vec3<T>& w, const X& x) {
    const auto& [a, b] = x;
    return {cross(w, a), cross(w, b)};
  }
  static Twist<BodyFixed, T> in_body(const SO3<T>& R, const V6& X) {
    return {transpose(R) * X.w, transpose(R) * X.v};
  }
  void project(const Tree<T>& tree, int i, const W6& F, T* tau) const noexcept {
    const SO3<T> Rt = transpose(body[i].R);
    project_on_any_joint<T>(tree, i, Wrench<BodyFixed, T>{Rt * F.m, Rt * F.f}, tau);
  }
  static void apply(const ResolvedLoad<T>& on, Body& b) noexcept {
    const Vec3<T>&w = b.V[0].w, &dw = b.V[1].w;
    const LoadRates<T> rates(on, in_body(b.R, b.V[0]), in_body(b.R, b.V[1] - turn(w, b.V[0])));
    const auto inertial = [&](int k) { return W6{b.R * rates.W[k].m, b.R * rates.W[k].f}; };
    const W6 W = inertial(0), W_1 = inertial(1) + turn(w, W),
             W_2 = inertial(2) + turn(w, inertial(1)) + turn(dw, W) + turn(w, W_1);
    b.F[0] -= W;
    b.F[1] -= W_1;
    b.F[2] -= W_2;
  }
};

}  // namespace axode
