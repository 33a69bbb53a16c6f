#pragma once
#include "axode/recursion/forward_kinematics.hpp"

namespace axode {

/// The composite-body algorithm, which computes the mass matrix (Featherstone). The composite inertia of body
/// i is the inertia of its subtree with locked joints: its own inertia plus the composite inertias of its
/// children, moved to body i. For each screw S of joint i, F is the impulse that gives this subtree the twist
/// S. F is moved from body to predecessor up to the first body on the path from the ground; at each joint on
/// the way, the product S_j | F with a screw S_j of the joint is the entry of the mass matrix for S and S_j,
/// without armatures.
template <class Rep, class T> struct CompositeBodies {
  BodyLinks<Rep, T> links;
  Inertia<T>* M;
  Twist<Rep, T>* S;

  explicit CompositeBodies(Arena& arena)
      : links(arena), M(arena.per_body<Inertia<T>>()), S(arena.per_screw<Twist<Rep, T>>()) {}

  /// Writes the mass matrix at q to `out`, nv × nv, row by row. `armature` (nv) is added to the diagonal.
  template <TreeOf<T> AnyTree> void run(const AnyTree& tree, const T* q, const T* armature, T* out) noexcept {
    const Link<Rep, T>* link = links.run(tree, q);
    const int nv = tree->nv;
    const auto at = [&](int r, int c) -> T& { return out[static_cast<std::ptrdiff_t>(r) * nv + c]; };
    joint_columns(tree, link, S);
    M[0] = {};
    for (int i = 1; i <= tree->n; ++i) M[i] = link[i].inertia(tree.M[i]);
    for (int i = tree->n; i > 0; --i) M[tree->parent[i]] += link[i].up(M[i]);
    for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(nv) * nv; ++k) out[k] = T(0);
    for (int c = 0; c < nv; ++c) at(c, c) = armature[c];
    for (int i = tree->n; i > 0; --i) {
      for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
        const int c = tree->iv[i] + s - tree->first_screw[i];
        Wrench<Rep, T> F = impulse(link[i], M[i], S[s]);
        for (int r = tree->first_screw[i]; r < tree->first_screw[i + 1]; ++r)
          at(c, tree->iv[i] + r - tree->first_screw[i]) += F | S[r];
        for (int j = i; tree->parent[j] > 0;) {
          F = link[j].up(F);
          j = tree->parent[j];
          for (int r = tree->first_screw[j]; r < tree->first_screw[j + 1]; ++r) {
            const int b = tree->iv[j] + r - tree->first_screw[j];
            const T M_cb = F | S[r];
            at(c, b) += M_cb;
            at(b, c) += M_cb;
          }
        }
      }
    }
  }
};

}  // namespace axode
