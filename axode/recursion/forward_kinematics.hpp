#pragma once
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"
#include "axode/recursion/link.hpp"

namespace axode {

/// The relative motion of each joint i: the pose C_pi of the frame of body i relative to that of its
/// predecessor, and the screws S v and S a for the velocities v and accelerations a of the joint and its unit
/// screws S. The screws are in the frame of body i, which is the joint frame in the recursions of a Tree.
template <class T> struct JointMotion {
  SE3<T>* C_pi;
  Twist<BodyFixed, T>* Sv;
  TwistRate<BodyFixed, T>* Sa;

  explicit JointMotion(Arena& arena)
      : C_pi(arena.per_body<SE3<T>>()),
        Sv(arena.per_body<Twist<BodyFixed, T>>()),
        Sa(arena.per_body<TwistRate<BodyFixed, T>>()) {}
};

/// Computes the pose C_{p,i} of every body i relative to its predecessor p at q (Müller, eq. relConf). The
/// coordinate of a coupled joint is computed from that of its leader.
template <class T, TreeOf<T> AnyTree>
void joint_poses(const AnyTree& tree, const T* q, SE3<T>* C_pi) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    const T* q_i = q + tree->iq[i];
    const T own = tree.ratio[i] * *q_i + tree.offset[i];
    C_pi[i] = joint.pose(tree.B[i], coupled ? &own : q_i);
  });
}

/// Computes the joint motion S x of every joint, in the joint frame, for velocities or accelerations x (nv).
template <class Motion, class T, TreeOf<T> AnyTree>
void joint_screws(const AnyTree& tree, const T* x, Motion* Sx) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool coupled) {
    const T* x_i = x + tree->iv[i];
    const T own = tree.ratio[i] * *x_i;
    const Twist<BodyFixed, T> X = joint.twist(coupled ? &own : x_i);
    Sx[i] = {X.w, X.v};
  });
}

/// Computes the relative pose C_{p,i} and the joint motions S v and S a of every joint.
template <class T, TreeOf<T> AnyTree>
void joint_motion(const AnyTree& tree, const T* q, const T* v, const T* a,
                  const JointMotion<T>& out) noexcept {
  joint_poses(tree, q, out.C_pi);
  joint_screws(tree, v, out.Sv);
  joint_screws(tree, a, out.Sa);
}

/// Poses of the internal frames (joint frames) of all bodies in the inertial frame, C_i = C_p C_{p,i} with
/// the predecessor p of body i (Müller, eqs. POEX, aVbRec2). This product takes 36 multiplications and 27
/// additions.
template <class T> struct BodyPoses {
  SE3<T>* C;

  explicit BodyPoses(Arena& arena) : C(arena.per_body<SE3<T>>()) {}
  BodyPoses(Arena& arena, const Tree<T>& tree, const T* q) noexcept : BodyPoses(arena) { run(tree, q); }

  /// Computes the poses at q.
  void run(const Tree<T>& tree, const T* q) noexcept {
    joint_poses(tree, q, C);
    run(tree, C);
  }
  /// Computes the poses from the relative poses C_pi of the joints. C_pi may be the array C of the results.
  template <TreeOf<T> AnyTree> void run(const AnyTree& tree, const SE3<T>* C_pi) noexcept {
    C[0] = {};
    for (int i = 1; i <= tree->n; ++i) C[i] = C[tree->parent[i]] * C_pi[i];
  }
  const SE3<T>& operator[](int i) const { return C[i]; }
  SE3<T>& operator[](int i) { return C[i]; }
};

/// Calls f(i) for every root body: every body whose predecessor is the ground.
template <class F> void each_root(const Topology& topology, F&& f) {
  for (int i = 1; i <= topology.n; i = topology.subtree_end[i]) f(i);
}

/// Replaces the position of each root body (a body joined to the ground) in C_pi by 0 and stores it in
/// `origin`, so that the origin of the root body serves as the inertial origin for its subtree. This is done
/// because the rounding errors of forces depend on the position of the inertial origin, while the forces do
/// not.
template <class T> void move_to_roots(const Topology& topology, SE3<T>* C_pi, Vec3<T>* origin) noexcept {
  each_root(topology, [&](int i) {
    origin[i] = C_pi[i].r;
    C_pi[i].r = {};
  });
}

