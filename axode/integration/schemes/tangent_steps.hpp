#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "axode/integration/configuration_group.hpp"
#include "axode/integration/schemes/group_derivatives.hpp"
#include "axode/integration/schemes/munthe_kaas.hpp"
#include "axode/integration/tableau.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// Runge-Kutta-Munthe-Kaas steps of the state (q, y), where y has the velocities v and possibly other states,
/// and of its derivatives along several directions at once.
class TangentSteps {
 public:
  using Span = std::span<const double>;
  using Vector = std::vector<double>;
  using Matrix = GroupDerivatives::Matrix;
  using Row = Eigen::RowVectorXd;

  TangentSteps(const Model& model, const Tableau& method, Eigen::Index directions,
               std::size_t n_other_states = 0)
      : q(static_cast<std::size_t>(model.nq())),
        y(static_cast<std::size_t>(model.nv()) + n_other_states),
        dq(Matrix::Zero(model.nv(), directions)),
        dy(Matrix::Zero(static_cast<Eigen::Index>(y.size()), directions)),
        method_(method),
        scheme_(model.tree<double>(), method, LocalCoordinates::exponential, n_other_states),
        group_(model.tree<double>()),
        maps_(model.tree<double>()),
        rates_(y.size()),
        dtheta_(dq),
        eta_(dq),
        dY_(dy),
        dK_(method.b.size(), dq),
        dL_(method.b.size(), dy) {}

  Vector q, y;    ///< present state
  Matrix dq, dy;  ///< displacements of q and y, a column for each direction
  Row dt, dh;     ///< changes of the time and the length of a step, for each direction; empty: none

  /// Takes a step of length h from time t of the state (q, y), where y are the velocities followed by other
  /// states if there are any, and of its displacements. differentiate(t, dt, q, y, dq, dy, rates, drates)
  /// must write the rates y' to `rates` and their changes along the displacements dt, dq and dy to `drates`,
  /// and return whether it succeeded. Returns false if it did not.
  template <class Differentiate> bool run(double t, double h, const Differentiate& differentiate) {
    const Tableau& m = method_;
    if (!differentiate(t, dt, Span(q), Span(y), dq, dy, std::span(rates_), dL_[0])) return false;
    dK_[0] = dy.topRows(dq.rows());
    std::size_t i = 0;
    const auto stage = [&](double t_i, Span q_i, Span y_i, std::span<double> rates_i) {
      ++i;
      displace(m.a[i], h, y_i.data());
      dY_ = dy;
      add_sum(m.a[i], h, dL_, dY_);
      add_change_of_length(y_i, y, h, dY_);
      const Row dt_i = dt + m.c[i] * dh;
      if (!differentiate(t_i, dt_i, q_i, y_i, eta_, dY_, rates_i, dL_[i])) return false;
      dK_[i].setZero();
      maps_.add(&GroupDerivatives::Joints::rate, dY_, dK_[i]);
      maps_.add(&GroupDerivatives::Joints::turn, dtheta_, dK_[i]);
      return true;
    };
    if (!scheme_.run(t, q.data(), y.data(), rates_.data(), h, stage)) return false;
    add_sum(m.b, h, dL_, dy);
    add_change_of_length(scheme_.y, y, h, dy);
    y = scheme_.y;
    if (m.b.size() == 1) dK_[0] = dy.topRows(dq.rows());
    displace(m.b, h, y.data());
    dq.swap(eta_);
    group_.move(q.data(), scheme_.theta.data(), q.data());
    return true;
  }

 private:
  /// Adds h Σ w_j x_j to out.
  static void add_sum(const Vector& weights, double h, const std::vector<Matrix>& x, Matrix& out) {
    for (std::size_t j = 0; j < weights.size(); ++j)
      if (const double w = h * weights[j]; w != 0) out += w * x[j];
  }
  /// Adds to out the change of x_0 + h r by that of h, if this is x.
  void add_change_of_length(Span x, Span x_0, double h, Matrix& out) const {
    if (dh.size() == 0) return;
    for (std::size_t c = 0; c < x.size(); ++c)
      out.row(static_cast<Eigen::Index>(c)) += ((x[c] - (x_0.empty() ? 0 : x_0[c])) / h) * dh;
  }
  /// For a stage at q ⊕ theta with velocity V: computes the displacements dtheta of theta, eta of q ⊕ theta.
  void displace(const Vector& weights, double h, const double* V) {
    dtheta_.setZero();
    add_sum(weights, h, dK_, dtheta_);
    add_change_of_length(scheme_.theta, {}, h, dtheta_);
    maps_.at(scheme_.theta.data(), V);
    eta_.setZero();
    maps_.add(&GroupDerivatives::Joints::carry, dq, eta_);
    maps_.add(&GroupDerivatives::Joints::velocity, dtheta_, eta_);
  }

  const Tableau& method_;
  MuntheKaas<> scheme_;
  ConfigurationGroup<double> group_;
  GroupDerivatives maps_;
  Vector rates_;
  Matrix dtheta_, eta_, dY_;
  std::vector<Matrix> dK_, dL_;
};

}  // namespace axode
