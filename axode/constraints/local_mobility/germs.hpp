#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/elimination.hpp"

namespace axode::higher_order {

/// A germ of a component of the set {g = 0} at 0: polynomials z(w) in the coordinates w of the germ.
struct Germ {
  const PolynomialRing* ring = nullptr;  ///< polynomials in the coordinates w of the germ
  Eigen::MatrixXd z;                     ///< one row for each unknown of g
  bool settled = false;                  ///< whether enough orders remain to exclude a further equation
  bool multiple = false;                 ///< whether the equations hold doubly, as squares do, along the germ
};

/// Returns the power series (germs) at 0 of the real solutions of polynomial equations g = 0 without linear
/// terms. The methods are elimination, blow-ups, which substitute a direction and a distance for the unknowns
/// (D13.11), and deflation, which adds unknowns for multiple solutions (D13.12). Rounding errors of
/// coefficients of degree k are proportional to entry k of `scale`. `depth` is the number of blow-ups from
/// which the equations g = 0 result.
std::vector<Germ> germs(PolynomialRings& rings, const PolynomialRing& ring, const Eigen::MatrixXd& g,
                        const std::vector<double>& scale, int depth = 0);

}  // namespace axode::higher_order
