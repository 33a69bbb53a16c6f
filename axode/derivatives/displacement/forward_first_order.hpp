#pragma once
#include "axode/derivatives/displacement/accelerations.hpp"
#include "axode/derivatives/displacement/first_order.hpp"

namespace axode {

/// The derivatives ∂τ/∂q and ∂τ/∂v of inverse dynamics side by side, and their products with the inverse mass
/// matrix. The entries of the derivatives are non-zero only for pairs of velocities on one path to the
/// ground.
template <class T> struct ForcesByState {
  using L = Lanes<T>;
  using Number = typename L::Number;
  /// The largest number of velocities for which the derivatives -M⁻¹ ∂τ/∂q and -M⁻¹ ∂τ/∂v of the
  /// accelerations are computed as products of matrices, with the mass matrix M and the forces τ of inverse
  /// dynamics. For trees with more velocities, articulated bodies are faster, and memory for the products is
  /// not allocated.
  static constexpr int most_velocities = 100;

  std::ptrdiff_t stride;  ///< numbers in a row of one matrix, filled up to whole registers
  T* by_state;            ///< ∂τ/∂q and ∂τ/∂v side by side
  Number* entries;        ///< the non-zero rows of some columns of -∂τ/∂q and -∂τ/∂v, in turn
  std::ptrdiff_t* rows;   ///< offsets of the same rows in the matrix A of multiply()

  explicit ForcesByState(Arena& arena)
      : stride((arena.topology().nv + L::width - 1) / L::width * L::width),
        by_state(matrix(arena, static_cast<std::size_t>(2 * stride))),
        entries(arena.array<Number>(2 * static_cast<std::size_t>(arena.topology().nv))),
        rows(arena.per_velocity<std::ptrdiff_t>()) {}

  /// Memory for a matrix with a row for each velocity and a number of columns; none for large trees.
  static T* matrix(Arena& arena, std::size_t columns) {
    const int nv = arena.topology().nv;
    return arena.lines<T>(nv > most_velocities ? 0 : columns * static_cast<std::size_t>(nv));
  }

  /// Takes the derivatives from `inverse`, of a tree without couplings.
  template <class Real>
  void take(const FirstOrder<T>& inverse, const Tree<Real>& tree, const Loads<T>& loads) noexcept {
    inverse.write(tree, loads, 2 * stride, by_state, by_state + stride);
  }
  /// Writes -Aᵀ ∂τ/∂q to dq and -Aᵀ ∂τ/∂v to dv, for a matrix A; all are nv × nv.
  void multiply(const Topology& topology, const T* A, T* dq, T* dv) noexcept {
    for (int c = last_block<T>(topology.nv); c >= 0; c -= L::width) multiply(topology, A, c, dq, dv);
  }

 private:
  /// Writes the columns c, c + 1, ... of -Aᵀ ∂τ/∂q to dq and of -Aᵀ ∂τ/∂v to dv, one column in each SIMD
  /// lane. Lanes beyond the last column overwrite the first columns of the next row. Columns with larger
  /// indices must therefore have been written before.
  void multiply(const Topology& topology, const T* A, int c, T* dq, T* dv) noexcept {
    constexpr int at_once = 4;  // rows of each result, so that no sum waits for another one
    const int nv = topology.nv;
    int n = 0, end = c;
    for (int k = c; k < std::min(c + L::width, nv); ++k) end = std::max(end, topology.velocity_end[k]);
    for (int r = 0; r < end; ++r) {
      if (topology.velocity_end[r] <= c) continue;
      const T* const row = by_state + 2 * r * stride + c;
      rows[n] = static_cast<std::ptrdiff_t>(r) * nv;
      entries[2 * n] = -L::load(row);
      entries[2 * n + 1] = -L::load(row + stride);
      ++n;
    }
    for (int r = 0; r < nv; r += at_once) {
      Number by_q[at_once], by_v[at_once];
      for (int m = 0; m < at_once; ++m) by_q[m] = by_v[m] = Number(T(0));
      int row[at_once];
      for (int m = 0; m < at_once; ++m) row[m] = std::min(r + m, nv - 1);
      for (int k = 0; k < n; ++k) {
        const T* const factor = A + rows[k];
        for (int m = 0; m < at_once; ++m) {
          const Number f(factor[row[m]]);
          by_q[m] += f * entries[2 * k];
          by_v[m] += f * entries[2 * k + 1];
        }
      }
      for (int m = 0; m < at_once; ++m) {
        store_row<T>(by_q[m], r + m, c, nv, dq + (r + m) * static_cast<std::ptrdiff_t>(nv) + c);
        store_row<T>(by_v[m], r + m, c, nv, dv + (r + m) * static_cast<std::ptrdiff_t>(nv) + c);
      }
    }
  }
};

/// Computes ∂a/∂q, ∂a/∂v and ∂a/∂τ of forward dynamics: ∂a/∂τ is the inverse M⁻¹ of the mass matrix, and the
/// others are -M⁻¹ times ∂τ/∂q and ∂τ/∂v of inverse dynamics at the accelerations a ((D1.24) of
/// docs/derivations).
template <class T> struct ForwardFirstOrder {
  AccelerationsAndColumns<T> forward;
  FirstOrder<T> inverse;
  ForcesByState<T> of_forces;

  explicit ForwardFirstOrder(Arena& arena) : forward(arena), inverse(arena), of_forces(arena) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const Loads<T>& loads, T* dq,
                  T* dv, T* dtau) noexcept {
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(tree->nv) * tree->nv;
    if (!verdict.ok()) {
      for (T* const matrix : {dq, dv, dtau})
        std::fill_n(matrix, size, T(std::numeric_limits<double>::quiet_NaN()));
      return verdict;
    }
    inverse.run(tree, q, v, forward.a, loads);
    if (forward.is_fast && tree->nv <= ForcesByState<T>::most_velocities) {
      of_forces.take(inverse, tree, loads);
      forward.inverse(tree, dtau);
      of_forces.multiply(*tree.operator->(), dtau, dq, dv);
    } else {
      inverse.write(tree, loads, dq, dv, dtau);
      forward.inverse(tree, dtau);
      for (T* const matrix : {dq, dv}) {
        for (std::ptrdiff_t k = 0; k < size; ++k) matrix[k] = -matrix[k];
        forward.solve(tree, matrix);
      }
    }
    return verdict;
  }
};

}  // namespace axode
