#pragma once
#include "axode/fast/forward_dynamics.hpp"
#include "axode/recursion/forward_dynamics.hpp"

namespace axode {

/// Computes accelerations by forward dynamics, and products M⁻¹ X of matrices X of nv columns with the
/// inverse of the mass matrix M.
template <class T> struct AccelerationsAndColumns {
  FastForwardDynamics<T> fast;
  using Bodies = typename FastForwardDynamics<T>::Bodies;
  typename Bodies::Columns* columns;
  typename Bodies::Several* u;
  ForwardDynamicsRecursion<Hybrid, T> any;
  T *a, *x;
  bool is_fast = false;

  explicit AccelerationsAndColumns(Arena& arena)
      : fast(arena),
        columns(arena.per_body<typename Bodies::Columns>()),
        u(arena.per_screw<typename Bodies::Several>()),
        any(arena),
        a(arena.per_velocity<T>()),
        x(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads) noexcept {
    is_fast = fast.run(tree, q, v, tau, loads, a);
    return is_fast ? solved(Solvability{}, tree->nv, a) : any.run(tree, q, v, tau, loads, a);
  }
  /// Replaces a matrix X (nv × nv) by M⁻¹ X.
  void solve(const Tree<T>& tree, T* matrix) noexcept {
    if (is_fast) return fast.bodies.solve(tree, columns, u, matrix);
    const std::ptrdiff_t nv = tree->nv;
    for (std::ptrdiff_t c = 0; c < nv; ++c) {
      for (std::ptrdiff_t r = 0; r < nv; ++r) x[r] = matrix[r * nv + c];
      any.bodies.solve(tree, x);
      for (std::ptrdiff_t r = 0; r < nv; ++r) matrix[r * nv + c] = x[r];
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
