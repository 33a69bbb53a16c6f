#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "axode/integration/step_matrix.hpp"

namespace axode {

/// One step of generalised-α on the group: with a mean acceleration â,
///   (1 - α_m) â_1 + α_m â_0 = (1 - α_f) a_1 + α_f a_0,   v_1 = v_0 + h ((1 - γ) â_0 + γ â_1),
///   x = h v_0 + h² ((1/2 - β) â_0 + β â_1),              q_1 = q_0 ⊕ x,
/// is solved for the a_1 with ID(q_1, v_1, a_1) = τ by Newton's method with
///   J = M + h γ c ∂ID/∂v + h² β c ∂ID/∂q dexp_{-x},      c = (1 - α_f) / (1 - α_m).
/// A System has residual(t, q, v, a, r), which says whether r = ID - τ could be found, and what StepMatrix asks for.
template <class System> class GeneralizedAlpha {
 public:
  using Numbers = std::vector<double>;
  enum class Outcome { found, impossible, diverged };

  GeneralizedAlpha(System& system, const Tree<double>& tree, double spectral_radius, const Numbers& a_0)
      : q(static_cast<std::size_t>(tree->nq)),
        v(a_0.size()),
        a(a_0),
        system_(&system),
        group_(tree),
        matrix_(system, tree),
        a_f_(spectral_radius / (spectral_radius + 1)),
        a_m_((2 * spectral_radius - 1) / (spectral_radius + 1)),
        gamma_(0.5 + a_f_ - a_m_),
        beta_((gamma_ + 0.5) * (gamma_ + 0.5) / 4),
        c_((1 - a_f_) / (1 - a_m_)),
        mean_0_(a_0),
        mean_(a_0.size()),
        x_(a_0.size()),
        r_(a_0.size()),
        da_(a_0.size()) {}

  /// From (q0, v0, a0) over h to q, v and a at time t.
  Outcome run(double t, double h, const Numbers& q0, const Numbers& v0, const Numbers& a0) {
    constexpr int most = 40;
    a = a0;
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most; ++iteration) {
      end_with(a, h, q0, v0, a0);
      if (!system_->residual(t, q, v, a, r_)) return Outcome::impossible;
      if (iteration == 0) linearize(t, h, q0);
      da_ = r_, matrix_.solve(da_);
      const double change = size_of(da_);
      if (iteration > 0 && !(change < 0.1 * before)) {
        if (before < 1e-9) break;  // rounding
        with_drive_ = true, linearize(t, h, q0);
        da_ = r_, matrix_.solve(da_);
      }
      for (std::size_t k = 0; k < a.size(); ++k) a[k] -= da_[k];
      before = change;
      if (change < 1e-13) break;
    }
    if (!(before < 1e-9)) return Outcome::diverged;
    end_with(a, h, q0, v0, a0);
    return Outcome::found;
  }
  /// The next step goes on from the end of this one; or from where accelerations have jumped to a_0.
  void go_on() { mean_0_ = mean_; }
  void begin(const Numbers& a_0) { mean_0_ = a_0; }

  Numbers q, v, a;  ///< after run()

 private:
  /// The end of a step in which the acceleration becomes a_1.
  void end_with(const Numbers& a_1, double h, const Numbers& q0, const Numbers& v0, const Numbers& a0) {
    for (std::size_t k = 0; k < a_1.size(); ++k) {
      mean_[k] = (a_f_ * a0[k] - a_m_ * mean_0_[k]) / (1 - a_m_) + c_ * a_1[k];
      v[k] = v0[k] + h * ((1 - gamma_) * mean_0_[k] + gamma_ * mean_[k]);
      x_[k] = h * v0[k] + h * h * ((0.5 - beta_) * mean_0_[k] + beta_ * mean_[k]);
    }
    group_.move(q0.data(), x_.data(), q.data());
  }

  /// With the drive's part from when Newton's method needs it on.
  void linearize(double t, double h, const Numbers& q0) {
    const double c_x = h * h * beta_ * c_, c_v = h * gamma_ * c_;
    if (with_drive_)
      matrix_.compute_with_drive(t, q0, x_, q, v, a, c_x, c_v);
    else
      matrix_.compute(x_, q, v, a, c_x, c_v);
  }
  double size_of(const Numbers& da) const {
    double largest = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
      largest = std::max(largest, std::abs(da[k]) / (1 + std::abs(a[k])));
    return largest;
  }

  System* system_;
  ConfigurationGroup<double> group_;
  StepMatrix<System> matrix_;
  double a_f_, a_m_, gamma_, beta_, c_;
  Numbers mean_0_, mean_, x_, r_, da_;
  bool with_drive_ = false;
};

}  // namespace axode
