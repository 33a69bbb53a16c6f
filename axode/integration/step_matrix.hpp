#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"

namespace axode {

/// Newton's matrix of an implicit step, factorised: that of r = ID(q, v, a) - τ by a, where q = q_0 ⊕ x and where x and v move
/// with a as c_x a and c_v a,
///   J = M + c_v ∂r/∂v + c_x ∂r/∂q dexp_{-x}.
/// A System has residual_derivatives(q, v, a, dr), those of ID; is_driven(); and drive(t, q, v), which is τ.
template <class System> class StepMatrix {
 public:
  using Numbers = std::vector<double>;

  StepMatrix(System& system, const Tree<double>& tree)
      : system_(&system), group_(tree), q_(static_cast<std::size_t>(tree->nq)) {}

  /// Without the part of the drive.
  void compute(const Numbers& x, const Numbers& q, const Numbers& v, const Numbers& a, double c_x,
               double c_v) {
    assemble(x, q, v, a, c_x, c_v);
    lu_.compute(J_);
  }
  /// With it, by differences.
  void compute_with_drive(double t, const Numbers& q_0, const Numbers& x, const Numbers& q, const Numbers& v,
                          const Numbers& a, double c_x, double c_v) {
    assemble(x, q, v, a, c_x, c_v);
    if (system_->is_driven()) {
      const std::span<const double> now = system_->drive(t, q, v);
      const Numbers tau(now.begin(), now.end());
      Numbers x_k = x, v_k = v;
      for (std::size_t k = 0; k < v.size(); ++k) {
        const double by = 1e-7 * (1 + std::abs(v[k])) / c_v;
        x_k[k] = x[k] + c_x * by, v_k[k] = v[k] + c_v * by;
        group_.move(q_0.data(), x_k.data(), q_.data());
        const std::span<const double> then = system_->drive(t, q_, v_k);
        for (std::size_t i = 0; i < v.size(); ++i)
          J_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) -= (then[i] - tau[i]) / by;
        x_k[k] = x[k], v_k[k] = v[k];
      }
    }
    lu_.compute(J_);
  }
  /// r := J⁻¹ r.
  void solve(Numbers& r) const {
    Eigen::Map<Eigen::VectorXd> map(r.data(), J_.rows());
    map = lu_.solve(map).eval();
  }

 private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  void assemble(const Numbers& x, const Numbers& q, const Numbers& v, const Numbers& a, double c_x,
                double c_v) {
    const auto nv = static_cast<Eigen::Index>(v.size());  // schemes that never come here need no room
    for (Matrix* matrix : {&dq_, &dv_, &J_}) matrix->resize(nv, nv);
    system_->residual_derivatives(q, v, a, {as_span(dq_), as_span(dv_), as_span(J_)});
    if (!group_.commutes()) {
      Numbers back(x);
      for (double& x_k : back) x_k = -x_k;
      for (Eigen::Index i = 0; i < dq_.rows(); ++i)  // rows are momenta: dexp_{-x}ᵀ
        group_.codexp(back.data(), dq_.row(i).data(), dq_.row(i).data());
    }
    J_ += c_v * dv_ + c_x * dq_;
  }

  System* system_;
  ConfigurationGroup<double> group_;
  Numbers q_;
  Matrix dq_, dv_, J_;
  Eigen::PartialPivLU<Matrix> lu_;
};

}  // namespace axode
