#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "axode/constraints/absolute_system.hpp"
#include "axode/integration/composition.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/settling.hpp"

namespace axode {

/// A step of RATTLE on a group with constant M, or of its symmetric composition: symplectic where forces have a potential,
/// Φ(q) = 0 and B v = 0 at the ends of all steps. With x = h w,
///   dexp⁻¹_xᵀ M w = p_0 + h/2 f(q_0, v_0) + B_0ᵀ λ = k,   q_1 = q_0 ⊕ x,   Φ(q_1) = 0,
///   M v_1 = Ad_{exp x}ᵀ k + h/2 f(q_1, v_1) + B_1ᵀ λ_1,     B_1 v_1 = 0.
/// Rows N of what rolls, which have no place, bind w in the middle instead: N(q_0 ⊕ x/2) w = 0, by the discrete principle of
/// Lagrange and d'Alembert (Cortés, Martínez). So it is symmetric and keeps its order, but symplectic is nothing there.
/// The second half is solved for the v_1 on which f may depend: so damping and drives keep the order. Newton's method takes
/// M and B, where the step is expected to end, for its matrix.
///
/// A System has the AbsoluteSystem as bodies(), and forces(t, q, v, f), place(t, q) and hold(t, q), which say whether they could.
template <class System> class Rattle {
 public:
  using Numbers = std::vector<double>;

  /// From a state at which the system is held.
  Rattle(System& system, int order, const Numbers& q_0, const Numbers& v_0)
      : q(q_0),
        v(v_0),
        system_(&system),
        group_(system.bodies().group()),
        lengths_(symmetric_composition(order)) {}

  /// Takes q and v at time t to t + h.
  StepOutcome run(double t, double h) {
    for (std::size_t k = 0; k < lengths_.size(); ++k) {
      if (const StepOutcome outcome = step(t, lengths_[k] * h); outcome != StepOutcome::found) return outcome;
      t += lengths_[k] * h;
    }
    return StepOutcome::found;
  }

  Numbers q, v;

 private:
  StepOutcome step(double t, double h) {
    auto& bodies = system_->bodies();
    if (!system_->forces(t, q, v, f_)) return StepOutcome::impossible;
    bodies.momentum(v, p_);
    k_0_ = p_;
    for (std::size_t c = 0; c < v.size(); ++c) k_0_[c] += h / 2 * f_[c];
    w_ = v, x_.resize(v.size()), q_1_.resize(q.size()), q_middle_.resize(q.size()), r_.resize(v.size());
    // Where branches of a motion meet, the guess decides which one is followed: it is that of the accelerations.
    group_.cobracket(v.data(), p_.data(), r_.data());
    for (std::size_t c = 0; c < v.size(); ++c) r_[c] += f_[c];
    bodies.bias(v, want_);
    bodies.solve(r_, want_, dw_, lambda_);
    for (std::size_t c = 0; c < v.size(); ++c) w_[c] += h / 2 * dw_[c];
    for (double& lambda_k : lambda_) lambda_k *= h / 2;
    go(h, q_1_);
    if (!system_->place(t + h, q_1_)) return StepOutcome::impossible;
    Settling settling;
    for (auto verdict = Settling::Verdict::going;;) {
      go(h, q_1_);
      k_ = k_0_;
      bodies.add_closing(q, lambda_, k_);
      if (verdict == Settling::Verdict::settled) break;
      group_.codexp(x_.data(), k_.data(), r_.data());
      bodies.momentum(w_, p_);
      for (std::size_t c = 0; c < v.size(); ++c) r_[c] -= p_[c];
      bodies.gap(q_1_, want_, AbsoluteSystem::Rows::velocities);
      for (double& open : want_) open *= -1 / h;
      if (bodies.rolls()) {
        go(h / 2, q_middle_);
        bodies.put_rolling(q_middle_, w_, -1, want_);
      }
      bodies.solve(r_, want_, dw_, dlambda_);
      verdict = settling.take(scale_of(w_), {{w_, dw_}, {lambda_, dlambda_}});
      if (verdict == Settling::Verdict::diverged) return StepOutcome::diverged;
    }
    group_.carry(x_.data(), k_.data(), k_.data());
    if (!system_->hold(t + h, q_1_)) return StepOutcome::impossible;
    v = w_;
    Settling settling_again;
    old_.clear();
    for (auto verdict = Settling::Verdict::going; verdict != Settling::Verdict::settled; old_ = f_) {
      if (!system_->forces(t + h, q_1_, v, f_)) return StepOutcome::impossible;
      if (old_ == f_) break;  // which does not depend on v
      bodies.momentum(v, p_);
      for (std::size_t c = 0; c < v.size(); ++c) r_[c] = k_[c] + h / 2 * f_[c] - p_[c];
      bodies.slip(q_1_, v, want_);
      for (double& slip : want_) slip = -slip;
      bodies.solve(r_, want_, dw_, dlambda_);
      verdict = settling_again.take(scale_of(v), {{v, dw_}});
      if (verdict == Settling::Verdict::diverged) return StepOutcome::diverged;
    }
    q = q_1_;
    return StepOutcome::found;
  }

  /// q ⊕ part w, by x.
  void go(double part, Numbers& to) {
    for (std::size_t c = 0; c < v.size(); ++c) x_[c] = part * w_[c];
    group_.move(q.data(), x_.data(), to.data());
  }

  System* system_;
  ConfigurationGroup<double> group_;
  std::span<const double> lengths_;
  Numbers f_, old_, k_0_, k_, w_, x_, q_1_, q_middle_, r_, p_, want_, dw_, lambda_, dlambda_;
};

}  // namespace axode
