#pragma once
#include <array>

#include "axode/derivatives/second_order/second_order_recursions.hpp"

/// The recursions for τ, τ' and τ'' in spatial and in mixed twists.
namespace axode {

/// The recursion for τ, τ' and τ'' in spatial twists ((D3.15) and (D3.16) of docs/derivations). Twists and
/// wrenches are in inertial axes about a fixed point, which is the present origin of the root body of the
/// branch (the body that is joined to the ground). The wrenches of bodies are added without a change of
/// this point.
template <class T> struct SecondOrderRecursion<Spatial, T> {
  using V6 = Twist<Spatial, T>;
  using W6 = Wrench<Spatial, T>;
  struct Body {
    SE3<T> C;  ///< pose relative to the fixed point, in inertial axes
    V6 V[4];   ///< twist and its derivatives
    W6 F[3];   ///< wrench transmitted by the joint, and its derivatives
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
      SE3<T> C = joint_pose(tree, i, q);
      if (tree->parent[i] == 0) C.r = {};
      b.C = p.C * C;
      V6 J[4];  // products of J with v, a, jerk and snap
      for (int k = 0; k < 4; ++k) {
        const auto X = any_joint_twist(tree, i, rates + static_cast<std::ptrdiff_t>(k) * nv);
        const Screw<T> moved = Ad(b.C, Screw<T>{X.w, X.v});
        J[k] = {moved.w, moved.v};
      }
      auto& V = b.V;
      V[0] = p.V[0] + J[0];
      const V6 S_1 = J[1] + ad(V[0], J[0]);
      V[1] = p.V[1] + S_1;
      const V6 dJ_a = ad(V[0], J[1]), S_2 = J[2] + dJ_a + ad(V[1], J[0]) + ad(V[0], S_1);
      V[2] = p.V[2] + S_2;
      V[3] =
          p.V[3] + J[3] + ad(V[0], T(2) * J[2] + dJ_a + S_2) + ad(V[1], J[1] + T(2) * S_1) + ad(V[2], J[0]);

      const Inertia<T> M = transform(b.C, tree.M[i]), M_1 = inertia_rate(V[0], M),
                       M_2 = inertia_rate(V[1], M) + inertia_rate(V[0], M_1),
                       from_2 = inertia_rate(V[1], M_1),
                       M_3 = inertia_rate(V[2], M) + from_2 + from_2 + inertia_rate(V[0], M_2);
      const auto times = [](const Inertia<T>& X, const V6& Y) {
        const auto Pi = X * Y;
        return W6{Pi.l, Pi.p};
      };
      b.F[0] = times(M_1, V[0]) + times(M, V[1]) - W6{cross(M.h, tree.g), M.m * tree.g};
      b.F[1] = times(M_2, V[0]) + T(2) * times(M_1, V[1]) + times(M, V[2]) - W6{cross(M_1.h, tree.g), {}};
      b.F[2] = times(M_3, V[0]) + T(3) * (times(M_2, V[1]) + times(M_1, V[2])) + times(M, V[3]) -
               W6{cross(M_2.h, tree.g), {}};
    }
    each_load(tree, q, loads, poses, [&](const ResolvedLoad<T>& on) { apply(on, body[on.body]); });
    drive_rates(tree, rates, loads.joint_losses, tau);
    for (int i = tree->n; i > 0; --i) {
      const auto& [C, V, F] = body[i];
      // τ = J|F with J' = ad_V J.
      const W6 F_1 = F[1] - coad(V[0], F[0]),
               F_2 = F[2] - coad(V[1], F[0]) - coad(V[0], F[1]) - coad(V[0], F_1);
      project(tree, i, F[0], tau);
      project(tree, i, F_1, tau + nv);
      project(tree, i, F_2, tau + 2 * static_cast<std::ptrdiff_t>(nv));
      for (int k = 0; k < 3; ++k) body[tree->parent[i]].F[k] += F[k];
    }
  }

 private:
  static Twist<BodyFixed, T> in_body(const SE3<T>& C, const V6& X) {
    const Screw<T> moved = Ad_inv(C, Screw<T>{X.w, X.v});
    return {moved.w, moved.v};
  }
  void project(const Tree<T>& tree, int i, const W6& F, T* tau) const noexcept {
    project_on_any_joint<T>(tree, i, coAd_inv(body[i].C, F), tau);
  }
  static void apply(const ResolvedLoad<T>& on, Body& b) noexcept {
    const LoadRates<T> rates(on, in_body(b.C, b.V[0]), in_body(b.C, b.V[1]));
    const W6 W = coAd(b.C, rates.W[0]), turned = coAd(b.C, rates.W[1]), W_1 = turned + coad(b.V[0], W);
    b.F[0] -= W;
    b.F[1] -= W_1;
    b.F[2] -= coAd(b.C, rates.W[2]) + coad(b.V[0], turned) + coad(b.V[1], W) + coad(b.V[0], W_1);
  }
};

