#pragma once
#include "axode/fast/fast.hpp"
#include "axode/fast/poses.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// The recursive Newton-Euler algorithm on the classical accelerations r'' of the bodies' origins, in the
/// axes of the joint frames. It does not need linear velocities. With the rotation R and the vector r of the
/// pose C_{p,i} of body i relative to its predecessor p, and with (ω_J; v_J) = S v, (α_J; a_J) = S a for the
/// joint screws S,
///   ω_i = Rᵀ ω_p + ω_J,   ω'_i = Rᵀ ω'_p + Rᵀ ω_p × ω_J + α_J,
///   r''_i = Rᵀ (r''_p + ω'_p × r + ω_p × (ω_p × r)) + (Rᵀ ω_p + ω_i) × v_J + a_J.
/// It takes about 150 products and sums per hinge.
template <class G, class T> struct FastInverseDynamics {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  using Forms = typename G::Forms;
  /// Angular velocity ω, angular acceleration ω' and acceleration r'' of the origin of a body, in the axes of
  /// its joint frame. Their members are assigned one by one, because GCC copies structures of many registers
  /// by calls of memcpy().
  struct Motion {
    Forms w, dw;
    Vector a;
  };
  struct Body {
    Matrix R;     ///< rotation relative to the predecessor
    Vector r;     ///< vector from the origin of the predecessor, in its axes
    Vector m, f;  ///< wrench on the body
  };
  JointAngles<T> angles;
  Motion* motion;
  Body* body;

  explicit FastInverseDynamics(Arena& arena)
      : angles(arena), motion(arena.per_body<Motion>()), body(arena.per_body<Body>()) {}

  /// The forward sweep. It computes the resultant wrench on every body by the Newton-Euler equations, with
  /// gravity g as the acceleration -g of the ground.
  template <class S>
  void forward(const Tree<S>& tree, const T* q, const T* v, const T* a, const Vec3<T>& g) noexcept {
    forward(tree, q, v, a, g, [](int, const Motion&, const Vector&) {});
  }
  /// The forward sweep, from the roots to the leaves. It computes the resultant wrench on every body. After
  /// that on body i it calls put(i, motion, v_J), through which the caller receives intermediate results.
  /// `motion` has the angular velocity and acceleration of the body and the acceleration of its origin, if
  /// the ground has the acceleration -g. v_J is the linear part of S v, the twist of the body relative to its
  /// predecessor. All are in the axes of the body.
  template <class S, class Put>
  [[gnu::always_inline]] void forward(const Tree<S>& tree, const T* q, const T* v, const T* a,
                                      const Vec3<T>& g, Put&& put) noexcept {
    angles.run(tree, q);
    Motion last{Forms(Vector{}), Forms(Vector{}), Vector(-g)};
    motion[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = motion[p];
      const auto& body_i = constants<G, T>(tree, i);
      Body& b = body[i];
      Vector linear{};
      if (is_hinge(tree, i)) [[likely]] {
        const T s = angles.sine[i - 1], c = angles.cosine[i - 1], dq = v[tree->iv[i]];
        const auto Rt = body_i.rows(s, c);
        b.R = body_i.columns(s, c);
        b.r = Vector(body_i.r);
        const Vector w = Rt * last.w.spread();
        const Vector a_i =
            last.a + (cross(last.dw.factor(), body_i.r_factor()) +
                      cross(last.w.factor(), Factor(cross(last.w.factor(), body_i.r_factor()))));
        last.w = Forms(add_z(w, dq));
        last.dw = Forms(Rt * last.dw.spread() + add_z(cross_z(w, dq), a[tree->iv[i]]));
        last.a = Rt * Spread(a_i);
      } else {
        const SE3<T> C = any_joint_pose(tree, i, q);
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v), A = any_joint_twist(tree, i, a);
        const Matrix Rt(transpose(C.R));
        b.R = Matrix(C.R);
        b.r = Vector(C.r);
        linear = Vector(V.v);
        const Factor r(b.r), w_J(Vector(V.w)), v_J(linear);
        const Vector w = Rt * last.w.spread(), w_i = w + Vector(V.w);
        const Vector a_i =
            last.a + (cross(last.dw.factor(), r) + cross(last.w.factor(), Factor(cross(last.w.factor(), r))));
        last.w = Forms(w_i);
        last.dw = Forms(Rt * last.dw.spread() + (cross(Factor(w), w_J) + Vector(A.w)));
        last.a = Rt * Spread(a_i) + (cross(Factor(w + w_i), v_J) + Vector(A.v));
      }
      const typename G::Tensor Theta(body_i.Theta);
      const Factor& h = body_i.h_factor();
      const Factor& w = last.w.factor();
      b.f = body_i.m * last.a + (cross(last.dw.factor(), h) + cross(w, Factor(cross(w, h))));
      b.m = Theta * last.dw.spread() + (cross(w, Factor(Theta * last.w.spread())) + cross(h, Factor(last.a)));
      if (tree->branches[i]) motion[i] = last;
      put(i, last, linear);
    }
  }

  /// The backward sweep, from the leaves to the roots. It computes the wrench W that every joint transmits,
  /// and adds the forces Sᵀ W on the joint screws S to `tau` (nv).
  template <class S> void backward(const Tree<S>& tree, T* tau) noexcept {
    Vector m{}, f{};  // wrench from body i + 1, if body i is its predecessor
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      m += b.m;
      f += b.f;
      if (is_hinge(tree, i)) [[likely]]
        tau[tree->iv[i]] += z(m);
      else
        project_on_any_joint<T>(tree, i, {m, f}, tau);
      const int p = tree->parent[i];
      f = b.R * Spread(f);
      m = b.R * Spread(m) + cross(Factor(b.r), Factor(f));
      if (p != i - 1) {
        body[p].m += m;
        body[p].f += f;
        m = f = Vector{};
      }
    }
  }
};

