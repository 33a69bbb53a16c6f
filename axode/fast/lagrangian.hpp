#pragma once
#include "axode/fast/fast.hpp"
#include "axode/fast/poses.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// Computes the momenta p = M v and f = ∂(T - U)/∂q at constant v (both left-trivialised), the partial
/// derivatives of the Lagrangian T - U with the kinetic energy T and the potential energy U. f also has the
/// generalised forces of the loads, so that p' = f + ad_vᵀ p without drive forces. Everything is in the axes
/// of the joint frames of the bodies.
///
/// For a joint with the screws S, about the origin of the body that it moves, let (ω; u) be the twist of the
/// predecessor, (l; k) the momentum of the subtree, and (m; w) the wrench of gravity and loads on the
/// subtree. Then the entries for the joint are, without armatures,
///   Sᵀ (l; k) in p,   Sᵀ (m + l × ω + k × u; w + k × ω) in f.
/// It takes about 110 products and sums per hinge.
template <class T> struct FastLagrangian {
  using G = typename FastGeometry<T>::type;
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  struct Motion {
    Vector w, v, g;
  };
  struct Body {
    Matrix R;
    Vector r;
    Factor w, v;        ///< twist of the predecessor in the body frame, about the origin of the body
    Vector l, p, m, f;  ///< momentum (l; p) and wrench (m; f)
  };
  JointAngles<T> angles;
  Motion* motion;
  Body* body;
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;

  explicit FastLagrangian(Arena& arena)
      : angles(arena),
        motion(arena.per_body<Motion>()),
        body(arena.per_body<Body>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()) {}

  /// Writes the momenta p = M v, with the mass matrix M including armatures, and the forces f = ∂(T - U)/∂q
  /// at constant v plus the generalised forces of the loads `wrenches`, for the kinetic energy T and the
  /// potential energy U of gravity (nv numbers each). Joint forces are not included in f. g[i] is the gravity
  /// (m/s²) on the subtree of body i, for bodies i that are joined to the ground.
  void run(const Tree<T>& tree, const T* q, const T* v, std::span<const Vec3<T>> g,
           std::span<const AppliedWrench<T>> wrenches, T* p, T* f) noexcept {
    forward(tree, q, v, g);
    if (!wrenches.empty()) apply(tree, wrenches);
    for (int c = 0; c < tree->nv; ++c) {
      p[c] = tree.armature[c] * v[c];
      f[c] = T(0);
    }
    backward(tree, p, f);
  }

 private:
  void forward(const Tree<T>& tree, const T* q, const T* v, std::span<const Vec3<T>> g) noexcept {
    angles.run(tree, q);
    Motion last{};
    motion[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int parent = tree->parent[i];
      if (parent != i - 1) last = motion[parent];
      if (parent == 0) last.g = Vector(g[static_cast<std::size_t>(i)]);
      const auto& body_i = constants<G, T>(tree, i);
      Body& b = body[i];
      if (is_hinge(tree, i)) [[likely]] {
        const T s = angles.sine[i - 1], c = angles.cosine[i - 1];
        const auto Rt = body_i.rows(s, c);
        b.R = body_i.columns(s, c);
        b.r = Vector(body_i.r);
        const Vector w = Rt * Spread(last.w);
        last.v = Rt * Spread(last.v + cross(Factor(last.w), body_i.r_factor()));
        last.g = Rt * Spread(last.g);
        b.w = Factor(w);
        b.v = Factor(last.v);
        last.w = add_z(w, v[tree->iv[i]]);
      } else {
        const SE3<T> C_pi = any_joint_pose(tree, i, q);
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v);
        const Matrix Rt(transpose(C_pi.R));
        b.R = Matrix(C_pi.R);
        b.r = Vector(C_pi.r);
        const Vector w = Rt * Spread(last.w), v_p = Rt * Spread(last.v + cross(Factor(last.w), Factor(b.r)));
        last.g = Rt * Spread(last.g);
        b.w = Factor(w);
        b.v = Factor(v_p);
        last.w = w + Vector(V.w);
        last.v = v_p + Vector(V.v);
      }
      const typename G::Tensor Theta(body_i.Theta);
      const Factor& h = body_i.h_factor();
      b.l = Theta * Spread(last.w) + cross(h, Factor(last.v));
      b.p = body_i.m * last.v + cross(Factor(last.w), h);
      b.m = cross(h, Factor(last.g));
      b.f = body_i.m * last.g;
      if (tree->branches[i]) motion[i] = last;
    }
  }
  void apply(const Tree<T>& tree, std::span<const AppliedWrench<T>> wrenches) noexcept {
    C[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const Body& b = body[i];
      C[i] = C[tree->parent[i]] * SE3<T>{{b.R.x, b.R.y, b.R.z}, b.r};
    }
    sum_applied(tree, wrenches, C.C, W_app);
    for (int i = 1; i <= tree->n; ++i) {
      body[i].m += W_app[i].m;
      body[i].f += W_app[i].f;
    }
  }
  void backward(const Tree<T>& tree, T* p_out, T* f_out) noexcept {
    Vector l{}, p{}, m{}, f{};  // momentum and wrench from body i + 1, if body i is its predecessor
    for (int i = tree->n; i > 0; --i) {
      const Body& b = body[i];
      l += b.l;
      p += b.p;
      m += b.m;
      f += b.f;
      const Factor p_(p);
      const Vector moment = m + cross(Factor(l), b.w) + cross(p_, b.v);
      if (is_hinge(tree, i)) [[likely]] {
        p_out[tree->iv[i]] += z(l);
        f_out[tree->iv[i]] += z(moment);
      } else {
        project_on_any_joint<T>(tree, i, {l, p}, p_out);
        project_on_any_joint<T>(tree, i, {moment, f + cross(p_, b.w)}, f_out);
      }
      const int parent = tree->parent[i];
      const Factor r(b.r);
      p = b.R * Spread(p);
      f = b.R * Spread(f);
      l = b.R * Spread(l) + cross(r, Factor(p));
      m = b.R * Spread(m) + cross(r, Factor(f));
      if (parent != i - 1) {
        Body& to = body[parent];
        to.l += l;
        to.p += p;
        to.m += m;
        to.f += f;
        l = p = m = f = Vector{};
      }
    }
  }
};

}  // namespace axode
