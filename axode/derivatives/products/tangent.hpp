#pragma once
#include "axode/fast/inverse_dynamics.hpp"

namespace axode {

/// Computes inverse dynamics and its derivative δτ along one direction (δq, δv, δa) by the differentiated
/// Newton-Euler recursion on classical accelerations ((D1.20) of docs/derivations). It takes about 340
/// products and sums for a hinge.
template <class G, class T> struct InverseDynamicsTangent {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  struct Motion {
    Vector w, dw, a;
  };
  struct Body {
    Matrix R;
    Vector r, m, f, tangent_m, tangent_f;
  };
  JointAngles<T> angles;
  Motion *motion, *tangent;
  Body* body;

  explicit InverseDynamicsTangent(Arena& arena)
      : angles(arena),
        motion(arena.per_body<Motion>()),
        tangent(arena.per_body<Motion>()),
        body(arena.per_body<Body>()) {}

  template <class S>
  void forward(const Tree<S>& tree, const T* q, const T* v, const T* a, const T* dq, const T* dv, const T* da,
               const Vec3<T>& g) noexcept {
    angles.run(tree, q);
    Motion x{{}, {}, Vector(-g)}, d{};
    motion[0] = x;
    tangent[0] = d;
    body[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) {
        x = motion[p];
        d = tangent[p];
      }
      const auto& body_i = constants<G, T>(tree, i);
      Body& b = body[i];
      const Factor w_p(x.w), dw_p(x.dw), tw_p(d.w), tdw_p(d.dw);
      if (is_hinge(tree, i)) [[likely]] {
        const int c = tree->iv[i];
        const T s = angles.sine[i - 1], cosine = angles.cosine[i - 1];
        const auto Rt = body_i.rows(s, cosine);
        b.R = body_i.columns(s, cosine);
        b.r = Vector(body_i.r);
        const Factor& r = body_i.r_factor();
        const Factor w_r(cross(w_p, r)), tw_r(cross(tw_p, r));
        const Vector w = Rt * Spread(x.w), dw = Rt * Spread(x.dw);
        const Vector tw = Rt * Spread(d.w) + cross_z(w, dq[c]);
        const Vector tdw = Rt * Spread(d.dw) + cross_z(dw, dq[c]);
        x.a = Rt * Spread(x.a + (cross(dw_p, r) + cross(w_p, w_r)));
        d.a = Rt * Spread(d.a + (cross(tdw_p, r) + (cross(tw_p, w_r) + cross(w_p, tw_r)))) +
              cross_z(x.a, dq[c]);
        x.w = add_z(w, v[c]);
        d.w = add_z(tw, dv[c]);
        x.dw = add_z(dw + cross_z(w, v[c]), a[c]);
        d.dw = add_z(tdw + cross_z(tw, v[c]) + cross_z(w, dv[c]), da[c]);
      } else {
        const SE3<T> C = any_joint_pose(tree, i, q);
        const auto S_times = [&](const T* y) { return any_joint_twist(tree, i, y); };
        const Twist<BodyFixed, T> V = S_times(v), A = S_times(a), X = S_times(dq), tV = S_times(dv),
                                  tA = S_times(da);
        b.R = Matrix(C.R);
        b.r = Vector(C.r);
        const Matrix Rt(transpose(C.R));
        const Factor r(b.r), tr(b.R * Spread(Vector(X.v))), X_w((Vector(X.w)));
        const Factor w_J(Vector(V.w)), v_J(Vector(V.v)), tw_J(Vector(tV.w)), tv_J(Vector(tV.v));
        const Factor w_r(cross(w_p, r)), tw_r(cross(tw_p, r) + cross(w_p, tr));
        const Vector w = Rt * Spread(x.w), dw = Rt * Spread(x.dw);
        const Vector tw = Rt * Spread(d.w) + cross(Factor(w), X_w);
        const Vector tdw = Rt * Spread(d.dw) + cross(Factor(dw), X_w);
        const Vector at = Rt * Spread(x.a + (cross(dw_p, r) + cross(w_p, w_r)));
        const Vector t_at =
            Rt * Spread(d.a + (cross(tdw_p, r) + cross(dw_p, tr)) + (cross(tw_p, w_r) + cross(w_p, tw_r))) +
            cross(Factor(at), X_w);
        x.w = w + Vector(V.w);
        d.w = tw + Vector(tV.w);
        x.dw = dw + cross(Factor(w), w_J) + Vector(A.w);
        d.dw = tdw + cross(Factor(tw), w_J) + cross(Factor(w), tw_J) + Vector(tA.w);
        x.a = at + cross(Factor(w + x.w), v_J) + Vector(A.v);
        d.a = t_at + cross(Factor(tw + d.w), v_J) + cross(Factor(w + x.w), tv_J) + Vector(tA.v);
      }
      const typename G::Tensor Theta(body_i.Theta);
      const Factor& h = body_i.h_factor();
      const Factor w_(x.w), tw_(d.w), w_h(cross(w_, h)), tw_h(cross(tw_, h));
      const Vector L = Theta * Spread(x.w), tL = Theta * Spread(d.w);
      b.f = body_i.m * x.a + (cross(Factor(x.dw), h) + cross(w_, w_h));
      b.m = Theta * Spread(x.dw) + (cross(w_, Factor(L)) + cross(h, Factor(x.a)));
      b.tangent_f = body_i.m * d.a + (cross(Factor(d.dw), h) + (cross(tw_, w_h) + cross(w_, tw_h)));
      b.tangent_m =
          Theta * Spread(d.dw) + ((cross(tw_, Factor(L)) + cross(w_, Factor(tL))) + cross(h, Factor(d.a)));
      if (tree->branches[i]) {
        motion[i] = x;
        tangent[i] = d;
      }
    }
  }

  /// Applies a load W on body i; dW is the change of the load along the direction.
  void load(int i, const Wrench<BodyFixed, T>& W, const Wrench<BodyFixed, T>& dW) noexcept {
    body[i].m -= Vector(W.m);
    body[i].f -= Vector(W.f);
    body[i].tangent_m -= Vector(dW.m);
    body[i].tangent_f -= Vector(dW.f);
  }

  /// The backward sweep, after forward() and load(): adds the contributions of all bodies to dtau (nv).
  template <class S> void backward(const Tree<S>& tree, const T* dq, T* dtau) noexcept {
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      Body& to = body[tree->parent[i]];
      const Factor r(b.r);
      const Vector f = b.R * Spread(b.f);
      if (is_hinge(tree, i)) [[likely]] {
        const int c = tree->iv[i];
        dtau[c] += z(b.tangent_m);
        const Vector tf = b.R * Spread(b.tangent_f - cross_z(b.f, dq[c]));
        to.tangent_m += b.R * Spread(b.tangent_m - cross_z(b.m, dq[c])) + cross(r, Factor(tf));
        to.tangent_f += tf;
      } else {
        project_on_any_joint<T>(tree, i, {b.tangent_m, b.tangent_f}, dtau);
        const Twist<BodyFixed, T> X = any_joint_twist(tree, i, dq);
        const Factor X_w((Vector(X.w))), X_v((Vector(X.v)));
        const Vector tf = b.R * Spread(b.tangent_f + cross(X_w, Factor(b.f)));
        to.tangent_m += b.R * Spread(b.tangent_m + cross(X_w, Factor(b.m)) + cross(X_v, Factor(b.f))) +
                        cross(r, Factor(tf));
        to.tangent_f += tf;
      }
      to.f += f;
      to.m += b.R * Spread(b.m) + cross(r, Factor(f));
    }
  }
};

}  // namespace axode