/// The transformations of twists and wrenches between each body and its predecessor in representation Rep
/// (Link) at a configuration. The origin of each root body, a body whose predecessor is the ground, serves as
/// the inertial origin for the root body and its subtree.
template <class Rep, class T> struct BodyLinks {
  SE3<T>* C_pi;
  Vec3<T>* origin;  ///< positions of the root bodies in the inertial frame
  Link<Rep, T>* link;

  explicit BodyLinks(Arena& arena)
      : C_pi(arena.per_body<SE3<T>>()),
        origin(arena.per_body<Vec3<T>>()),
        link(arena.per_body<Link<Rep, T>>()) {}

  /// Computes the links at q and returns them; entry 0 is the ground.
  template <TreeOf<T> AnyTree> Link<Rep, T>* run(const AnyTree& tree, const T* q) noexcept {
    joint_poses(tree, q, C_pi);
    return run(tree);
  }
  /// Computes the links, the transformations of twists and wrenches between each body and its predecessor,
  /// from the poses C_pi of the bodies relative to their predecessors. First replaces the positions of the
  /// root bodies (bodies joined to the ground) in C_pi by 0 and stores them in `origin`, so that the origin
  /// of each root body serves as the inertial origin for its subtree.
  template <TreeOf<T> AnyTree> Link<Rep, T>* run(const AnyTree& tree) noexcept {
    move_to_roots(*tree.operator->(), C_pi, origin);
    link[0] = Link<Rep, T>::root();
    for (int i = 1; i <= tree->n; ++i) link[i] = link[tree->parent[i]].child(C_pi[i]);
    return link;
  }
};

/// Writes the screws of all joints to S, in representation Rep. The screw of a coupled joint is the screw of
/// its motion for a unit velocity of its leader.
template <class Rep, class T, TreeOf<T> AnyTree>
void joint_columns(const AnyTree& tree, const Link<Rep, T>* link, Twist<Rep, T>* S) noexcept {
  each_joint(tree, [&](const auto& joint, int i, bool) {
    for (int k = 0; k < joint.nv; ++k) {
      const Screw<T> e = tree.ratio[i] * joint.column(k);
      S[tree->first_screw[i] + k] = push(link[i], Twist<BodyFixed, T>{e.w, e.v});
    }
  });
}

/// Links, twists and twist rates of the internal frames of all bodies.
template <class Rep, class T> struct BodyMotion {
  Link<Rep, T>* link;
  Twist<Rep, T>* V;
  TwistRate<Rep, T>* dV;

  explicit BodyMotion(Arena& arena)
      : link(arena.per_body<Link<Rep, T>>()),
        V(arena.per_body<Twist<Rep, T>>()),
        dV(arena.per_body<TwistRate<Rep, T>>()) {}
};

/// The forward kinematics recursion in any representation (Müller, eqs. VbRec, Vsrec, VhRec, cVbRec2, dVsRec,
/// dVhRec2) for the twists V_i of the bodies and their rates, with the screws S, velocities v and
/// accelerations a of the joint of body i:
///   V_i  = down(V_p)  + S v
///   V'_i = down(V'_p) + S a + bias(V_p, V_i, S v)
/// down() transforms twists and rates from the predecessor p to body i, and bias() is the part of V'_i that
/// is due to velocities, see link.hpp. V'_0 is the acceleration of the ground: 0, or (0, -g) to include
/// gravity.
template <class Rep, class T, TreeOf<T> AnyTree>
void forward_recursion(const AnyTree& tree, const JointMotion<T>& joints, const Vec3<T>& ground_acceleration,
                       const BodyMotion<Rep, T>& out) noexcept {
  out.link[0] = Link<Rep, T>::root();
  out.V[0] = {};
  out.dV[0] = {{}, ground_acceleration};
  for (int i = 1; i <= tree->n; ++i) {
    const int p = tree->parent[i];
    const Link<Rep, T> link = out.link[p].child(joints.C_pi[i]);
    const Twist<Rep, T> V_p = out.V[p], Sv = push(link, joints.Sv[i]);
    const Twist<Rep, T> V = link.down(V_p) + Sv;
    out.dV[i] = link.down(out.dV[p]) + push(link, joints.Sa[i]) + link.bias(V_p, V, Sv);
    out.V[i] = V;
    out.link[i] = link;
  }
}

/// The motion of the joints and bodies of a tree at q with velocities v and accelerations a.
template <class Rep, class T> struct TreeMotion {
  JointMotion<T> joints;
  BodyMotion<Rep, T> bodies;

  explicit TreeMotion(Arena& arena) : joints(arena), bodies(arena) {}
  /// Computes the motion; ground_acceleration (m/s²) is the linear part of V'_0.
  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a,
           const Vec3<T>& ground_acceleration = {}) const noexcept {
    joint_motion(tree, q, v, a, joints);
    forward_recursion(tree, joints, ground_acceleration, bodies);
  }
};

}  // namespace axode
