#pragma once
#include "axode/kinematics/representation.hpp"
#include "axode/model/tree.hpp"
#include "axode/model/workspace.hpp"

namespace axode {

/// What the joints contribute, before any recursion: C_{p,i} = B exp(S q), S v and S a, in the joint frames.
template <class T> struct JointMotion {
  SE3<T>* C_pi;
  Twist<BodyFixed, T>* Sv;
  TwistRate<BodyFixed, T>* Sa;

  explicit JointMotion(typename Workspace<T>::Arena& arena)
      : C_pi(arena.template per_body<SE3<T>>()),
        Sv(arena.template per_body<Twist<BodyFixed, T>>()),
        Sa(arena.template per_body<TwistRate<BodyFixed, T>>()) {}
};

/// C_{p,i} of every joint at q (eq. relConf). A coupled joint takes q from its leader.
template <class T, TreeOf<T> AnyTree>
void joint_poses(const AnyTree& tree, const T* q, SE3<T>* C_pi) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    const T* q_i = q + tree.iq[i];
    const T own = tree.ratio[i] * *q_i + tree.offset[i];
    C_pi[i] = joint.pose(tree.B[i], coupled ? &own : q_i);
  });
}

/// S x of every joint, for velocities or accelerations x.
template <class Motion, class T, TreeOf<T> AnyTree>
void joint_screws(const AnyTree& tree, const T* x, Motion* Sx) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    const T* x_i = x + tree.iv[i];
    const T own = tree.ratio[i] * *x_i;
    const Twist<BodyFixed, T> X = joint.twist(coupled ? &own : x_i);
    Sx[i] = {X.w, X.v};
  });
}

template <class T, TreeOf<T> AnyTree>
void joint_motion(const AnyTree& tree, const T* q, const T* v, const T* a,
                  const JointMotion<T>& out) noexcept {
  joint_poses(tree, q, out.C_pi);
  joint_screws(tree, v, out.Sv);
  joint_screws(tree, a, out.Sa);
}

/// Poses of all bodies' frames, C_i = C_p C_{p,i} (eqs. POEX, aVbRec2); they may take the place of C_pi.
/// 36 mul, 33 add per body.
template <class T> void body_poses(const Tree<T>& tree, const SE3<T>* C_pi, SE3<T>* C) noexcept {
  C[0] = {};
  for (int i = 1; i <= tree.n; ++i) C[i] = C[tree.parent[i]] * C_pi[i];
}

/// The links of all bodies at q.
template <class Rep, class T, TreeOf<T> AnyTree>
Link<Rep, T>* body_links(const AnyTree& tree, typename Workspace<T>::Arena& arena, const T* q) noexcept {
  SE3<T>* C_pi = arena.template per_body<SE3<T>>();
  Link<Rep, T>* link = arena.template per_body<Link<Rep, T>>();
  joint_poses(tree, q, C_pi);
  link[0] = Link<Rep, T>::root();
  for (int i = 1; i <= tree.n; ++i) link[i] = link[tree.parent[i]].child(C_pi[i]);
  return link;
}

/// The screws of all joints in Rep. A coupled joint's screw is for a unit velocity of its leader.
template <class Rep, class T, TreeOf<T> AnyTree>
void joint_columns(const AnyTree& tree, const Link<Rep, T>* link, Twist<Rep, T>* S) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool) {
    for (int k = 0; k < joint.nv; ++k) {
      const Screw<T> e = tree.ratio[i] * joint.column(k);
      S[tree.first_screw[i] + k] = link[i].push(Twist<BodyFixed, T>{e.w, e.v});
    }
  });
}

/// Links, twists and twist rates of all bodies, in the internal frames.
template <class Rep, class T> struct BodyMotion {
  Link<Rep, T>* link;
  Twist<Rep, T>* V;
  TwistRate<Rep, T>* dV;

  explicit BodyMotion(typename Workspace<T>::Arena& arena)
      : link(arena.template per_body<Link<Rep, T>>()),
        V(arena.template per_body<Twist<Rep, T>>()),
        dV(arena.template per_body<TwistRate<Rep, T>>()) {}
};

/// The forward kinematics recursion in any representation (eqs. VbRec, Vsrec, VhRec, cVbRec2, dVsRec,
/// dVhRec2):
///   V_i  = down V_p  + S v
///   V'_i = down V'_p + S a + bias(V_p, V_i, S v)
/// dV_0 is the acceleration of the ground: 0, or (0, -g) to fold gravity in.
template <class Rep, class T>
void forward_recursion(const Tree<T>& tree, const JointMotion<T>& joints, const Vec3<T>& ground_acceleration,
                       const BodyMotion<Rep, T>& out) noexcept {
  out.link[0] = Link<Rep, T>::root();
  out.V[0] = {};
  out.dV[0] = {{}, ground_acceleration};
  for (int i = 1; i <= tree.n; ++i) {
    const int p = tree.parent[i];
    const Link<Rep, T> link = out.link[p].child(joints.C_pi[i]);
    const Twist<Rep, T> V_p = out.V[p], Sv = link.push(joints.Sv[i]);
    const Twist<Rep, T> V = link.down(V_p) + Sv;
    out.dV[i] = link.down(out.dV[p]) + link.push(joints.Sa[i]) + link.bias(V_p, V, Sv);
    out.V[i] = V;
    out.link[i] = link;
  }
}

}  // namespace axode
