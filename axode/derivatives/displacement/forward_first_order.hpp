#pragma once
#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/first_order.hpp"

namespace axode {

/// Computes ∂a/∂q, ∂a/∂v and ∂a/∂τ of forward dynamics: ∂a/∂τ is the inverse M⁻¹ of the mass matrix, and the
/// others are -M⁻¹ times ∂τ/∂q and ∂τ/∂v of inverse dynamics at the accelerations a ((D1.24) of
/// docs/derivations).
template <class T> struct ForwardFirstOrder {
  AccelerationsAndColumns<T> forward;
  FirstOrder<T> inverse;

  explicit ForwardFirstOrder(Arena& arena) : forward(arena), inverse(arena) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads, T* dq,
                  T* dv, T* dtau) noexcept {
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    const std::ptrdiff_t entries = static_cast<std::ptrdiff_t>(tree->nv) * tree->nv;
    if (!verdict.ok()) {
      for (T* const matrix : {dq, dv, dtau})
        std::fill_n(matrix, entries, T(std::numeric_limits<double>::quiet_NaN()));
      return verdict;
    }
    inverse.run(tree, q, v, forward.a, loads);
    inverse.write(tree, loads, dq, dv, dtau);
    forward.inverse(tree, dtau);
    for (T* const matrix : {dq, dv}) {
      for (std::ptrdiff_t k = 0; k < entries; ++k) matrix[k] = -matrix[k];
      forward.solve(tree, dtau, matrix);
    }
    return verdict;
  }
};

}  // namespace axode
