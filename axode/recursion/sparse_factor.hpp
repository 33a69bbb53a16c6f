#pragma once
#include "axode/model/tree.hpp"
#include "axode/recursion/solvability.hpp"

/// M = LᵀDL without fill-in (Featherstone), in the memory of M: D on the diagonal, L below it. Row c has
/// entries in the columns parent(c), parent(parent(c)), ...
namespace axode {

/// M to its factors; `fed` is, for each velocity, the size of the inertia that feeds it. Above the diagonal stand the sizes
/// of the numbers of which the pivots are left: what feeds a velocity, what follows it as the later ones give
/// way, and what is subtracted for them.
template <class T, class Judge>
void factorize(const Tree<T>& tree, const T* fed, T* H, Judge& judge) noexcept {
  const int nv = tree->nv;
  const std::vector<int>& parent = tree->velocity_parent;
  const auto at = [&](int r, int c) -> T& { return H[static_cast<std::ptrdiff_t>(r) * nv + c]; };
  const auto fed_alone = [&](int c) { return select(fed[c] < at(c, c), at(c, c), fed[c]); };
  for (int c = 0; c + 1 < nv; ++c) at(c, c + 1) = fed_alone(c);
  for (int c = nv - 1; c >= 0; --c) {
    const T size = c + 1 < nv ? at(c, c + 1) : fed_alone(c);
    judge.see(c, at(c, c), [&] { return size; });
    for (int i = parent[c]; i >= 0; i = parent[i]) {
      const T L_ci = at(c, i) / at(c, c);
      at(i, i + 1) += L_ci * L_ci * (size + at(c, c));
      for (int j = i; j >= 0; j = parent[j]) at(i, j) -= L_ci * at(c, j);
      at(c, i) = L_ci;
    }
  }
}

/// x := (LᵀDL)⁻¹ x.
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
