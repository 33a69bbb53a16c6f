#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/recursion/decompositions.hpp"

namespace axode::higher_order {

/// Bounds below which singular values and coefficients of polynomials count as 0, relative to size 1.
inline constexpr double rank_tolerance = 1e-7;
inline constexpr double coefficient_tolerance = 1e-6;

/// Equations φ(z) = 0 with φ(0) = 0, as a function that computes the polynomials φ(z), up to degree `degree`,
/// for polynomials z in the variables of `ring`.
using Equations =
    std::function<Eigen::MatrixXd(const PolynomialRing& ring, const Eigen::MatrixXd& z, int degree)>;

/// The result of eliminating unknowns from equations φ(z) = 0. The unknowns that the derivative of φ at 0
/// determines are eliminated, and the equations g(u) = 0 remain for coordinates u in the kernel of this
/// derivative (D13.7 to D13.9).
struct Elimination {
  int rank = 0;
  Eigen::VectorXd singular_values;       ///< singular values of the derivative of φ at 0
  const PolynomialRing* ring = nullptr;  ///< polynomials in the coordinates u of the kernel; null if the
                                         ///< kernel is {0}
  Eigen::MatrixXd z;                     ///< polynomials z(u) that solve the equations in the range of the
                                         ///< derivative
  Eigen::MatrixXd left;                  ///< columns: a basis of the left null space of the derivative
  /// Entry k is the largest absolute coefficient, up to degree k, of the polynomials z(u) and g(u), but at
  /// least 1. Rounding errors of coefficients of degree k are proportional to it. The polynomials z(u) solve
  /// the equations φ(z) = 0 as far as their derivative at 0 determines z, and g(u) = 0 are the equations that
  /// remain for the coordinates u of the kernel of this derivative.
  std::vector<double> scale;
  Eigen::MatrixXd g;  ///< the remaining equations g(u) = 0, whose terms begin with degree 2
};

/// The number of singular values of a derivative that do not count as 0.
int rank_of(const SingularValues& svd);

/// Eliminates from φ(z) = 0 the unknowns that A = ∂φ/∂z at 0 determines, up to degree K.
Elimination eliminate(PolynomialRings& rings, const Equations& phi, const Eigen::MatrixXd& A, int K);

/// A polynomial p, a combination of rows of g, whose terms of lowest degree have degree `degree`.
struct Form {
  int degree;
  Eigen::RowVectorXd p;
  Eigen::VectorXd combination;  ///< coefficients of the combination, one for each row of g
};

/// Combines the polynomials g, one in each row, such that the terms of lowest degree of those combinations
/// that begin with the same degree are linearly independent (D13.10). Combinations that vanish are left out;
/// a coefficient vanishes if it is small compared with `scale` of its degree.
std::vector<Form> independent_forms(const PolynomialRing& ring, const Eigen::MatrixXd& g,
                                    const std::vector<double>& scale);

}  // namespace axode::higher_order
