#pragma once
#include <cstddef>
#include <vector>

#include "axode/constraints/loop_system.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/midpoint.hpp"
#include "axode/integration/settling.hpp"

namespace axode {

/// The step of Midpoint between impulses of the loops at its ends, with r(q) and its rows R, r' = R v:
///   p_0⁺ = p_0 + h/2 R(q_0)ᵀ λ,   (q_1, p_1⁻) = midpoint step of (q_0, p_0⁺),   r(q_1) = 0.
/// With p_1 = p_1⁻ + R(q_1)ᵀ μ for which R M⁻¹ p_1 = 0, which is for the System to find, it is symmetric and of second order,
/// and symplectic on the closed configurations where the midpoint rule is. Newton's method takes M and R where the middle is
/// expected for its matrix. A System is one of Midpoint's that has can(t, solvability), which keeps the reason where it cannot.
template <class System> class ClosedMidpoint {
 public:
  using Numbers = std::vector<double>;
  using Outcome = typename Midpoint<System>::Outcome;

  ClosedMidpoint(System& system, const Model& model)
      : q(static_cast<std::size_t>(model.nq())),
        q_middle(q.size()),
        p(static_cast<std::size_t>(model.nv())),
        v(p.size()),
        f(p.size()),
        system_(&system),
        model_(model),
        group_(model_.tree<double>()),
        ends_(model_),
        middle_(model_),
        R_(static_cast<std::size_t>(model.loops().residuals) * p.size()),
        lambda_(static_cast<std::size_t>(model.loops().residuals)),
        want_(lambda_),
        dlambda_(lambda_),
        y_(p.size()),
        p_0_(p.size()),
        momenta_(p.size()),
        r_(p.size()) {}

  /// From (q0, p0) at time t over h, as Midpoint. Loops are closed at q0.
  Outcome run(double t, double h, const Numbers& q0, const Numbers& p0) {
    LoopSystem<double>&ends = ends_.system(model_), &middle = middle_.system(model_);
    constexpr auto places = LoopSystem<double>::Rows::places;
    if (!system_->can(t, ends.determine_rank(q0.data(), rank_))) return Outcome::impossible;
    middle.place(q0.data());
    middle.set_filter(q0.data(), rank_);
    ends.make_rows(places);
    ends.write(R_.data());
    go(0.5 * h, q0, q_middle);
    middle.place(q_middle.data());
    if (!system_->can(t, middle.factorize())) return Outcome::impossible;
    middle.make_rows(places);
    middle.factorize_rows();
    Settling settling;
    for (auto verdict = Settling::Verdict::going;;) {
      go(0.5 * h, q0, q_middle);
      start(h, p0);
      group_.carry(y_.data(), p_0_.data(), p.data());
      if (verdict == Settling::Verdict::settled) break;
      if (!system_->partials(t + 0.5 * h, q_middle, v, momenta_, f)) return Outcome::impossible;
      for (std::size_t k = 0; k < v.size(); ++k) p[k] += h * f[k], r_[k] = 0.5 * (p_0_[k] + p[k]);
      group_.codexp(y_.data(), r_.data(), r_.data());
      for (std::size_t k = 0; k < v.size(); ++k) r_[k] -= momenta_[k];
      go(h, q0, q);
      ends.place(q.data());
      ends.residual(q.data(), want_.data());
      for (double& open : want_) open /= h;
      middle.add_response(r_.data(), want_.data());
      middle.solve_rows(want_.data(), dlambda_.data(), rank_);
      middle.add_transposed_times(dlambda_.data(), r_.data());
      middle.solve(r_.data());
      for (double& d : dlambda_) d *= 2 / h;
      verdict = settling.take(scale_of(v), {{v, r_}, {lambda_, dlambda_}});
      if (verdict == Settling::Verdict::diverged) return Outcome::diverged;
    }
    for (std::size_t k = 0; k < v.size(); ++k) p[k] += h * f[k];
    group_.carry(y_.data(), p.data(), p.data());
    go(h, q0, q);
    return Outcome::found;
  }

  Numbers q, q_middle, p, v, f;  ///< after run(): at its end, v and f of its middle

 private:
  /// q_0 ⊕ part v, by y.
  void go(double part, const Numbers& q0, Numbers& to) {
    for (std::size_t k = 0; k < v.size(); ++k) y_[k] = part * v[k];
    group_.move(q0.data(), y_.data(), to.data());
  }
  /// p_0⁺.
  void start(double h, const Numbers& p0) {
    p_0_ = p0;
    for (std::size_t row = 0; row < lambda_.size(); ++row)
      for (std::size_t k = 0; k < v.size(); ++k) p_0_[k] += 0.5 * h * lambda_[row] * R_[row * v.size() + k];
  }

  System* system_;
  Model model_;
  ConfigurationGroup<double> group_;
  LoopWorkspace<double> ends_, middle_;
  RowRank rank_;
  Numbers R_, lambda_, want_, dlambda_, y_, p_0_, momenta_, r_;
};

}  // namespace axode
