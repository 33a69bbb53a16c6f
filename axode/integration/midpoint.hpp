#pragma once
#include <cmath>
#include <limits>
#include <vector>

#include "axode/integration/step_matrix.hpp"

namespace axode {

/// One step of the midpoint rule on the group for (q, p): with y = h v / 2 and q_m = q_0 ⊕ y,
///   p⁻ = Ad_{exp y}ᵀ p_0,   p⁺ = p⁻ + h f(t_m, q_m, v),   M(q_m) v = dexp_yᵀ (p_0 + p⁺) / 2,
///   q_1 = q_0 ⊕ 2 y,        p_1 = Ad_{exp y}ᵀ p⁺.
/// It is symmetric and of second order, and symplectic where f = ∂L/∂q, as it follows from the discrete Lagrangian h L(q_m, v).
/// (With M(q_m) v = (p⁻ + p⁺)/2 it is not, where joints have several velocities.) Forces that depend on v enter by
/// d'Alembert's discrete principle.
///
/// v is found with M, factorised once, in the place of Newton's matrix, and with that where M does not do. A System has
/// partials(t, q, v, p, f), which says whether p = M v and f could be found; factorize(t, q), which says whether M could be, and
/// solve(x), with it; and what StepMatrix asks for.
template <class System> class Midpoint {
 public:
  using Numbers = std::vector<double>;
  enum class Outcome { found, impossible, diverged };

  Midpoint(System& system, const Tree<double>& tree)
      : q(static_cast<std::size_t>(tree->nq)),
        q_middle(q.size()),
        p(static_cast<std::size_t>(tree->nv)),
        v(p.size()),
        f(p.size()),
        system_(&system),
        group_(tree),
        matrix_(system, tree),
        y_(p.size()),
        momenta_(p.size()),
        r_(p.size()),
        none_(p.size()) {}

  /// From (q0, p0) at time t over h, which may be negative, from a guess in v to q, p, and what else is public.
  Outcome run(double t, double h, const Numbers& q0, const Numbers& p0) {
    constexpr int most = 60;
    bool newton = false;
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most; ++iteration) {
      for (std::size_t k = 0; k < v.size(); ++k) y_[k] = 0.5 * h * v[k];
      group_.move(q0.data(), y_.data(), q_middle.data());
      if (iteration == 0 && !system_->factorize(t + 0.5 * h, q_middle)) return Outcome::impossible;
      if (!system_->partials(t + 0.5 * h, q_middle, v, momenta_, f)) return Outcome::impossible;
      group_.carry(y_.data(), p0.data(), p.data());
      for (std::size_t k = 0; k < v.size(); ++k) p[k] += h * f[k], r_[k] = 0.5 * (p0[k] + p[k]);
      group_.codexp(y_.data(), r_.data(), r_.data());
      for (std::size_t k = 0; k < v.size(); ++k) r_[k] = momenta_[k] - r_[k];
      if (newton)
        matrix_.solve(r_);
      else
        system_->solve(r_);
      double change = 0, size = std::abs(h);  // to which accelerations of one unit count
      for (std::size_t k = 0; k < v.size(); ++k) {
        v[k] -= r_[k];
        change = std::max(change, std::abs(r_[k])), size = std::max(size, std::abs(v[k]));
      }
      const bool slow = !(change < 0.5 * before);
      if (change <= 1e-13 * size || (slow && change < 1e-9 * size)) {  // the latter is rounding
        // Along the last v, q and p alike: momenta depend on that they move together.
        for (std::size_t k = 0; k < v.size(); ++k) y_[k] = 0.5 * h * v[k];
        group_.carry(y_.data(), p0.data(), p.data());
        for (std::size_t k = 0; k < v.size(); ++k) p[k] += h * f[k];
        group_.carry(y_.data(), p.data(), p.data());
        for (double& y_k : y_) y_k *= 2;
        group_.move(q0.data(), y_.data(), q.data());
        return Outcome::found;
      }
      if (slow) {
        newton = true;
        matrix_.compute_with_drive(t + 0.5 * h, q0, y_, q_middle, v, none_, 0.25 * h * h, 0.5 * h);
      }
      before = change;
    }
    return Outcome::diverged;
  }

  Numbers q, q_middle, p, v, f;  ///< after run(): at its end, v and f of its middle

 private:
  System* system_;
  ConfigurationGroup<double> group_;
  StepMatrix<System> matrix_;
  Numbers y_, momenta_, r_, none_;
};

}  // namespace axode
