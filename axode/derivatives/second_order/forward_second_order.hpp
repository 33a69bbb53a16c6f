#pragma once
#include "axode/derivatives/displacement/forward_first_order.hpp"
#include "axode/derivatives/second_order/second_order.hpp"

namespace axode {

/// Computes the second derivatives of w·a by the pairs of variables (q, q), (q, v), (v, v) and (τ, q), with
/// the accelerations a of forward dynamics and constant weights w ((D2.9) of docs/derivations). Writes them
/// to the blocks of H, nv × nv numbers each; H.aq receives those by (τ, q). Before the call,
/// SecondOrder::run() must have computed in `second` the quantities from which the second derivatives of
/// inverse dynamics follow, at the accelerations a and for the weights -M⁻¹ w with the mass matrix M.
/// solve(X) must replace an nv × nv matrix X by M⁻¹ X.
template <class T, class Real, class Solve>
void accelerations_from(SecondOrder<T>& second, const Tree<Real>& tree, const Loads<T>& loads,
                        const HessianBlocks<T>& H, const Solve& solve) noexcept {
  const Topology& topology = *tree.operator->();
  const std::ptrdiff_t nv = topology.nv;
  const bool loaded = !loads.wrenches.empty();
  for (T* const block : {H.qq, H.qv, H.vv, H.aq}) std::fill_n(block, nv * nv, T(0));
  second.add_to(topology, loaded, {nullptr, nullptr, nullptr, H.aq});
  solve(H.aq);
  // Adds Pᵀ to qq and the transpose of -tauqᵀ ∂τ/∂v to qv; their rows are sums of rows of tauq.
  const auto subtract = [&](T* block, std::ptrdiff_t direction, std::ptrdiff_t component, const T& x) {
    const T* const from = H.aq + component * nv;
    T* const to = block + direction * nv;
    for (std::ptrdiff_t k = 0; k < nv; ++k) to[k] -= x * from[k];
  };
  second.first.each_entry(
      tree, loads, [&](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { subtract(H.qq, c, r, x); },
      [&](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { subtract(H.qv, c, r, x); });
  for (std::ptrdiff_t r = 0; r < nv; ++r)
    for (std::ptrdiff_t c = 0; c <= r; ++c) {
      T &a = H.qq[r * nv + c], &b = H.qq[c * nv + r];
      a = b = a + b;
      if (c < r) std::swap(H.qv[r * nv + c], H.qv[c * nv + r]);
    }
  second.add_to(topology, loaded, {H.qq, H.qv, H.vv, nullptr});
}

/// Computes the second derivatives of w·a, the sum of the accelerations a of forward dynamics with constant
/// weights w, at a state (q, v) with forces τ. They are by the pairs (q, q), (q, v), (v, v) and (τ, q). If
/// the mass matrix is singular, they are NaN.
template <class T> struct ForwardSecondOrder {
  AccelerationsAndColumns<T> forward;
  SecondOrder<T> second;
  ForcesByState<T> of_forces;
  T* by_q;  ///< P of (D2.9)
  T* by_v;  ///< -τqᵀ ∂τ/∂v of (D2.9)
  T* mu;

  explicit ForwardSecondOrder(Arena& arena)
      : forward(arena),
        second(arena),
        of_forces(arena),
        by_q(of_forces.matrix(arena, static_cast<std::size_t>(arena.topology().nv))),
        by_v(of_forces.matrix(arena, static_cast<std::size_t>(arena.topology().nv))),
        mu(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const T* w,
                  const Loads<T>& loads, const HessianBlocks<T>& H) noexcept {
    const std::ptrdiff_t nv = tree->nv;
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    if (!verdict.ok()) {
      for (T* const block : {H.qq, H.qv, H.vv, H.aq})
        std::fill_n(block, nv * nv, T(std::numeric_limits<double>::quiet_NaN()));
      return verdict;
    }
    for (int c = 0; c < nv; ++c) mu[c] = -w[c];
    forward.solve_one(tree, mu);
    second.run(tree, q, v, forward.a, mu, loads);
    if (!forward.is_fast || nv > ForcesByState<T>::most_velocities) {
      accelerations_from(second, tree, loads, H, [&](T* x) { forward.solve(tree, x); });
      return verdict;
    }
    second.write(*tree.operator->(), !loads.wrenches.empty(), H);
    forward.solve(tree, H.aq);
    of_forces.take(second.first, tree, loads);
    of_forces.multiply(*tree.operator->(), H.aq, by_q, by_v);
    for (std::ptrdiff_t k = 0; k < nv * nv; ++k) H.qv[k] += by_v[k];
    for (std::ptrdiff_t r = 0; r < nv; ++r)
      for (std::ptrdiff_t c = 0; c < nv; ++c) H.qq[r * nv + c] += by_q[r * nv + c] + by_q[c * nv + r];
    return verdict;
  }
};

}  // namespace axode
