#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "axode/constraints/local_mobility/decompositions.hpp"
#include "axode/constraints/local_mobility/polynomial_ring.hpp"

namespace axode::higher_order {

/// The bounds below which numbers are taken as 0, relative to numbers of the size 1.
inline constexpr double rank_tolerance = 1e-7;
inline constexpr double coefficient_tolerance = 1e-6;

/// Equations φ(z) = 0 with φ(0) = 0: the values of φ for polynomials z, up to a degree.
using Equations =
    std::function<Eigen::MatrixXd(const PolynomialRing& ring, const Eigen::MatrixXd& z, int degree)>;

/// The equations after the unknowns that their derivative determines are eliminated (D13.8, D13.9).
struct Elimination {
  int rank = 0;
  Eigen::VectorXd singular_values;       ///< of the derivative
  const PolynomialRing* ring = nullptr;  ///< in the coordinates u of the kernel; null if the kernel is {0}
  Eigen::MatrixXd z;                     ///< z(u), which solves the equations of the range
  Eigen::MatrixXd left;                  ///< a basis of the left null space of the derivative
  /// For each degree, the largest coefficient of z and g up to that degree, and at least 1. Coefficients grow
  /// near a singularity, and their rounding errors with them.
  std::vector<double> scale;
  Eigen::MatrixXd g;  ///< the remaining equations g(u) = 0, whose terms begin with degree 2
};

/// The rank of a derivative.
int rank_of(const SingularValues& svd);

/// Eliminates the range of A = ∂φ/∂z at 0, up to degree K.
Elimination eliminate(PolynomialRings& rings, const Equations& phi, const Eigen::MatrixXd& A, int K);

/// A polynomial whose terms begin with degree `degree`.
struct Form {
  int degree;
  Eigen::RowVectorXd p;
  Eigen::VectorXd combination;  ///< the rows of g that it combines
};

/// Combines the rows of g so that their terms of lowest degree are linearly independent in each degree
/// (D13.10). Rows that vanish up to degree K are left out. `scale` is that of the elimination.
std::vector<Form> independent_forms(const PolynomialRing& ring, const Eigen::MatrixXd& g,
                                    const std::vector<double>& scale);

}  // namespace axode::higher_order
