#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "axode/constraints/absolute_system.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/settling.hpp"

namespace axode {

/// A step of generalised-α under constraints, on a group with constant M (Arnold, Brüls): the means of GeneralizedAlpha, with
///   M a_1 = f(q_1, v_1) + ad_{v_1}ᵀ M v_1 + B_1ᵀ λ,   Φ(q_1) = 0                    (index 3)
/// or, stabilised to index 2, with multipliers η of positions, B_1 v_1 = 0 besides:
///   x = h v_0 + h² ((1/2 - β) â_0 + β â_1 + β c M⁻¹ Bᵀ η).
/// What rolls, N v_1 = 0 without a place, does so in either form, and where η moves it, too.
/// Newton's method takes M, B and what joints resist their own motion with, which are those of where the step is expected to end,
/// for its matrix; and so does the metric of c M⁻¹ Bᵀ η. A System is one of Rattle's that knows the resistance.
template <class System> class ConstrainedAlpha {
 public:
  using Numbers = std::vector<double>;

  /// From a state with acceleration a_0 and multipliers, at which the system is held.
  ConstrainedAlpha(System& system, double spectral_radius, bool stabilized, const Numbers& q_0,
                   const Numbers& v_0, const Numbers& a_0, const Numbers& lambda_0)
      : q(q_0),
        v(v_0),
        lambda(lambda_0),
        system_(&system),
        group_(system.bodies().group()),
        stabilized_(stabilized),
        a_f_(spectral_radius / (spectral_radius + 1)),
        a_m_((2 * spectral_radius - 1) / (spectral_radius + 1)),
        gamma_(0.5 + a_f_ - a_m_),
        beta_((gamma_ + 0.5) * (gamma_ + 0.5) / 4),
        c_((1 - a_f_) / (1 - a_m_)),
        a_(a_0),
        mean_(a_0) {}

  /// Takes q, v and λ at time t to t + h.
  StepOutcome run(double t, double h) {
    auto& bodies = system_->bodies();
    const std::size_t nv = v.size();
    const double c_x = h * h * beta_ * c_, c_v = h * gamma_ * c_;
    a_1_ = a_, moved_.assign(nv, 0.0), x_.resize(nv), q_1_.resize(q.size()), turning_.resize(nv);
    mean_1_.resize(nv), v_1_.resize(nv);
    end_with(h);
    if (!system_->place(t + h, q_1_, v_1_, c_x, c_v)) return StepOutcome::impossible;
    Settling settling;
    for (auto verdict = Settling::Verdict::going;;) {
      end_with(h);
      if (verdict == Settling::Verdict::settled) break;
      if (!system_->forces(t + h, q_1_, v_1_, r_)) return StepOutcome::impossible;
      bodies.momentum(v_1_, p_);
      group_.cobracket(v_1_.data(), p_.data(), turning_.data());
      bodies.momentum(a_1_, p_);
      bodies.add_closing(q_1_, lambda, r_);
      for (std::size_t k = 0; k < nv; ++k) r_[k] += turning_[k] - p_[k];
      bodies.gap(q_1_, open_, AbsoluteSystem::Rows::velocities);
      for (double& open : open_) open /= -c_x;
      if (stabilized_) {
        bodies.slip(q_1_, v_1_, want_);
        for (double& slip : want_) slip /= -c_v;
        bodies.solve(r_, want_, da_, dlambda_);
        for (std::size_t k = 0; k < open_.size(); ++k) open_[k] -= want_[k];  // as B da is
        bodies.put_rolling(q_1_, moved_, -1, open_);
        r_.assign(nv, 0.0);
        bodies.solve(r_, open_, dmoved_, deta_);
      } else {
        bodies.put_rolling(q_1_, v_1_, -1 / c_v, open_);
        bodies.solve(r_, open_, da_, dlambda_);
        dmoved_.assign(nv, 0.0);
      }
      verdict = settling.take(scale_of(v_1_) / h, {{a_1_, da_}, {moved_, dmoved_}, {lambda, dlambda_}});
      if (verdict == Settling::Verdict::diverged) return StepOutcome::diverged;
    }
    q = q_1_, v = v_1_, a_ = a_1_, mean_ = mean_1_;
    return system_->hold(t + h, q) ? StepOutcome::found : StepOutcome::impossible;
  }

  Numbers q, v, lambda;

 private:
  /// The end of a step in which the acceleration becomes a_1 and bodies are moved besides.
  void end_with(double h) {
    for (std::size_t k = 0; k < v.size(); ++k) {
      mean_1_[k] = (a_f_ * a_[k] - a_m_ * mean_[k]) / (1 - a_m_) + c_ * a_1_[k];
      v_1_[k] = v[k] + h * ((1 - gamma_) * mean_[k] + gamma_ * mean_1_[k]);
      x_[k] = h * v[k] + h * h * ((0.5 - beta_) * mean_[k] + beta_ * (mean_1_[k] + c_ * moved_[k]));
    }
    group_.move(q.data(), x_.data(), q_1_.data());
  }

  System* system_;
  ConfigurationGroup<double> group_;
  bool stabilized_;
  double a_f_, a_m_, gamma_, beta_, c_;
  Numbers a_, mean_, a_1_, mean_1_, v_1_, moved_, x_, q_1_, r_, p_, turning_, open_, want_, da_, dlambda_,
      dmoved_, deta_;
};

}  // namespace axode
