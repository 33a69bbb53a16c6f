#pragma once
#include "axode/recursion/forward_kinematics.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// One applied wrench W, in the axes of the frame on which it acts and about the origin of this frame. `body`
/// is the body to which the frame is fixed, and `offset` is the pose of the frame in the internal frame (the
/// joint frame) of this body.
template <class T> struct ResolvedLoad {
  int body;
  SE3<T> offset;
  Wrench<BodyFixed, T> W;
  Representation representation;

  /// Resolves one applied wrench; C are the poses of the internal frames of the bodies.
  template <TreeOf<T> AnyTree>
  ResolvedLoad(const AnyTree& tree, const AppliedWrench<T>& load, const SE3<T>* C)
      : body(tree->frame_body[load.frame]),
        offset(tree.frame_offset[load.frame]),
        W(with_representation(
            load.representation,
            [&](auto rep) {
              return change<BodyFixed>(C[body] * offset, Wrench<decltype(rep), T>{load.m, load.f});
            })),
        representation(load.representation) {}
  /// The twist of the loaded frame if the body has the twist X.
  Twist<BodyFixed, T> there(const Twist<BodyFixed, T>& X) const {
    const Screw<T> Y = Ad_inv(offset, Screw<T>{X.w, X.v});
    return {Y.w, Y.v};
  }
  /// The wrench on the body that is equivalent to a wrench F on the loaded frame.
  Wrench<BodyFixed, T> back(const Wrench<BodyFixed, T>& F) const {
    const Wrench<Spatial, T> Y = coAd(offset, F);
    return {Y.m, Y.f};
  }
};

/// Computes W_app[i], the sum of the applied wrenches on body i in its internal frame (its joint frame), for
/// i = 0 to n, with the poses C of these frames.
template <class T, TreeOf<T> AnyTree>
void sum_applied(const AnyTree& tree, std::span<const AppliedWrench<T>> wrenches, const SE3<T>* C,
                 Wrench<BodyFixed, T>* W_app) noexcept {
  for (int i = 0; i <= tree->n; ++i) W_app[i] = {};
  for (const AppliedWrench<T>& load : wrenches) {
    const ResolvedLoad<T> on(tree, load, C);
    W_app[on.body] += on.back(on.W);
  }
}

/// The generalised force with which damping and Coulomb friction resist velocity c.
template <class T, TreeOf<T> AnyTree> T joint_loss(const AnyTree& tree, int c, const T& v_c) noexcept {
  const T sign = select(v_c > T(0), T(1), select(v_c < T(0), T(-1), T(0)));
  return tree.damping[c] * v_c + tree.friction[c] * sign;
}

/// Writes to `own` (nv) the generalised forces against the armatures and, if joint_losses is set, against
/// damping and friction of the joints.
template <class T, TreeOf<T> AnyTree>
void joint_terms(const AnyTree& tree, const T* v, const T* a, bool joint_losses, T* own) noexcept {
  for (int c = 0; c < tree->nv; ++c) own[c] = tree.armature[c] * a[c];
  if (joint_losses)
    for (int c = 0; c < tree->nv; ++c) own[c] += joint_loss(tree, c, v[c]);
}

/// Inverse dynamics in one representation: the wrenches that the joints transmit, and the generalised forces.
template <class Rep, class T> struct InverseDynamicsRecursion {
  TreeMotion<Rep, T> motion;  ///< motion about the origins of the root bodies
  Vec3<T>* origin;            ///< positions of the root bodies in the inertial frame
  Wrench<Rep, T>* W;
  BodyPoses<T> C;
  Wrench<BodyFixed, T>* W_app;
  T* own;

  explicit InverseDynamicsRecursion(Arena& arena)
      : motion(arena),
        origin(arena.per_body<Vec3<T>>()),
        W(arena.per_body<Wrench<Rep, T>>()),
        C(arena),
        W_app(arena.per_body<Wrench<BodyFixed, T>>()),
        own(arena.per_velocity<T>()) {}

  /// Computes the wrenches W_i that the joints transmit from the predecessors to the bodies i. The forward
  /// sweep computes poses, twists V and their rates V', with gravity as the acceleration V'_0 = (0, -g) of
  /// the ground. The backward sweep, from the leaves to the roots, computes (Müller, eqs. aWbRec, bWsRec,
  /// bWhRec with erratum 22 of docs/errata.md)
  ///   W_i = Σ_children up(W_c) + M_i V'_i + (wrench due to velocities) - W_i^app
  /// where W_i^app is the sum of the wrenches applied to body i, M_i its inertia, and up() of Link moves the
  /// wrench W_c from child c to body i.
  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a, const Loads<T>& loads) noexcept {
    run(tree, q, v, a, loads, tree.g);
  }
  /// Computes the joint wrenches W with the gravity g (m/s²) instead of that of the tree.
  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a, const Loads<T>& loads,
           const Vec3<T>& g) noexcept {
    joint_motion(tree, q, v, a, motion.joints);
    if (!loads.wrenches.empty()) C.run(tree, motion.joints.C_pi);
    move_to_roots(*tree.operator->(), motion.joints.C_pi, origin);
    forward_recursion(tree, motion.joints, -g, motion.bodies);
    const auto& [link, V, dV] = motion.bodies;
    W[0] = {};
    for (int i = 1; i <= tree->n; ++i) W[i] = link[i].newton_euler(tree.M[i], V[i], dV[i]);
    if (!loads.wrenches.empty()) {
      sum_applied(tree, loads.wrenches, C.C, W_app);
      for (int i = 1; i <= tree->n; ++i) W[i] -= push(link[i], W_app[i]);
    }
    for (int i = tree->n; i > 0; --i) W[tree->parent[i]] += link[i].up(W[i]);
  }

  /// Computes the generalised forces τ = Sᵀ W of every joint with the screws S (Müller, eqs. bWbRec, cWsRec,
  /// cWhRec), plus the forces against armatures and, if joint_losses is set, against damping and friction.
  /// The force of a coupled joint, times its ratio, is added to that of its leader. τ may share the memory of
  /// v or a.
  template <TreeOf<T> AnyTree>
  void project(const AnyTree& tree, const T* v, const T* a, bool joint_losses, T* tau) const noexcept {
    joint_terms(tree, v, a, joint_losses, own);
    for (int c = 0; c < tree->nv; ++c) tau[c] = own[c];
    each_joint(tree, [&](const auto& joint, int i, bool coupled) {
      const auto Q = joint.project(pull(motion.bodies.link[i], W[i]));
      T* tau_i = tau + tree->iv[i];
      if (coupled) {
        *tau_i += tree.ratio[i] * Q[0];
      } else {
        for (int k = 0; k < joint.nv; ++k) tau_i[k] += Q[k];
      }
    });
  }
};

}  // namespace axode
