#pragma once
#include <limits>

#include "axode/dynamics/articulated_inertia.hpp"
#include "axode/kinematics/forward_recursion.hpp"

namespace axode {

/// Whether a pivot of the mass matrix counts as 0: it is what remains of the diagonal entry M_cc after the
/// other joints have given way.
template <class T> constexpr bool is_singular(const T& pivot, const T& M_cc) {
  return pivot <= T(0) || pivot <= T(16) * std::numeric_limits<T>::epsilon() * M_cc;
}

/// The articulated-body algorithm: M a = τ in O(n), for trees without coupled joints.
///
/// A joint with several degrees of freedom gives way in one after the other, like a chain of joints through
/// massless bodies. For each screw S_c, from the leaves to the roots, with M_i^A of the body behind it:
///   U = M_i^A S,  D = Sᵀ U + armature,  M_i^A -= U Uᵀ / D;   at the end of a joint M_p^A += up M_i^A
template <class Rep, class T> struct ArticulatedBodies {
  Link<Rep, T>* link = nullptr;
  ArticulatedInertia<Rep, T>* M = nullptr;
  Inertia<T>* composite = nullptr;
  Wrench<Rep, T>* W = nullptr;
  Twist<Rep, T>* X = nullptr;
  Twist<Rep, T>* S = nullptr;
  Wrench<Rep, T>* U = nullptr;
  T* D = nullptr;
  T* u = nullptr;

  ArticulatedBodies() = default;
  explicit ArticulatedBodies(typename Workspace<T>::Arena& arena, Link<Rep, T>* links)
      : link(links),
        M(arena.template per_body<ArticulatedInertia<Rep, T>>()),
        composite(arena.template per_body<Inertia<T>>()),
        W(arena.template per_body<Wrench<Rep, T>>()),
        X(arena.template per_body<Twist<Rep, T>>()),
        S(arena.template per_screw<Twist<Rep, T>>()),
        U(arena.template per_screw<Wrench<Rep, T>>()),
        D(arena.template per_screw<T>()),
        u(arena.template per_screw<T>()) {}

  /// Joint screws, U and D at the configuration of the links. judge(i, c, D, M_cc) sees the pivot of every
  /// screw c of body i before it divides.
  template <TreeOf<T> AnyTree, class Judge>
  void factorize(const AnyTree& tree, const T* armature, Judge&& judge) noexcept {
    joint_columns(tree, link, S);
    composite[0] = {}, M[0] = {};
    for (int i = 1; i <= tree.n; ++i) {
      composite[i] = inertia(link[i], tree.M[i]);
      M[i] = articulated(link[i], composite[i]);
    }
    for (int i = tree.n; i > 0; --i) {
      const int first = tree.first_screw[i];
      for (int c = tree.first_screw[i + 1] - 1; c >= first; --c) {
        const T I = armature[tree.iv[i] + c - first];
        U[c] = M[i] * S[c];
        D[c] = (U[c] | S[c]) + I;
        judge(i, c, D[c], (impulse(link[i], composite[i], S[c]) | S[c]) + I);
        give_way(M[i], U[c], D[c]);
      }
      const int p = tree.parent[i];
      M[p] += up(link[i], M[i]);
      composite[p] += up(link[i], composite[i]);
    }
  }
  /// Returns the body of the first joint that moves no mass, or 0.
  template <TreeOf<T> AnyTree> int factorize(const AnyTree& tree, const T* armature) noexcept {
    int singular_body = 0;
    factorize(tree, armature, [&](int i, int, const T& pivot, const T& M_cc) {
      if (is_singular(pivot, M_cc)) singular_body = i;
    });
    return singular_body;
  }

  /// x := M⁻¹ x.
  void solve(const Tree<T>& tree, T* x) const noexcept {
    for (int i = 0; i <= tree.n; ++i) W[i] = {};
    for (int i = tree.n; i > 0; --i) {
      const int first = tree.first_screw[i];
      for (int c = tree.first_screw[i + 1] - 1; c >= first; --c) {
        u[c] = x[tree.iv[i] + c - first] - (W[i] | S[c]);
        W[i] += (u[c] / D[c]) * U[c];
      }
      W[tree.parent[i]] += link[i].up(W[i]);
    }
    X[0] = {};
    for (int i = 1; i <= tree.n; ++i) {
      X[i] = link[i].down(X[tree.parent[i]]);
      const int first = tree.first_screw[i];
      for (int c = first; c < tree.first_screw[i + 1]; ++c) {
        const T a_c = (u[c] - (U[c] | X[i])) / D[c];
        X[i] += a_c * S[c];
        x[tree.iv[i] + c - first] = a_c;
      }
    }
  }
};

}  // namespace axode
