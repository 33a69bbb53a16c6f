#pragma once
#include "axode/recursion/forward_kinematics.hpp"

namespace axode::command {

/// The point about which spatial twists are: the origins of the root bodies (bodies joined to the ground), as
/// in the library, or the inertial origin, as in A. Müller's paper (see docs/notation.md).
enum class SpatialOrigin { of_roots, inertial };

/// Inverse dynamics as in sections 4.2 and 4.3 of A. Müller's paper (see docs/notation.md): each joint screw
/// is transformed once, from the axes of its body to J in the representation Rep of twists. With the twists
/// V_i and V_p of body i and its predecessor, the wrench W that the joint transmits, and its armature d,
///   V_i = down V_p + J v,  V'_i = down V'_p + J a + bias(V_p, V_i, J v),  τ = J | W + d a.
/// `down` converts a twist or its rate from the frame in which Rep expresses twists of the predecessor to
/// that of body i, and `bias` is the part of V'_i that is due to velocities. Gravity is counted by V' = (0;
/// -g) of the ground. The tree must have no coupled joints, and no loads act.
template <class Rep, class T> struct ScrewsOnce {
  BodyLinks<Rep, T> links;
  Twist<Rep, T>* J;
  Twist<Rep, T>* V;
  TwistRate<Rep, T>* dV;
  Wrench<Rep, T>* W;

  explicit ScrewsOnce(Arena& arena)
      : links(arena),
        J(arena.per_screw<Twist<Rep, T>>()),
        V(arena.per_body<Twist<Rep, T>>()),
        dV(arena.per_body<TwistRate<Rep, T>>()),
        W(arena.per_body<Wrench<Rep, T>>()) {}

  template <TreeOf<T> AnyTree>
  void run(const AnyTree& tree, const T* q, const T* v, const T* a, T* tau,
           SpatialOrigin origin = SpatialOrigin::of_roots) noexcept {
    const Link<Rep, T>* link = links.link;
    if (origin == SpatialOrigin::of_roots) {
      links.run(tree, q);
    } else {
      joint_poses(tree, q, links.C_pi);
      links.link[0] = Link<Rep, T>::root();
      for (int i = 1; i <= tree->n; ++i) links.link[i] = link[tree->parent[i]].child(links.C_pi[i]);
    }
    joint_columns(tree, link, J);
    V[0] = {};
    dV[0] = {{}, -tree.g};
    W[0] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      const Twist<Rep, T> V_p = V[p], Jv = motion(tree, i, v), Ja = motion(tree, i, a);
      V[i] = link[i].down(V_p) + Jv;
      dV[i] = link[i].down(dV[p]) + TwistRate<Rep, T>{Ja.w, Ja.v} + link[i].bias(V_p, V[i], Jv);
      W[i] = link[i].newton_euler(tree.M[i], V[i], dV[i]);
    }
    for (int i = tree->n; i > 0; --i) {
      const int first = tree->first_screw[i];
      for (int s = first; s < tree->first_screw[i + 1]; ++s) {
        const int c = tree->iv[i] + s - first;
        tau[c] = (W[i] | J[s]) + tree.armature[c] * a[c];
      }
      W[tree->parent[i]] += link[i].up(W[i]);
    }
  }

 private:
  /// J x of joint i.
  template <class AnyTree> Twist<Rep, T> motion(const AnyTree& tree, int i, const T* x) const noexcept {
    const int first = tree->first_screw[i];
    const T* const x_i = x + tree->iv[i];
    Twist<Rep, T> sum = x_i[0] * J[first];
    for (int s = first + 1; s < tree->first_screw[i + 1]; ++s) sum += x_i[s - first] * J[s];
    return sum;
  }
};

}  // namespace axode::command
