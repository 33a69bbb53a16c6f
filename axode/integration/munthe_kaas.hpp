#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "axode/integration/configuration_group.hpp"
#include "axode/integration/tableau.hpp"

namespace axode {

/// One step of an explicit Runge-Kutta method on (q, v), q on its group (Munthe-Kaas):
///   θ_i = h Σ a_ij K_j,  V_i = v + h Σ a_ij L_j,  L_i = a(t + c_i h, q ⊕ θ_i, V_i),  K_i = dexp⁻¹_{-θ_i} V_i.
class MuntheKaas {
 public:
  MuntheKaas(const Tree<double>& tree, const Tableau& method)
      : group_(tree),
        method_(&method),
        nv_(static_cast<std::size_t>(tree->nv)),
        K_(method.b.size() * nv_),
        L_(K_.size()),
        theta(nv_),
        v(nv_),
        error_theta(nv_),
        error_v(nv_),
        q_(static_cast<std::size_t>(tree->nq)) {}

 private:
  using Numbers = std::vector<double>;
  ConfigurationGroup<double> group_;
  const Tableau* method_;
  std::size_t nv_;
  Numbers K_, L_;

 public:
  Numbers theta, v;              ///< after run(): the step of q, and v at its end
  Numbers error_theta, error_v;  ///< of an embedded method

  /// Whether the last stage is the end of the step; then end() has the acceleration there.
  bool ends_with_stage() const {
    const Tableau& m = *method_;
    const std::size_t last = m.b.size() - 1;
    return m.b[last] == 0 && std::equal(m.a[last].begin(), m.a[last].end(), m.b.begin());
  }
  std::span<const double> end() const { return std::span(L_).last(nv_); }

  /// From (q0, v0), where the acceleration is a0, over h. accelerate(t, q, v, a) writes a and returns whether it could; where
  /// it could not, neither can this.
  template <class Accelerate>
  bool run(double t, const double* q0, const double* v0, const double* a0, double h,
           const Accelerate& accelerate) {
    const Tableau& m = *method_;
    for (std::size_t i = 0; i < m.b.size(); ++i) {
      double *const K = &K_[i * nv_], *const L = &L_[i * nv_];
      if (i == 0) {
        std::copy_n(v0, nv_, K), std::copy_n(a0, nv_, L);
        continue;
      }
      sum(m.a[i], h, K_, theta), sum(m.a[i], h, L_, v);
      for (std::size_t c = 0; c < nv_; ++c) v[c] += v0[c];
      group_.move(q0, theta.data(), q_.data());
      if (!accelerate(t + m.c[i] * h, std::span<const double>(q_), std::span<const double>(v),
                      std::span<double>(L, nv_)))
        return false;
      group_.rate(theta.data(), v.data(), K);
    }
    if (!m.error.empty()) sum(m.error, h, K_, error_theta), sum(m.error, h, L_, error_v);
    sum(m.b, h, K_, theta), sum(m.b, h, L_, v);
    for (std::size_t c = 0; c < nv_; ++c) v[c] += v0[c];
    return true;
  }

 private:
  /// out = h Σ w_j x_j.
  void sum(const Numbers& weights, double h, const Numbers& x, Numbers& out) const {
    std::fill(out.begin(), out.end(), 0.0);
    for (std::size_t j = 0; j < weights.size(); ++j)
      if (const double w = h * weights[j]; w != 0)
        for (std::size_t c = 0; c < nv_; ++c) out[c] += w * x[j * nv_ + c];
  }
  Numbers q_;
};

}  // namespace axode
