#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/constraints/local_mobility/walks.hpp"
#include "axode/model/model.hpp"

namespace axode::higher_order {

/// The closure equations of the loops of a mechanism near a configuration q0: for each loop, the product f of
/// the exponentials of its joints is the identity (eqs. D13.1, D13.2). The unknowns are coordinates x of the
/// joints in loops. The configuration is q0 ⊕ x, and a joint with the screws S_k has the displacement exp(Σ
/// S_k x_k). Angles are in rad, and lengths are divided by a characteristic length.
class Closure {
 public:
  /// Makes the closure equations of all loops. Lengths are divided by the characteristic length `length`, m.
  /// If this is 0, they are divided by the mean distance at q0 between the centres of two joints, over all
  /// pairs of joints in loops with different centres, or by 1 m if there is no such pair. Joints without a
  /// definite centre, such as prismatic ones, do not count. Throws std::invalid_argument, with the name of
  /// the loop, if a loop joint is not made of subgroups, such as a rolling contact or a belt.
  Closure(const Model& model, std::span<const double> q0, double length = 0);

  int size() const { return static_cast<int>(coordinates_.size()); }
  int rows() const { return static_cast<int>(6 * loops_.size()) + static_cast<int>(couplings_.rows()); }
  double length() const { return length_; }  ///< characteristic length, m
  const std::vector<ClosureCoordinate>& coordinates() const { return coordinates_; }
  /// The unit of each coordinate x (n numbers): 1 rad or the characteristic length in m.
  const Eigen::VectorXd& unit() const { return unit_; }
  /// Indices of velocities of joints that are in no loop.
  const std::vector<int>& outside() const { return outside_; }

  /// The indices of the loops and couplings that take part in a linear combination of the closure equations.
  /// Coupling k has the index k plus the number of loops. `combination` has the coefficients, one for each
  /// equation.
  std::vector<int> loops_of_equations(const Eigen::Ref<const Eigen::VectorXd>& combination) const;
  /// The indices of the loops and couplings with a coordinate c that moves (moves[c]). Coupling k has the
  /// index k plus the number of loops.
  std::vector<int> loops_of_coordinates(const std::vector<char>& moves) const;

  /// Computes the left sides of the closure equations as power series: for each loop log f, where f is the
  /// product of the joint exponentials around the loop, and one number for each coupling. The coordinates x
  /// and the results are polynomials in the variables of `ring`; results have the terms up to `degree`. Only
  /// brackets of joint screws are used (D13.5, D13.6).
  Eigen::MatrixXd log_series(const PolynomialRing& ring, const Eigen::Ref<const Eigen::MatrixXd>& x,
                             int degree) const;
  /// residual() returns the left sides of the closure equations at the coordinates x (rows() numbers). For
  /// each loop it has log f, where f is the product of the joint exponentials around the loop, and for each
  /// coupling one number. jacobian() returns the derivative of residual() by x (rows × n). If loops are open,
  /// it is approximate; its error vanishes as the loops close.
  Eigen::VectorXd residual(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  Eigen::MatrixXd jacobian(const Eigen::Ref<const Eigen::VectorXd>& x) const;
  /// Changes the coordinates x by Gauss-Newton steps of least norm until the loops are closed and x satisfies
  /// the linear conditions held · x = target; `held` may have no rows. Returns the norm of the residual.
  double close(Eigen::VectorXd& x, const Eigen::Ref<const Eigen::MatrixXd>& held,
               const Eigen::Ref<const Eigen::VectorXd>& target) const;

  /// The configuration q0 ⊕ x (nq).
  std::vector<double> configuration(const Eigen::Ref<const Eigen::VectorXd>& x) const;

 private:
  /// Computes the residual r at x and, unless J is null, its derivative J, see jacobian().
  void evaluate(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::VectorXd& r, Eigen::MatrixXd* J) const;

  Model model_;
  std::vector<double> q0_;
  double length_ = 1;
  std::vector<ClosureCoordinate> coordinates_;
  std::vector<std::vector<PassedJoint>> loops_;
  Eigen::MatrixXd couplings_;  ///< one row for each coupling, over the coordinates
  Eigen::VectorXd unit_;
  std::vector<int> outside_;
};

}  // namespace axode::higher_order
