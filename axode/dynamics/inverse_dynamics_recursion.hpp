#pragma once
#include "axode/dynamics/loads.hpp"
#include "axode/dynamics/newton_euler.hpp"
#include "axode/kinematics/forward_recursion.hpp"

namespace axode {

/// The resultant wrench on body i with inertia M, by its link (eqs. NEb, NEs, NEh and the mixed form).
template <class T, class InertiaOfBody>
constexpr Wrench<BodyFixed, T> newton_euler(const Link<BodyFixed, T>&, const InertiaOfBody& M,
                                            const Twist<BodyFixed, T>& V, const TwistRate<BodyFixed, T>& dV) {
  return newton_euler(M, V, dV);
}
template <class T, class InertiaOfBody>
constexpr Wrench<Spatial, T> newton_euler(const Link<Spatial, T>& link, const InertiaOfBody& M,
                                          const Twist<Spatial, T>& V, const TwistRate<Spatial, T>& dV) {
  return newton_euler(transform(link.C, M), V, dV);
}
template <class T, class InertiaOfBody>
constexpr Wrench<Hybrid, T> newton_euler(const Link<Hybrid, T>& link, const InertiaOfBody& M,
                                         const Twist<Hybrid, T>& V, const TwistRate<Hybrid, T>& dV) {
  return newton_euler(transform(link.R, M), V, dV);
}
template <class T, class InertiaOfBody>
constexpr Wrench<Mixed, T> newton_euler(const Link<Mixed, T>& link, const InertiaOfBody& M,
                                        const Twist<Mixed, T>& V, const TwistRate<Mixed, T>& dV) {
  return newton_euler(M, link.R, V, dV);
}

/// Applied wrenches, summed up for each body in its internal frame.
template <class T>
void sum_applied(const Tree<T>& tree, std::span<const AppliedWrench<T>> wrenches, const SE3<T>* C,
                 Wrench<BodyFixed, T>* W_app) noexcept {
  for (int i = 0; i <= tree.n; ++i) W_app[i] = {};
  for (const AppliedWrench<T>& load : wrenches) {
    const int i = tree.frame_body[load.frame];
    const SE3<T>& offset = tree.frame_offset[load.frame];
    const Wrench<BodyFixed, T> W = with_representation(load.representation, [&](auto rep) {
      return change<BodyFixed>(C[i] * offset, Wrench<decltype(rep), T>{load.m, load.f});
    });
    const Wrench<Spatial, T> W_i = coAd(offset, W);  // the internal frame in the place of the inertial one
    W_app[i] += Wrench<BodyFixed, T>{W_i.m, W_i.f};
  }
}

/// The generalised force with which damping and Coulomb friction resist velocity c.
template <class T> T joint_loss(const Tree<T>& tree, int c, const T& v_c) noexcept {
  const T sign = select(v_c > T(0), T(1), select(v_c < T(0), T(-1), T(0)));
  return tree.damping[c] * v_c + tree.friction[c] * sign;
}

/// What the drives of the joints themselves take: armature and, where asked for, losses.
template <class T>
void add_joint_terms(const Tree<T>& tree, const T* v, const T* a, bool joint_losses, T* tau) noexcept {
  for (int k = 0; k < tree.nv; ++k) tau[k] += tree.armature[k] * a[k];
  if (joint_losses)
    for (int k = 0; k < tree.nv; ++k) tau[k] += joint_loss(tree, k, v[k]);
}

/// The wrenches that the joints transmit and the generalised forces of one tree.
template <class Rep, class T> struct InverseDynamicsRecursion {
  JointMotion<T> joints;
  BodyMotion<Rep, T> bodies;
  Wrench<Rep, T>* W;
  SE3<T>* C;
  Wrench<BodyFixed, T>* W_app;

  explicit InverseDynamicsRecursion(typename Workspace<T>::Arena& arena)
      : joints(arena),
        bodies(arena),
        W(arena.template per_body<Wrench<Rep, T>>()),
        C(arena.template per_body<SE3<T>>()),
        W_app(arena.template per_body<Wrench<BodyFixed, T>>()) {}

  /// Forward: poses, twists, accelerations with gravity as V'_0 = (0, -g). Backward, from the leaves to the
  /// roots (eqs. aWbRec, bWsRec, bWhRec with erratum 22):
  ///   W_i = Σ_children up W_c + M_i V'_i + (velocity terms) - W_i^app
  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept {
    run(tree, q, v, a, loads, tree.g);
  }
  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a, const Loads<T>& loads,
           const Vec3<T>& g) noexcept {
    joint_motion(tree, q, v, a, joints);
    forward_recursion(tree, joints, -g, bodies);
    W[0] = {};
    for (int i = 1; i <= tree.n; ++i)
      W[i] = newton_euler(bodies.link[i], tree.M[i], bodies.V[i], bodies.dV[i]);
    if (!loads.wrenches.empty()) {
      body_poses(tree, joints.C_pi, C);
      sum_applied(tree, loads.wrenches, C, W_app);
      for (int i = 1; i <= tree.n; ++i) W[i] -= bodies.link[i].push(W_app[i]);
    }
    for (int i = tree.n; i > 0; --i) W[tree.parent[i]] += bodies.link[i].up(W[i]);
  }

  /// τ = Sᵀ W of every joint (eqs. bWbRec, cWsRec, cWhRec), its armature and, where asked for, its losses. A
  /// coupled joint adds its share to its leader's.
  template <TreeOf<T> AnyTree>
  void project(const AnyTree& tree, const T* v, const T* a, bool joint_losses, T* tau) const noexcept {
    each_joint(tree, [&](const auto& joint, int i, bool coupled) {
      const auto Q = joint.project(bodies.link[i].pull(W[i]));
      T* tau_i = tau + tree.iv[i];
      if (coupled) {
        *tau_i += tree.ratio[i] * Q[0];
      } else {
        for (int k = 0; k < joint.nv; ++k) tau_i[k] = Q[k];
      }
    });
    add_joint_terms(tree, v, a, joint_losses, tau);
  }
};

}  // namespace axode
