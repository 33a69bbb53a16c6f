#pragma once
#include "axode/fast/inverse_dynamics.hpp"

namespace axode {

/// Computes the gradient of λ·τ, for the forces τ of inverse dynamics and constant weights λ, with respect to
/// (q, v, a), by the adjoint of the recursive Newton-Euler algorithm ((D1.21) to (D1.23) of
/// docs/derivations). The forward sweep computes the twist of each body, and the twist Λ that the body would
/// have if the joints moved with the weights λ as velocities. The backward sweep sums wrenches over subtrees;
/// projected on the joint screws, they give the entries of the gradient. The function takes about 380
/// products and sums for a hinge.
template <class G, class T> struct InverseDynamicsGradient {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  struct Motion {
    Vector w, v;    ///< twist V
    Vector dw, dv;  ///< rate V' of the twist, gravity included
    Vector Lw, Lv;  ///< adjoint twist Λ
  };
  struct Body {
    Matrix R;
    Vector r;
    Vector m, f;         ///< transmitted wrench F
    Vector A_m, A_f;     ///< sum A of the wrenches M Λ over the subtree, with the inertias M
    Vector H, n_m, n_f;  ///< moment H and wrench n of (D1.21): sums of Bᵀ Λ and Nᵀ Λ over the subtree
  };
  JointAngles<T> angles;
  Motion* motion;
  Body* body;

  explicit InverseDynamicsGradient(Arena& arena)
      : angles(arena), motion(arena.per_body<Motion>()), body(arena.per_body<Body>()) {}

  template <class S>
  void forward(const Tree<S>& tree, const T* q, const T* v, const T* a, const T* lambda,
               const Vec3<T>& g) noexcept {
    angles.run(tree, q);
    motion[0] = {};
    motion[0].dv = Vector(-g);
    body[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const Motion& p = motion[tree->parent[i]];
      Motion& x = motion[i];
      const auto& body_i = constants<G, T>(tree, i);
      Body& b = body[i];
      const Factor w_p(p.w), dw_p(p.dw), Lw_p(p.Lw);
      if (is_hinge(tree, i)) [[likely]] {
        const int c = tree->iv[i];
        const T s = angles.sine[i - 1], cosine = angles.cosine[i - 1];
        const auto Rt = body_i.rows(s, cosine);
        b.R = body_i.columns(s, cosine);
        b.r = Vector(body_i.r);
        const Factor& r = body_i.r_factor();
        const Vector w = Rt * Spread(p.w);
        x.v = Rt * Spread(p.v + cross(w_p, r));
        x.w = add_z(w, v[c]);
        x.dw = add_z(Rt * Spread(p.dw) + cross_z(w, v[c]), a[c]);
        x.dv = Rt * Spread(p.dv + cross(dw_p, r)) + cross_z(x.v, v[c]);
        x.Lw = add_z(Rt * Spread(p.Lw), lambda[c]);
        x.Lv = Rt * Spread(p.Lv + cross(Lw_p, r));
      } else {
        const SE3<T> C = any_joint_pose(tree, i, q);
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v), dV = any_joint_twist(tree, i, a),
                                  L = any_joint_twist(tree, i, lambda);
        b.R = Matrix(C.R);
        b.r = Vector(C.r);
        const Matrix Rt(transpose(C.R));
        const Factor r(b.r), w_J(Vector(V.w)), v_J(Vector(V.v));
        x.w = Rt * Spread(p.w) + Vector(V.w);
        x.v = Rt * Spread(p.v + cross(w_p, r)) + Vector(V.v);
        x.dw = Rt * Spread(p.dw) + cross(Factor(x.w), w_J) + Vector(dV.w);
        x.dv = Rt * Spread(p.dv + cross(dw_p, r)) + cross(Factor(x.v), w_J) + cross(Factor(x.w), v_J) +
               Vector(dV.v);
        x.Lw = Rt * Spread(p.Lw) + Vector(L.w);
        x.Lv = Rt * Spread(p.Lv + cross(Lw_p, r)) + Vector(L.v);
      }
      const typename G::Tensor Theta(body_i.Theta);
      const Factor& h = body_i.h_factor();
      const Factor w_(x.w), v_(x.v), Lw_(x.Lw), Lv_(x.Lv);
      const Vector w_h = cross(w_, h), w_L = cross(w_, Lw_);
      const Vector P = body_i.m * x.v + w_h, L = Theta * Spread(x.w) + cross(h, v_);
      const Factor P_(P);
      b.f = body_i.m * x.dv + (cross(Factor(x.dw), h) + cross(w_, P_));
      b.m = Theta * Spread(x.dw) + (cross(h, Factor(x.dv)) + (cross(w_, Factor(L)) + cross(v_, P_)));
      b.A_f = body_i.m * x.Lv + cross(Lw_, h);
      b.A_m = Theta * Spread(x.Lw) + cross(h, Lv_);
      const T half_trace = T(0.5) * (body_i.Theta.xx + body_i.Theta.yy + body_i.Theta.zz);
      b.H = T(2) *
            ((half_trace * w_L - Theta * Spread(w_L)) + (cross(Factor(w_h), Lv_) + cross(v_, Factor(b.A_f))));
      b.n_m = b.n_f = Vector{};
    }
  }

