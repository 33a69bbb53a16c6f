#pragma once
#include "axode/derivatives/accelerations.hpp"
#include "axode/derivatives/second_order.hpp"

namespace axode {

/// The second derivatives of w·a of forward dynamics. With a(q, v, τ), μ = -M⁻¹ w, the blocks H of μ·τ at these accelerations and
/// Q = H_aq:
///   tauq = M⁻¹ Q    qq = H_qq + P + Pᵀ, P = -tauqᵀ ∂τ/∂q    qv = H_qv - tauqᵀ ∂τ/∂v    vv = H_vv.
/// No matrix but the results is kept: products with ∂τ/∂q and ∂τ/∂v are added entry by entry.
template <class T> struct ForwardSecondOrder {
  AccelerationsAndColumns<T> forward;
  SecondOrder<T> second;
  T* mu;

  explicit ForwardSecondOrder(Arena& arena) : forward(arena), second(arena), mu(arena.per_velocity<T>()) {}

  Solvability run(const Tree<T>& tree, const T* q, const T* v, const T* tau, const T* w,
                  const Loads<T>& loads, T* qq, T* qv, T* vv, T* tauq) noexcept {
    const Topology& topology = *tree.topology();
    const std::ptrdiff_t nv = tree->nv;
    const Solvability verdict = forward.run(tree, q, v, tau, loads);
    const auto fill = [&](const T& x) {
      for (T* const block : {qq, qv, vv, tauq}) std::fill_n(block, nv * nv, x);
      return verdict;
    };
    if (!verdict.ok()) return fill(T(std::numeric_limits<double>::quiet_NaN()));
    for (int c = 0; c < nv; ++c) mu[c] = -w[c];
    forward.solve_one(tree, mu);
    second.run(tree, q, v, forward.a, mu, loads);
    static_cast<void>(fill(T(0)));
    const bool loaded = !loads.wrenches.empty();
    second.add_to(topology, loaded, {nullptr, nullptr, nullptr, tauq});
    forward.solve(tree, tauq);
    // Pᵀ and (Qᵀ ∂a/∂v)ᵀ, whose rows are sums of rows of tauq.
    const auto subtract = [&](T* block, std::ptrdiff_t direction, std::ptrdiff_t component, const T& x) {
      const T* const from = tauq + component * nv;
      T* const to = block + direction * nv;
      for (std::ptrdiff_t k = 0; k < nv; ++k) to[k] -= x * from[k];
    };
    second.first.each_entry(
        tree, loads, [&](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { subtract(qq, c, r, x); },
        [&](std::ptrdiff_t r, std::ptrdiff_t c, const T& x) { subtract(qv, c, r, x); });
    for (std::ptrdiff_t r = 0; r < nv; ++r)
      for (std::ptrdiff_t c = 0; c <= r; ++c) {
        T &a = qq[r * nv + c], &b = qq[c * nv + r];
        a = b = a + b;
        if (c < r) std::swap(qv[r * nv + c], qv[c * nv + r]);
      }
    second.add_to(topology, loaded, {qq, qv, vv, nullptr});
    return verdict;
  }
};

}  // namespace axode
