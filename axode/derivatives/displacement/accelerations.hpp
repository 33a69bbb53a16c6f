#pragma once
#include <algorithm>

#include "axode/fast/forward_dynamics.hpp"
#include "axode/recursion/forward_dynamics.hpp"

namespace axode {

/// Computes accelerations by forward dynamics, and products M⁻¹ X of matrices X of nv columns with the
/// inverse of the mass matrix M.
template <class T> struct AccelerationsAndColumns {
  /// The largest number of velocities for which products with M⁻¹ are faster than articulated bodies.
  static constexpr int most_velocities = 100;
  FastForwardDynamics<T> fast;
  using Bodies = typename FastForwardDynamics<T>::Bodies;
  typename Bodies::Columns* columns;
  typename Bodies::Several* u;
  int* rows;
  ForwardDynamicsRecursion<Hybrid, T> any;
  T *a, *x;
  bool is_fast = false;

  explicit AccelerationsAndColumns(Arena& arena)
      : fast(arena),
        columns(arena.per_body<typename Bodies::Columns>()),
        u(arena.per_screw<typename Bodies::Several>()),
        rows(arena.per_velocity<int>()),
        any(arena),
        a(arena.per_velocity<T>()),
        x(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads) noexcept {
    is_fast = fast.run(tree, q, v, tau, loads, a);
    return is_fast ? solved(Solvability{}, tree->nv, a) : any.run(tree, q, v, tau, loads, a);
  }
  void solve(const Tree<T>& tree, T* matrix) noexcept {
    if (is_fast) return fast.bodies.solve(tree, columns, u, matrix);
    const std::ptrdiff_t nv = tree->nv;
    for (std::ptrdiff_t c = 0; c < nv; ++c) {
      for (std::ptrdiff_t r = 0; r < nv; ++r) x[r] = matrix[r * nv + c];
      any.bodies.solve(tree, x);
      for (std::ptrdiff_t r = 0; r < nv; ++r) matrix[r * nv + c] = x[r];
    }
  }
  /// Replaces the matrix X by M⁻¹ X, where the inverse M⁻¹ of the mass matrix is given. X may have non-zero
  /// entries only for pairs of velocities on one path to the ground.
  void solve(const Tree<T>& tree, const T* M_inverse, T* matrix) noexcept {
    if (!is_fast || tree->nv > most_velocities) return solve(tree, matrix);
    using L = Lanes<T>;
    const int nv = tree->nv;
    for (int first = 0; first < nv; first += L::width) {
      int n = 0, end = first;
      for (int c = first; c < std::min(first + L::width, nv); ++c) end = std::max(end, tree->velocity_end[c]);
      T* const columns_of = matrix + first;
      for (int r = 0; r < end; ++r) {
        if (tree->velocity_end[r] <= first) continue;
        rows[n] = r;
        u[n++] = L::load(columns_of + r * nv, nv - first);
      }
      for (int r = 0; r < nv; r += 4) {  // four rows of the result at once, so that no sum waits
                                         // for another one
        const int row[]{r, std::min(r + 1, nv - 1), std::min(r + 2, nv - 1), std::min(r + 3, nv - 1)};
        typename L::Number sum[4]{T(0), T(0), T(0), T(0)};
        for (int k = 0; k < n; ++k) {
          const T* const factor = M_inverse + rows[k] * nv;
          for (int m = 0; m < 4; ++m) sum[m] = sum[m] + factor[row[m]] * u[k];
        }
        for (int m = 0; m < 4; ++m) L::store(sum[m], columns_of + row[m] * nv, nv - first);
      }
    }
  }
  /// Replaces one vector y by M⁻¹ y.
  void solve_one(const Tree<T>& tree, T* y) noexcept {
    if (is_fast)
      fast.bodies.solve_one(tree, fast.motion, y);
    else
      any.bodies.solve(tree, y);
  }
  void inverse(const Tree<T>& tree, T* M_inverse) noexcept {
    if (is_fast) return fast.bodies.inverse(tree, columns, u, M_inverse);
    const std::ptrdiff_t nv = tree->nv;
    std::fill_n(M_inverse, nv * nv, T(0));
    for (std::ptrdiff_t c = 0; c < nv; ++c) {
      M_inverse[c * nv + c] = T(1);
      any.bodies.solve(tree, M_inverse + c * nv);
    }
  }
};

}  // namespace axode