  /// Adds a load, the wrench W on body i, to the inverse dynamics whose gradient is computed. It must be
  /// called after forward() and before backward(). `n` is the gradient of the power W | Λ with respect to a
  /// displacement of the body, by which W changes but not Λ (D1.21). Λ is the twist that the body would have
  /// if the joints moved with the weights λ of λ·τ as velocities.
  void load(int i, const Wrench<BodyFixed, T>& W, const Wrench<BodyFixed, T>& n) noexcept {
    body[i].m -= Vector(W.m);
    body[i].f -= Vector(W.f);
    body[i].n_m -= Vector(n.m);
    body[i].n_f -= Vector(n.f);
  }

  /// The backward sweep, from the leaves to the root. Adds to by_q, by_v and by_a the gradients by q, v and a
  /// of λ·τ, the sum of the forces τ of inverse dynamics with weights λ.
  template <class S>
  void backward(const Tree<S>& tree, const T* v, const T* a, const T* lambda, T* by_q, T* by_v,
                T* by_a) noexcept {
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      const Motion& x = motion[i];
      const Factor A_m(b.A_m), A_f(b.A_f), f_(b.f);
      if (is_hinge(tree, i)) [[likely]] {
        const int c = tree->iv[i];
        const T v_c = v[c];
        const Vector w = add_z(x.w, -v_c), dw = x.dw - cross_z(x.w, v_c), dv = x.dv - cross_z(x.v, v_c);
        const Factor w_(w), v_(x.v);
        const Vector moved = cross(A_m, w_) + cross(A_f, v_);  // ad_Vᵀ A
        const Factor Y_m(b.H + moved), Y_f(cross(A_f, w_));
        const Vector g =
            (cross(Factor(b.m), Factor(x.Lw)) + cross(f_, Factor(x.Lv))) +
            ((cross(Y_m, w_) + cross(Y_f, v_)) + (cross(A_m, Factor(dw)) + cross(A_f, Factor(dv)))) + b.n_m;
        by_q[c] += z(g);
        by_v[c] += z(b.H + T(2) * moved);
        by_a[c] += z(b.A_m);
      } else {
        backward_any(tree, i, v, a, lambda, by_q, by_v, by_a);
      }
      Body& to = body[tree->parent[i]];
      const Factor r(b.r);
      const Vector f = b.R * Spread(b.f), A = b.R * Spread(b.A_f);
      to.f += f;
      to.m += b.R * Spread(b.m) + cross(r, Factor(f));
      to.A_f += A;
      to.A_m += b.R * Spread(b.A_m) + cross(r, Factor(A));
      to.H += b.R * Spread(b.H);
      if (loaded) {
        const Vector n = b.R * Spread(b.n_f);
        to.n_f += n;
        to.n_m += b.R * Spread(b.n_m) + cross(r, Factor(n));
      }
    }
  }
  bool loaded = false;  ///< whether there are loads, so that n is not 0

  /// The gradient of λ·τ, the sum of the forces τ of inverse dynamics with weights λ, with respect to a
  /// displacement of the whole subtree of body i, joint included. It is a wrench. The backward sweep must
  /// have been run. V_J is the twist of the body relative to its predecessor.
  template <class S>
  Wrench<BodyFixed, T> by_displacement(const Tree<S>& tree, int i, const Twist<BodyFixed, T>& V_J, const T* a,
                                       const T* lambda) const noexcept {
    using V6 = Twist<BodyFixed, T>;
    using W6 = Wrench<BodyFixed, T>;
    const Body& b = body[i];
    const Motion& x = motion[i];
    const V6 V{x.w, x.v}, dV{x.dw, x.dv}, L{x.Lw, x.Lv};
    const V6 V_p = V - V_J, dV_p = dV - ad(V, V_J) - any_joint_twist(tree, i, a),
             L_p = L - any_joint_twist(tree, i, lambda);
    const W6 F{b.m, b.f}, A{b.A_m, b.A_f}, H{b.H, {}}, n{b.n_m, b.n_f};
    return ad_transposed(L_p, F) + ad_transposed(V_p, H + ad_transposed(V_p, A)) + ad_transposed(dV_p, A) + n;
  }

 private:
  static Wrench<BodyFixed, T> ad_transposed(const Twist<BodyFixed, T>& X, const Wrench<BodyFixed, T>& W) {
    return T(-1) * coad(X, W);
  }
  template <class S>
  [[gnu::noinline]] void backward_any(const Tree<S>& tree, int i, const T* v, const T* a, const T* lambda,
                                      T* by_q, T* by_v, T* by_a) noexcept {
    const Wrench<BodyFixed, T> A{body[i].A_m, body[i].A_f}, H{body[i].H, {}};
    const Twist<BodyFixed, T> V{motion[i].w, motion[i].v}, V_J = any_joint_twist(tree, i, v);
    project_on_any_joint<T>(tree, i, by_displacement(tree, i, V_J, a, lambda), by_q);
    project_on_any_joint<T>(tree, i, H + ad_transposed(V + V - V_J, A), by_v);
    project_on_any_joint<T>(tree, i, A, by_a);
  }
};

}  // namespace axode
