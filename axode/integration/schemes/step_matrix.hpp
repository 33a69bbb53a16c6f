#pragma once
#include <span>

#include "axode/derivatives/inverse_dynamics_derivatives.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/energy_norm.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode {

/// Newton's matrix J of an implicit step, factorised (D8.6): the derivative by a of the residual r(q, v, a)
/// of the equations of motion, where q = q_0 ⊕ x. A change δa of a changes v by c_v δa and x by c_x δa, hence
///   J = ∂r/∂a + c_v ∂r/∂v + c_x ∂r/∂q dexp_{-x}.
/// System is the class of the mechanism. It must have the member functions of SimulationRun that are called
/// here.
template <class System> class StepMatrix {
 public:
  using Vector = Eigen::VectorXd;

  StepMatrix(System& system, const Tree<double>& tree)
      : system_(&system), group_(tree, system.local_coordinates()), q_(tree->nq) {}

  /// Computes and factorises J without the derivatives of the function SimulationOptions::drive.
  void compute(const Vector& x, const Vector& q, const Vector& v, const Vector& a, double c_x, double c_v) {
    assemble(x, q, v, a, c_x, c_v);
    lu_.compute(J_);
  }
  /// Computes and factorises J with the derivatives of SimulationOptions::drive, as difference quotients.
  void compute_with_drive(double t, const Vector& q_0, const Vector& x, const Vector& q, const Vector& v,
                          const Vector& a, double c_x, double c_v) {
    assemble(x, q, v, a, c_x, c_v);
    if (system_->is_driven()) add_drive(t, q_0, x, q, v, c_x, c_v);
    resistance_ = (J_ - M_).diagonal().cwiseMax(0);
    lu_.compute(J_);
  }
  /// The inertia that springs, dampers and drives seem to add to each velocity in an implicit step (nv
  /// numbers, kg m² or kg): the diagonal of the last Newton matrix J of compute_with_drive() minus that of
  /// the mass matrix, or 0 where this difference is negative.
  const Vector& resistance() const { return resistance_; }
  /// Takes over Newton's matrix of another motion of the same mechanism.
  void continue_from(const StepMatrix& other) {
    resistance_ = other.resistance_;
    lu_ = other.lu_;
  }
  /// Replaces r by J⁻¹ r.
  void solve(Vector& r) {
    lu_.solve(r, solution_);
    r = solution_;
  }

 private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  void assemble(const Vector& x, const Vector& q, const Vector& v, const Vector& a, double c_x, double c_v) {
    // Memory is allocated here, so that schemes which do not use the matrix allocate none.
    for (Matrix* matrix : {&dq_, &dv_, &M_}) matrix->resize(v.size(), v.size());
    system_->residual_derivatives(q, v, a, {as_span(dq_), as_span(dv_), as_span(M_)});
    if (!group_.commutes()) {
      back_ = -x;
      for (Eigen::Index i = 0; i < dq_.rows(); ++i)  // each row transforms like a momentum, by dexp_{-x}ᵀ
        group_.dexp_transpose(back_, dq_.row(i), dq_.row(i));
    }
    J_ = M_ + c_v * dv_ + c_x * dq_;
  }
  void add_drive(double t, const Vector& q_0, const Vector& x, const Vector& q, const Vector& v, double c_x,
                 double c_v) {
    const Vector tau = as_eigen(system_->drive(t, q, v));
    const double size = system_->velocity_scale(v, c_v);
    Vector x_k = x, v_k = v;
    for (Eigen::Index k = 0; k < v.size(); ++k) {
      const double by = system_->norm().increment(k, v[k], size) / c_v;
      x_k[k] += c_x * by;
      v_k[k] += c_v * by;
      group_.move(q_0, x_k, q_);
      J_.col(k) -= (as_eigen(system_->drive(t, q_, v_k)) - tau) / by;
      x_k[k] = x[k];
      v_k[k] = v[k];
    }
  }

  System* system_;
  ConfigurationGroup<double> group_;
  Vector q_, back_, solution_, resistance_;
  Matrix dq_, dv_, M_;
  Eigen::MatrixXd J_;
  LuFactor lu_;
};

}  // namespace axode
