#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/elimination.hpp"

namespace axode::higher_order {

/// A real direction in which all leading forms vanish.
struct Direction {
  Eigen::VectorXd e;  ///< of norm 1; stands for -e as well
  int dimension = 1;  ///< dimension of the cone of such directions near e
};

/// Directions e with F_i(e) = 0 for the leading form F_i of every row. All are found for two variables, as
/// common roots of binary forms. For more variables a search from random starts finds them, with the same
/// starts in every call; of a cone of dimension above 1 some directions stand for the others.
std::vector<Direction> common_zeros(const PolynomialRings& rings, const PolynomialRing& ring,
                                    const std::vector<Form>& rows);

/// Whether an arc u = e t + u_2 t² + ... has g(u(t)) = O(t^(order + 1)) for all rows (D13.14).
bool arc_exists(PolynomialRings& rings, const PolynomialRing& ring, const std::vector<Form>& rows,
                const Eigen::VectorXd& e, int order);

}  // namespace axode::higher_order
