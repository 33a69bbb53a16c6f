#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/constraints/local_mobility/walks.hpp"
#include "axode/model/model.hpp"

namespace axode::higher_order {

/// The loops of a mechanism at a configuration q0, as products of exponentials that are I at q0 (eqs. D13.1,
/// D13.2). The coordinates x are 0 there, in rad and characteristic lengths. A joint of several degrees of
/// freedom is exp(Σ S_k x_k), so that the configuration is q0 ⊕ x. Only joints in loops have coordinates.
class Closure {
 public:
  /// A length of 0 stands for the mean distance between two joints. Throws std::invalid_argument with the
  /// name of a rolling contact.
  Closure(const Model& model, std::span<const double> q0, double length = 0);

  int size() const { return static_cast<int>(coordinates_.size()); }
  int rows() const { return static_cast<int>(6 * loops_.size()) + static_cast<int>(couplings_.rows()); }
  double length() const { return length_; }  ///< m
  const std::vector<ClosureCoordinate>& coordinates() const { return coordinates_; }
  /// n numbers: what a unit of x is in rad or m.
  const Eigen::VectorXd& unit() const { return unit_; }
  /// Velocities of joints that are in no loop.
  const std::vector<int>& outside() const { return outside_; }

  /// Indices of the loops, and after them of the couplings, with equations in a combination (rows numbers).
  std::vector<int> loops_of_equations(const Eigen::Ref<const Eigen::VectorXd>& combination) const;
  /// Indices of the loops, and after them of the couplings, with a coordinate that moves.
  std::vector<int> loops_of_coordinates(const std::vector<char>& moves) const;

  /// log f of every loop, and the rows of the couplings, up to degree `degree` for polynomials x in the
  /// variables of a ring, by brackets alone (D13.5, D13.6).
  Eigen::MatrixXd log_series(const PolynomialRing& ring, const Eigen::Ref<const Eigen::MatrixXd>& x,
                             int degree) const;
  /// log f of every loop and the couplings at x, and their derivatives up to factors that are I where the
  /// loops are closed (rows × n).
  Eigen::VectorXd residual(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  Eigen::MatrixXd jacobian(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  /// Gauss-Newton steps from x until the loops are closed and held x = target; held may have no rows. Steps
  /// are the shortest ones, so that redundant rows do no harm. Returns |residual|.
  double close(Eigen::VectorXd& x, const Eigen::Ref<const Eigen::MatrixXd>& held,
               const Eigen::Ref<const Eigen::VectorXd>& target) const;

  /// The configuration q0 ⊕ x (nq).
  std::vector<double> configuration(const Eigen::Ref<const Eigen::VectorXd>& x) const;

 private:
  /// Computes the residual, and the derivatives unless J is null.
  void evaluate(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::VectorXd& r, Eigen::MatrixXd* J) const;

  Model model_;
  std::vector<double> q0_;
  double length_ = 1;
  std::vector<ClosureCoordinate> coordinates_;
  std::vector<std::vector<PassedJoint>> loops_;
  Eigen::MatrixXd couplings_;  ///< a row for each coupling
  Eigen::VectorXd unit_;
  std::vector<int> outside_;
};

}  // namespace axode::higher_order
