#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "axode/constraints/absolute_system.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/settling.hpp"
#include "axode/integration/trajectory.hpp"

namespace axode {

/// A step of the half-explicit method of third order (Brasey, Hairer) on a group with constant M, as Munthe-Kaas':
///   M L_i = f(q_i, V_i) + ad_{V_i}ᵀ M V_i + B_iᵀ λ_i with the λ_i for which B_{i+1} V_{i+1} = 0,
///   θ_{i+1} = h Σ a_ij K_j,  V_{i+1} = v_0 + h Σ a_ij L_j,  K_i = dexp⁻¹_{-θ_i} V_i.
/// Velocities stay on the constraints; positions leave them by h⁴ in a step, where a step in the group is no motion of the joint,
/// and are brought back.
///
/// A System is one of Rattle's, with place(t, q) and close(t, q, v) besides.
template <class System> class HalfExplicit {
 public:
  using Numbers = std::vector<double>;

  HalfExplicit(System& system, const Numbers& q_0, const Numbers& v_0)
      : q(q_0), v(v_0), system_(&system), group_(system.bodies().group()) {}

  /// Takes q and v at time t to t + h.
  Failure run(double t, double h) {
    static constexpr std::array<std::array<double, 3>, 3> a{{{1.0 / 3, 0, 0}, {-1, 2, 0}, {0, 0.75, 0.25}}};
    static constexpr std::array<double, 3> c{0, 1.0 / 3, 1};
    const std::size_t nv = v.size();
    q_i_ = q;
    V_ = v;
    theta_.assign(nv, 0.0);
    q_next_.resize(q.size());
    for (std::size_t i = 0; i < 3; ++i) {
      if (i > 0)
        if (Failure failure = system_->place(t + c[i] * h, q_i_)) return failure;
      if (Failure failure = system_->forces(t + c[i] * h, q_i_, V_, f_)) return failure;
      system_->add_turning(V_, f_);
      K_[i].resize(nv);
      group_.rate(theta_, V_, K_[i]);
      theta_.assign(nv, 0.0);
      base_ = v;
      for (std::size_t j = 0; j <= i; ++j) as_eigen(theta_) += h * a[i][j] * as_eigen(K_[j]);
      for (std::size_t j = 0; j < i; ++j) as_eigen(base_) += h * a[i][j] * as_eigen(L_[j]);
      group_.move(q, theta_, q_next_);
      if (!accelerate(h * a[i][i], L_[i])) return {t + h, diverged};
      as_eigen(V_) = as_eigen(base_) + h * a[i][i] * as_eigen(L_[i]);
      q_i_ = q_next_;
    }
    q = q_i_;
    v = V_;
    return system_->close(t + h, q, v);
  }

  Numbers q, v;

 private:
  /// L at q_i, with which base + part L is consistent at the next stage.
  bool accelerate(double part, Numbers& L) {
    auto& bodies = system_->bodies();
    L.assign(v.size(), 0.0);
    lambda_.assign(static_cast<std::size_t>(bodies.rows(AbsoluteSystem::Rows::velocities)), 0.0);
    Settling settling(system_->norm());
    for (;;) {
      as_eigen(V_) = as_eigen(base_) + part * as_eigen(L);
      bodies.slip(q_next_, V_, want_);
      as_eigen(want_) *= -1 / part;
      bodies.momentum(L, p_);
      r_ = f_;
      bodies.add_closing(q_i_, lambda_, r_);
      as_eigen(r_) -= as_eigen(p_);
      bodies.solve(r_, want_, dL_, dlambda_);
      const double size = system_->velocity_scale(V_, part) / std::abs(part);
      const auto verdict =
          settling.take(size, {{as_eigen(L), as_eigen(dL_)}, {as_eigen(lambda_), as_eigen(dlambda_)}});
      if (verdict != Settling::Verdict::going) return verdict == Settling::Verdict::settled;
    }
  }

  System* system_;
  ConfigurationGroup<double> group_;
  std::array<Numbers, 3> K_, L_;
  Numbers q_i_, q_next_, V_, theta_, base_, f_, p_, lambda_, want_, r_, dL_, dlambda_;
};

}  // namespace axode
