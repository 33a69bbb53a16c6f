#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/elimination.hpp"

namespace axode::higher_order {

/// A germ of a component of {g = 0}: z(w) for coordinates w of the germ.
struct Germ {
  const PolynomialRing* ring = nullptr;  ///< in the coordinates of the germ
  Eigen::MatrixXd z;                     ///< a row for each unknown of g
  bool settled = false;                  ///< whether enough orders are left to exclude a further equation
  bool multiple = false;                 ///< whether the equations hold doubly along the germ
};

/// Returns the real germs of {g = 0} at 0, for an elimination with g and `scale`. Elimination, blow-ups
/// (D13.11) and deflation (D13.12) take turns.
std::vector<Germ> germs(PolynomialRings& rings, const PolynomialRing& ring, const Eigen::MatrixXd& g,
                        const std::vector<double>& scale, int depth = 0);

}  // namespace axode::higher_order
