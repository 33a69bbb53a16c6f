#pragma once
#include "axode/derivatives/displacement/geometric_parameters.hpp"
#include "axode/derivatives/displacement/load_stiffness.hpp"
#include "axode/derivatives/products/gradient.hpp"
#include "axode/derivatives/products/tangent.hpp"
#include "axode/recursion/forward_dynamics.hpp"

namespace axode {

/// Computes the derivative δτ of inverse dynamics along a direction (δq, δv, δa).
template <class T> struct InverseDynamicsJvp {
  InverseDynamicsTangent<typename FastGeometry<T>::type, T> tangent;
  BodyPoses<T> C;
  Twist<BodyFixed, T>* eta;  ///< displacements of the bodies
  T* out;

  explicit InverseDynamicsJvp(Arena& arena)
      : tangent(arena), C(arena), eta(arena.per_body<Twist<BodyFixed, T>>()), out(arena.per_velocity<T>()) {}

  /// Computes the change δτ (nv) of the forces of inverse dynamics at the state (q, v, a) along the direction
  /// (dq, dv, da). `dtau` may share the memory of an argument.
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const T* dq, const T* dv, const T* da,
           const Loads<T>& loads, T* dtau) noexcept {
    tangent.forward(tree, q, v, a, dq, dv, da, cast<T>(tree.g));
    if constexpr (std::same_as<Real, T>)
      if (!loads.wrenches.empty()) load(tree, q, dq, loads.wrenches);
    for (int c = 0; c < tree->nv; ++c)
      out[c] = T(tree.armature[c]) * da[c] + (loads.joint_losses ? T(tree.damping[c]) * dv[c] : T(0));
    tangent.backward(tree, dq, out);
    for (int c = 0; c < tree->nv; ++c) dtau[c] = out[c];
  }

 private:
  [[gnu::noinline]] void load(const Tree<T>& tree, const T* q, const T* dq,
                              std::span<const AppliedWrench<T>> wrenches) noexcept {
    C.run(tree, q);
    eta[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const auto& b = tangent.body[i];
      const SE3<T> C_pi{{b.R.x, b.R.y, b.R.z}, b.r};
      const Screw<T> from_p = Ad_inv(C_pi, Screw<T>{eta[tree->parent[i]].w, eta[tree->parent[i]].v});
      eta[i] = Twist<BodyFixed, T>{from_p.w, from_p.v} + any_joint_twist(tree, i, dq);
    }
    for (const AppliedWrench<T>& wrench : wrenches) {
      const ResolvedLoad<T> on(tree, wrench, C.C);
      tangent.load(on.body, on.back(on.W),
                   on.back(load_change(on.representation, on.W, on.there(eta[on.body]))));
    }
  }
};

/// Computes the gradient of λ·τ of inverse dynamics with respect to q, v and a, loads included.
template <class T> struct InverseDynamicsVjp {
  InverseDynamicsGradient<typename FastGeometry<T>::type, T> gradient;
  BodyPoses<T> C;
  T *by_q, *by_v, *by_a;

  explicit InverseDynamicsVjp(Arena& arena)
      : gradient(arena),
        C(arena),
        by_q(arena.per_velocity<T>()),
        by_v(arena.per_velocity<T>()),
        by_a(arena.per_velocity<T>()) {}

  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const T* lambda,
           const Loads<T>& loads) noexcept {
    run(tree, q, v, a, lambda, loads, cast<T>(tree.g));
  }
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const T* lambda, const Loads<T>& loads,
           const Vec3<T>& g) noexcept {
    gradient.forward(tree, q, v, a, lambda, g);
    gradient.loaded = !loads.wrenches.empty();
    if constexpr (std::same_as<Real, T>)
      if (gradient.loaded) load(tree, q, loads.wrenches);
    for (int c = 0; c < tree->nv; ++c) {
      by_q[c] = T(0);
      by_v[c] = loads.joint_losses ? T(tree.damping[c]) * lambda[c] : T(0);
      by_a[c] = T(tree.armature[c]) * lambda[c];
    }
    gradient.backward(tree, v, a, lambda, by_q, by_v, by_a);
  }

  /// Calls f(i, u, derivative) for all geometric parameters π: the body i, the index u of a unit screw U, and
  /// the derivative by π of λ·τ, for the forces τ of inverse dynamics and constant weights λ. The parameter
  /// displaces body i and its joint along U: C_i = C_p B_i exp(U π) exp(X_i q_i) with the pose C_p of the
  /// predecessor, the pose B_i relative to the predecessor at q_i = 0, and the joint screws X_i. run() must
  /// have computed the gradient of λ·τ before.
  template <class F>
  void each_parameter(const Tree<T>& tree, const T* q, const T* v, const T* a, const T* lambda,
                      const F& f) const noexcept {
    for (int i = 1; i <= tree->n; ++i) {
      const Wrench<BodyFixed, T> g =
          gradient.by_displacement(tree, i, any_joint_twist(tree, i, v), a, lambda);
      each_unit_screw(frame_at_zero(tree, i, q), [&](int u, const Screw<T>& X) {
        f(i, u, g | Twist<BodyFixed, T>{X.w, X.v});
      });
    }
  }

 private:
  [[gnu::noinline]] void load(const Tree<T>& tree, const T* q,
                              std::span<const AppliedWrench<T>> wrenches) noexcept {
    C.run(tree, q);
    for (const AppliedWrench<T>& wrench : wrenches) {
      const ResolvedLoad<T> on(tree, wrench, C.C);
      const auto& x = gradient.motion[on.body];
      gradient.load(on.body, on.back(on.W),
                    on.back(load_change_transposed(on.representation, on.W, on.there({x.Lw, x.Lv}))));
    }
  }
};

}  // namespace axode
