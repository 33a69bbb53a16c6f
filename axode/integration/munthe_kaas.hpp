#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "axode/integration/configuration_group.hpp"
#include "axode/integration/tableau.hpp"

namespace axode {

/// One step of an explicit Runge-Kutta method on (q, v), q on its group (Munthe-Kaas):
///   θ_i = h Σ a_ij K_j,  V_i = v + h Σ a_ij L_j,  L_i = a(t + c_i h, q ⊕ θ_i, V_i),  K_i = dexp⁻¹_{-θ_i} V_i.
/// With one stage it is Euler's, semi-implicit: q moves with the new v.
class MuntheKaas {
 public:
  using Numbers = std::vector<double>;

  MuntheKaas(const Tree<double>& tree, const Tableau& method)
      : theta(static_cast<std::size_t>(tree->nv)),
        v(theta.size()),
        error_theta(theta.size()),
        error_v(theta.size()),
        group_(tree),
        method_(&method),
        K_(method.b.size() * theta.size()),
        L_(K_.size()),
        q_(static_cast<std::size_t>(tree->nq)) {}

  /// From (q0, v0), where the acceleration is a0, over h. accelerate(t, q, v, a) writes a and returns whether it could; where
  /// it could not, neither can this.
  template <class Accelerate>
  bool run(double t, const double* q0, const double* v0, const double* a0, double h,
           const Accelerate& accelerate) {
    const Tableau& m = *method_;
    const std::size_t nv = theta.size();
    std::copy_n(v0, nv, K_.data()), std::copy_n(a0, nv, L_.data());
    for (std::size_t i = 1; i < m.b.size(); ++i) {
      sum(m.a[i], h, K_, theta), advance(m.a[i], h, v0);
      group_.move(q0, theta.data(), q_.data());
      if (!accelerate(t + m.c[i] * h, std::span<const double>(q_), std::span<const double>(v),
                      std::span(L_).subspan(i * nv, nv)))
        return false;
      group_.rate(theta.data(), v.data(), &K_[i * nv]);
    }
    if (!m.error.empty()) sum(m.error, h, K_, error_theta), sum(m.error, h, L_, error_v);
    advance(m.b, h, v0);
    if (m.b.size() == 1) std::ranges::copy(v, K_.begin());
    sum(m.b, h, K_, theta);
    return true;
  }

  Numbers theta, v;              ///< after run(): the step of q, and v at its end
  Numbers error_theta, error_v;  ///< of an embedded method

  /// The acceleration at the end of the step where the last stage is there, otherwise nothing.
  std::span<const double> end() const {
    const Tableau& m = *method_;
    const bool there = m.b.back() == 0 && std::equal(m.a.back().begin(), m.a.back().end(), m.b.begin());
    return std::span(L_).last(there ? v.size() : 0);
  }

 private:
  /// out = h Σ w_j x_j.
  static void sum(const Numbers& weights, double h, const Numbers& x, Numbers& out) {
    std::ranges::fill(out, 0.0);
    for (std::size_t j = 0; j < weights.size(); ++j)
      if (const double w = h * weights[j]; w != 0)
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += w * x[j * out.size() + c];
  }
  /// v = v0 + h Σ w_j L_j.
  void advance(const Numbers& weights, double h, const double* v0) {
    sum(weights, h, L_, v);
    for (std::size_t c = 0; c < v.size(); ++c) v[c] += v0[c];
  }

  ConfigurationGroup<double> group_;
  const Tableau* method_;
  Numbers K_, L_, q_;
};

}  // namespace axode
