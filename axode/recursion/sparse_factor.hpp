#pragma once
#include "axode/model/tree.hpp"
#include "axode/recursion/solvability.hpp"

/// The factorisation M = LᵀDL of a mass matrix without fill-in (Featherstone), in the memory of M: D is on
/// the diagonal, and L is below it. Row c has entries in the columns parent(c), parent(parent(c)), ..., where
/// parent is Topology::velocity_parent.
namespace axode {

/// Factorises the mass matrix H = LᵀDL in place (nv × nv, row by row; (D4.7) and (D4.8) of docs/derivations).
/// Calls check.add(c, D_c, scale) for the pivot D_c of each velocity c. scale() computes the magnitude of the
/// numbers from which D_c results, and overwrites H above its diagonal. For this, `inertia_scale` must have
/// for each velocity the magnitude of the inertia that moves with it at q = 0 (nv numbers, kg m² or kg; see
/// Tree::inertia_scale). If scale() is called for all pivots, this costs another O(n d²) for a tree of depth
/// d.
template <class T, class Check>
void factorize(const Tree<T>& tree, const T* inertia_scale, T* H, Check& check) noexcept {
  const int nv = tree->nv;
  const bool coupled = !tree->coupled_bodies.empty();
  const std::vector<int>& parent = tree->velocity_parent;
  const auto at = [&](int r, int c) -> T& { return H[static_cast<std::ptrdiff_t>(r) * nv + c]; };
  for (int c = nv - 1; c >= 0; --c) {
    check.add(c, at(c, c), [&] {
      T* const z = &at(c, 0);
      T size = select(inertia_scale[c] < at(c, c), sqrt(at(c, c)), sqrt(inertia_scale[c]));
      for (int k = c + 1, end = coupled ? nv : tree->velocity_end[c]; k < end; ++k) {
        T sum(0);
        int i = parent[k];
        for (; i > c; i = parent[i]) sum += at(k, i) * z[i];
        if (i == c) sum += at(k, c);
        z[k] = -sum;
        size += select(sum < T(0), -sum, sum) * sqrt(inertia_scale[k]);
      }
      return size * size;
    });
    for (int i = parent[c]; i >= 0; i = parent[i]) {
      const T L_ci = at(c, i) / at(c, c);
      for (int j = i; j >= 0; j = parent[j]) at(i, j) -= L_ci * at(c, j);
      at(c, i) = L_ci;
    }
  }
}

/// Replaces x (nv numbers) by (LᵀDL)⁻¹ x, with the factors that factorize() has left in H.
template <class T> void solve(const Tree<T>& tree, const T* H, T* x) noexcept {
  const int nv = tree->nv;
  const std::vector<int>& parent = tree->velocity_parent;
  for (int c = nv - 1; c >= 0; --c)
    for (int i = parent[c]; i >= 0; i = parent[i]) x[i] -= H[static_cast<std::ptrdiff_t>(c) * nv + i] * x[c];
  for (int c = 0; c < nv; ++c) {
    const T* row = H + static_cast<std::ptrdiff_t>(c) * nv;
    x[c] = x[c] / row[c];
    for (int i = parent[c]; i >= 0; i = parent[i]) x[c] -= row[i] * x[i];
  }
}

}  // namespace axode
