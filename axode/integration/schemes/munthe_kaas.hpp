#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "axode/integration/configuration_group.hpp"
#include "axode/integration/tableau.hpp"

namespace axode {

/// One step of length h, from time t, of an explicit Runge-Kutta-Munthe-Kaas method on (q, y). The
/// configuration q is on the group of a tree, and y has the velocities or the momenta, and possibly other
/// states. T is the type of the numbers in (q, y), and S that of the numbers in the tree. With the
/// coefficients a_ij and c_i of a Tableau, stage i has
///   θ_i = h Σ a_ij K_j,  Y_i = y + h Σ a_ij L_j,  K_i = dexp⁻¹_{-θ_i} V_i,
/// or K_i = dcay⁻¹_{-θ_i} V_i in Cayley coordinates, with the velocity V_i and the rate L_i = y' at the time
/// t + c_i h and the state (q ⊕ θ_i, Y_i). With one stage the method is Euler's. If y has velocities, Euler's
/// method is semi-implicit, unlike these formulas: q moves along h v with the velocity v at the end of the
/// step.
template <class T = double, class S = T> class MuntheKaas {
 public:
  using Vector = std::vector<T>;

  MuntheKaas(const Tree<S>& tree, const Tableau& method,
             LocalCoordinates coordinates = LocalCoordinates::exponential, std::size_t n_other_states = 0)
      : theta(static_cast<std::size_t>(tree->nv)),
        y(theta.size() + n_other_states),
        error_theta(theta.size()),
        error_y(y.size()),
        group_(tree, coordinates),
        method_(&method),
        K_(method.b.size() * theta.size()),
        L_(method.b.size() * y.size()),
        q_(static_cast<std::size_t>(tree->nq)) {}

  /// Computes a step of length h from (q0, y0), where y are the velocities v, followed by other states if
  /// there are any. dy0 is the rate y' at the start. accelerate(t, q, y, dy) must write the rate dy = y' and
  /// return whether it succeeded. Returns false if it did not.
  template <class Accelerate>
  bool run(double t, const T* q0, const T* y0, const T* dy0, double h, const Accelerate& accelerate) {
    const auto rates = [&](double t_i, std::span<const T> q, std::span<const T> y_i, std::span<T> V,
                           std::span<T> dy) {
      std::copy_n(y_i.begin(), V.size(), V.begin());
      return accelerate(t_i, q, y_i, dy);
    };
    if (!run(t, q0, y0, y0, dy0, h, rates)) return false;
    if (method_->b.size() > 1) return true;
    std::copy_n(y.begin(), theta.size(), K_.begin());
    sum(method_->b, h, K_, theta);
    return true;
  }
  /// Computes a step of length h from (q0, y0), where y are the velocities or momenta, followed by other
  /// states if there are any. At the start the velocity is v0 and the rate y' is dy0. rates(t, q, y, v, dy)
  /// must write the velocity v and the rate dy = y' and return whether it succeeded. Returns false if it did
  /// not.
  template <class Rates>
  bool run(double t, const T* q0, const T* y0, const T* v0, const T* dy0, double h, const Rates& rates) {
    const Tableau& m = *method_;
    const std::size_t nv = theta.size(), ny = y.size();
    std::copy_n(v0, nv, K_.data());
    std::copy_n(dy0, ny, L_.data());
    for (std::size_t i = 1; i < m.b.size(); ++i) {
      sum(m.a[i], h, K_, theta);
      advance(m.a[i], h, y0);
      group_.move(q0, theta.data(), q_.data());
      const std::span<T> V = std::span(K_).subspan(i * nv, nv);
      if (!rates(t + m.c[i] * h, std::span<const T>(q_), std::span<const T>(y), V,
                 std::span(L_).subspan(i * ny, ny)))
        return false;
      group_.rate(theta.data(), V.data(), V.data());
    }
    if (!m.error.empty()) {
      sum(m.error, h, K_, error_theta);
      sum(m.error, h, L_, error_y);
    }
    advance(m.b, h, y0);
    sum(m.b, h, K_, theta);
    return true;
  }

  Vector theta, y;              ///< results of run(): the step θ of q, and y at the end of the step
  Vector error_theta, error_y;  ///< theta and y minus those of the embedded method

  /// The rate y' at the end of the step if the last stage of the method is there; otherwise empty.
  std::span<const T> end() const {
    const Tableau& m = *method_;
    const bool there = m.b.back() == 0 && std::equal(m.a.back().begin(), m.a.back().end(), m.b.begin());
    return std::span(L_).last(there ? y.size() : 0);
  }

 private:
  /// Computes out = h Σ w_j x_j.
  static void sum(const std::vector<double>& weights, double h, const Vector& x, Vector& out) {
    std::ranges::fill(out, T(0));
    for (std::size_t j = 0; j < weights.size(); ++j)
      if (const double w = h * weights[j]; w != 0)
        for (std::size_t c = 0; c < out.size(); ++c) out[c] += T(w) * x[j * out.size() + c];
  }
  /// Computes y = y0 + h Σ w_j L_j.
  void advance(const std::vector<double>& weights, double h, const T* y0) {
    sum(weights, h, L_, y);
    for (std::size_t c = 0; c < y.size(); ++c) y[c] += y0[c];
  }

  ConfigurationGroup<T, S> group_;
  const Tableau* method_;
  Vector K_, L_, q_;
};
template <class S, class... More> MuntheKaas(const Tree<S>&, const Tableau&, More...) -> MuntheKaas<S, S>;

}  // namespace axode