/// Inverse dynamics of any tree, with loads and joint losses, by FastInverseDynamics.
template <class T> struct InverseDynamicsRecursion<Fast, T> {
  FastInverseDynamics<typename FastGeometry<T>::type, T> fast;
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T* own;

  explicit InverseDynamicsRecursion(Arena& arena)
      : fast(arena), C(arena), W_app(arena.per_body<Wrench<BodyFixed, T>>()), own(arena.per_velocity<T>()) {}

  void run(const Tree<T>& tree, const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept {
    run(tree, q, v, a, loads, tree.g);
  }
  void run(const Tree<T>& tree, const T* q, const T* v, const T* a, const Loads<T>& loads,
           const Vec3<T>& g) noexcept {
    run(tree, q, v, a, loads, g, [](int, const auto&, const auto&) {});
  }
  /// Computes for each body the sum of the wrenches that its joints exert on it, about its origin and in its
  /// axes. The sum is the resultant wrench of the motion, with the acceleration -g of the ground for gravity,
  /// minus the applied wrenches. For every body i it calls put(i, motion, v_J), through which the caller
  /// receives intermediate results. `motion` has the angular velocity and acceleration of the body and the
  /// acceleration of its origin, if the ground has the acceleration -g. v_J is the linear part of the body's
  /// twist relative to its predecessor. All are in the axes of the body.
  template <class Put>
  [[gnu::always_inline]] void run(const Tree<T>& tree, const T* q, const T* v, const T* a,
                                  const Loads<T>& loads, const Vec3<T>& g, Put&& put) noexcept {
    fast.forward(tree, q, v, a, g, put);
    if (loads.wrenches.empty()) return;
    C[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const auto& b = fast.body[i];
      C[i] = C[tree->parent[i]] * SE3<T>{{b.R.x, b.R.y, b.R.z}, b.r};
    }
    sum_applied(tree, loads.wrenches, C.C, W_app);
    for (int i = 1; i <= tree->n; ++i) {
      fast.body[i].m -= W_app[i].m;
      fast.body[i].f -= W_app[i].f;
    }
  }
  /// Writes the generalised forces τ (nv), after run(). They are the components along the joint screws of the
  /// wrenches that the joints transmit, plus the forces of armatures and, if joint_losses is set, of damping
  /// and friction. τ may share the memory of v or a.
  void project(const Tree<T>& tree, const T* v, const T* a, bool joint_losses, T* tau) noexcept {
    joint_terms(tree, v, a, joint_losses, own);
    for (int c = 0; c < tree->nv; ++c) tau[c] = own[c];
    fast.backward(tree, tau);
  }
};

}  // namespace axode