/// The recursion for τ, τ' and τ'' in mixed twists and wrenches ((D3.17) to (D3.19) of docs/derivations).
/// Angular velocities and couples have components in body axes, which turn; linear velocities and forces have
/// components in inertial axes. The recursion has the time derivatives of these components. In body axes they
/// are not the components of the derivative of the vector.
template <class T> struct SecondOrderRecursion<Mixed, T> {
  using V6 = Twist<Mixed, T>;
  using W6 = Wrench<Mixed, T>;
  using Vector = Vec3<T>;
  struct Body {
    SO3<T> R;     ///< rotation relative to the inertial axes
    SO3<T> C;     ///< rotation relative to the predecessor
    Vector c[3];  ///< vector from the predecessor's origin in its axes, and its derivatives
    V6 V[4];
    W6 F[3];
  };
  Body* body;
  BodyPoses<T> poses;

  explicit SecondOrderRecursion(Arena& arena) : body(arena.per_body<Body>()), poses(arena) {}

  void run(const Tree<T>& tree, const T* q, const T* rates, const Loads<T>& loads, T* tau) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    body[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const Body& p = body[tree->parent[i]];
      Body& b = body[i];
      const SE3<T> C = joint_pose(tree, i, q);
      b.C = C.R;
      b.R = p.R * C.R;
      std::array<Vector, 4> s, y, w_p, w;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto X = any_joint_twist(tree, i, rates + static_cast<std::ptrdiff_t>(k) * nv);
        s[k] = X.w;
        y[k] = X.v;
        w_p[k] = p.V[k].w;
      }
      put_angular(C.R, s, p, b);
      for (std::size_t k = 0; k < 4; ++k) w[k] = b.V[k].w;
      const auto y_1 = rate(s, y);
      const auto y_2 = rate(s, y_1);
      const auto y_3 = rate(s, y_2);
      const std::array<Vector, 5> c{C.r, C.R * y[0], C.R * y_1[0], C.R * y_2[0], C.R * y_3[0]};
      const auto c_1 = rate(w_p, c);
      const auto c_2 = rate(w_p, c_1);
      const auto c_3 = rate(w_p, c_2);
      const auto c_4 = rate(w_p, c_3);
      for (std::size_t k = 0; k < 3; ++k) b.c[k] = c[k];
      b.V[0].v = p.V[0].v + p.R * c_1[0];
      b.V[1].v = p.V[1].v + p.R * c_2[0];
      b.V[2].v = p.V[2].v + p.R * c_3[0];
      b.V[3].v = p.V[3].v + p.R * c_4[0];
      put_wrenches(tree.M[i], w, tree.g, b);
    }
    each_load(tree, q, loads, poses, [&](const ResolvedLoad<T>& on) { apply(on, body[on.body]); });
    drive_rates(tree, rates, loads.joint_losses, tau);
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      Body& p = body[tree->parent[i]];
      const auto own = in_axes(b.R, b.V, b.F), of_p = in_axes(p.R, p.V, b.F);
      for (std::size_t k = 0; k < 3; ++k) {
        project_on_any_joint<T>(tree, i, Wrench<BodyFixed, T>{b.F[k].m, own[k]},
                                tau + static_cast<std::ptrdiff_t>(k) * nv);
        p.F[k].f += b.F[k].f;
      }
      const std::array<Vector, 3> m{b.F[0].m, b.F[1].m, b.F[2].m};
      const SO3<T> Ct = transpose(b.C);
      const Vector U = Ct * p.V[0].w, s_0 = b.V[0].w - U;  // angular velocity of the joint
      const std::array<Vector, 2> s{s_0, b.V[1].w - (Ct * p.V[1].w - cross(s_0, U))};
      const auto m_1 = rate(s, m);
      const auto m_2 = rate(s, m_1);
      p.F[0].m += b.C * m[0] + cross(b.c[0], of_p[0]);
      p.F[1].m += b.C * m_1[0] + cross(b.c[1], of_p[0]) + cross(b.c[0], of_p[1]);
      p.F[2].m +=
          b.C * m_2[0] + cross(b.c[2], of_p[0]) + T(2) * cross(b.c[1], of_p[1]) + cross(b.c[0], of_p[2]);
    }
  }

 private:
  /// Let x be the components of a vector in axes that turn with the angular velocity ω. The components of
  /// the time derivative of the vector are D x = x' + ω × x. Computes D x and its derivatives (D x)',
  /// (D x)'', ... from x, x', ... and ω, ω', ....
  template <std::size_t m, std::size_t n>
  static std::array<Vector, n - 1> rate(const std::array<Vector, m>& w, const std::array<Vector, n>& x) {
    std::array<Vector, n - 1> out;
    for (std::size_t k = 0; k + 1 < n; ++k) {
      out[k] = x[k + 1];
      T binomial(1);
      for (std::size_t j = 0; j <= k; ++j) {
        out[k] += j == 0 || j == k ? cross(w[j], x[k - j]) : binomial * cross(w[j], x[k - j]);
        binomial = binomial * T(static_cast<double>(k - j)) / T(static_cast<double>(j + 1));
      }
    }
    return out;
  }
  /// Returns the components Rᵀ f of a vector f in turning axes, and their first two time derivatives (D3.19).
  /// R maps components in the turning axes to components in inertial axes. The force parts of F[0], F[1] and
  /// F[2] are the components of f in inertial axes and their first two time derivatives. The angular parts of
  /// V[0] and V[1] are the components of the angular velocity of the turning axes in the turning axes, and
  /// their time derivatives. The moments of F and the linear parts of V are not used.
  static std::array<Vector, 3> in_axes(const SO3<T>& R, const V6* V, const W6* F) {
    const SO3<T> Rt = transpose(R);
    const Vector turned = Rt * F[1].f, x = Rt * F[0].f, x_1 = turned - cross(V[0].w, x);
    return {x, x_1, Rt * F[2].f - cross(V[0].w, turned) - cross(V[1].w, x) - cross(V[0].w, x_1)};
  }
  static void put_angular(const SO3<T>& C, const std::array<Vector, 4>& s, const Body& p, Body& b) {
    const SO3<T> Ct = transpose(C);
    const Vector U = Ct * p.V[0].w, A_1 = Ct * p.V[1].w, A_2 = Ct * p.V[2].w;
    const Vector U_1 = A_1 - cross(s[0], U), dA_1 = A_2 - cross(s[0], A_1);
    const Vector U_2 = dA_1 - cross(s[1], U) - cross(s[0], U_1);
    b.V[0].w = U + s[0];
    b.V[1].w = U_1 + s[1];
    b.V[2].w = U_2 + s[2];
    b.V[3].w = Ct * p.V[3].w - cross(s[0], A_2) - cross(s[1], A_1) - cross(s[0], dA_1) - cross(s[2], U) -
               T(2) * cross(s[1], U_1) - cross(s[0], U_2) + s[3];
  }
  static void put_wrenches(const Inertia<T>& M, const std::array<Vector, 4>& w, const Vector& g, Body& b) {
    const auto& [m, h, Theta] = M;
    const std::array<Vector, 4> n{cross(w[0], h), cross(w[1], h), cross(w[2], h), cross(w[3], h)};
    const auto n_1 = rate(w, n);
    const auto n_2 = rate(w, n_1);
    const auto n_3 = rate(w, n_2);
    b.F[0].f = m * (b.V[1].v - g) + b.R * n_1[0];
    b.F[1].f = m * b.V[2].v + b.R * n_2[0];
    b.F[2].f = m * b.V[3].v + b.R * n_3[0];
    const W6 linear[3] = {{{}, b.V[1].v - g}, {{}, b.V[2].v}, {{}, b.V[3].v}};
    const auto a = in_axes(b.R, b.V, linear);
    const Vector L = Theta * w[0], L_1 = Theta * w[1], L_2 = Theta * w[2];
    b.F[0].m = L_1 + cross(w[0], L) + cross(h, a[0]);
    b.F[1].m = L_2 + cross(w[1], L) + cross(w[0], L_1) + cross(h, a[1]);
    b.F[2].m = Theta * w[3] + cross(w[2], L) + T(2) * cross(w[1], L_1) + cross(w[0], L_2) + cross(h, a[2]);
  }
  static void apply(const ResolvedLoad<T>& on, Body& b) noexcept {
    const SO3<T> Rt = transpose(b.R);
    const Vector u = Rt * b.V[0].v;
    const LoadRates<T> rates(on, {b.V[0].w, u}, {b.V[1].w, Rt * b.V[1].v - cross(b.V[0].w, u)});
    const std::array<Vector, 2> w{b.V[0].w, b.V[1].w};
    const std::array<Vector, 3> f{rates.W[0].f, rates.W[1].f, rates.W[2].f};
    const auto f_1 = rate(w, f);
    const auto f_2 = rate(w, f_1);
    b.F[0] -= W6{rates.W[0].m, b.R * f[0]};
    b.F[1] -= W6{rates.W[1].m, b.R * f_1[0]};
    b.F[2] -= W6{rates.W[2].m, b.R * f_2[0]};
  }
};

}  // namespace axode
