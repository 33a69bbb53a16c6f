#pragma once
#include "axode/recursion/solvability.hpp"

namespace axode {

/// The inverse mass matrix M⁻¹ from M = LᵀDL, for states in SIMD lanes. On trees with short paths this takes
/// fewer operations than the articulated-body algorithm. The path of a velocity i has i itself, the earlier
/// velocities of its joint, and the velocities of all joints between this joint and the ground. L_ci is 0
/// unless i is on the path of c, and X = L⁻ᵀ has the transposed pattern. M⁻¹_ij = Σ_k X_ki X_kj / D_k, summed
/// over the velocities k that are on the paths of both i and j. O(nv² d) if paths have at most d velocities.
template <class T> struct FastInverseMassMatrix {
  static constexpr int longest_path = 16;
  static constexpr int most_velocities = 64;
  T* X;
  T* D_inv;
  T* x;
  /// Whether a pivot has lost more than two digits, or M may be singular.
  decltype(T() < T()) maybe_singular{};

  /// Whether the paths of a tree are short enough for this method.
  template <class S> static bool suits(const Tree<S>& tree) {
    return tree->depth <= longest_path && tree->nv <= most_velocities;
  }

  explicit FastInverseMassMatrix(Arena& arena)
      : X(arena.array<T>(static_cast<std::size_t>(arena.topology().nv) *
                         static_cast<std::size_t>(arena.topology().nv))),
        D_inv(arena.per_velocity<T>()),
        x(arena.per_velocity<T>()) {}

  /// Replaces M (nv × nv) by M⁻¹. Reads only entries M_ij with j <= i: those for which the velocities i and j
  /// belong to one joint, or the joint of j is on the path from the ground to the joint of i.
  template <class S> void run(const Tree<S>& tree, T* M) noexcept {
    factorize(tree, M);
    multiply(tree, M);
  }

 private:
  /// Computes the pivots D_i of the mass matrix M = LᵀDL and the rows of X = L⁻ᵀ, from the last row to the
  /// first. In the memory of M, row i becomes D_i L_ij = M_ij - Σ_c L_ci D_c L_cj for j <= i. Row i of X has
  /// X_ii = 1 and X_ij = -Σ_c L_ci X_cj for j > i. The sums are over c > i. The array x is scratch memory and
  /// holds -L_ci of the present row i for all c > i.
  template <class S> void factorize(const Tree<S>& tree, T* M) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    const int* const parent = tree->velocity_parent.data();
    for (int i = tree->nv - 1; i >= 0; --i) {
      const int end = tree->velocity_end[i];
      T* const M_i = M + i * nv;
      T* const X_i = X + i * nv;
      const T M_ii = M_i[i];
      for (int c = i + 1; c < end; ++c) x[c] = -(M[c * nv + i] * D_inv[c]);
      for (int j = i; j >= 0; j = parent[j]) {
        T sum = M_i[j];
        for (int c = i + 1; c < end; ++c) sum += x[c] * M[c * nv + j];
        M_i[j] = sum;
      }
      maybe_singular = maybe_singular || !(M_i[i] > T(0.01) * M_ii) ||
                       !(M_i[i] > T(pivot_threshold<S> * tree.inertia_scale[i]));
      D_inv[i] = T(1) / M_i[i];
      X_i[i] = T(1);
      for (int j = i + 1; j < end; ++j) {
        T sum = x[j];
        for (int c = parent[j]; c > i; c = parent[c]) sum += x[c] * X[c * nv + j];
        X_i[j] = sum;
      }
    }
  }
  /// Computes M⁻¹_ij = Σ_k X_ki X_kj / D_k for j >= i, and the other entries by symmetry. X is L⁻ᵀ for the
  /// mass matrix M = LᵀDL with the pivots D_k.
  template <class S> void multiply(const Tree<S>& tree, T* out) const noexcept {
    const std::ptrdiff_t nv = tree->nv;
    const int* const parent = tree->velocity_parent.data();
    for (int i = 0; i < tree->nv; ++i) {
      const T* X_k[longest_path];
      int n = 0;
      for (int k = i; k >= 0; k = parent[k], ++n) {
        X_k[n] = X + k * nv;
        x[n] = X_k[n][i] * D_inv[k];
      }
      for (int j = i, k = i, first = 0; j < tree->nv; ++j) {
        while (k >= 0 && tree->velocity_end[k] <= j) {
          k = parent[k];
          ++first;
        }
        T sum(0);
        for (int l = first; l < n; ++l) sum += x[l] * X_k[l][j];
        out[i * nv + j] = out[j * nv + i] = sum;
      }
    }
  }
};

}  // namespace axode
