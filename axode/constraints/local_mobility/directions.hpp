#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/elimination.hpp"

namespace axode::higher_order {

/// A real direction e in which all leading forms of an elimination vanish.
struct Direction {
  Eigen::VectorXd e;  ///< unit vector; -e is the same direction
  int dimension = 1;  ///< dimension of the cone of directions, near e, in which the leading forms vanish
};

/// Finds the directions e in which the leading form (the terms of lowest degree) of every equation vanishes.
/// For two variables these are all common roots of binary forms. For more variables they are found by
/// searches from fixed random starts. If such directions form a cone of dimension above 1, at most a fixed
/// number of them is returned.
std::vector<Direction> common_zeros(const PolynomialRings& rings, const PolynomialRing& ring,
                                    const std::vector<Form>& rows);

/// Whether an arc u(t) = e t + u_2 t² + ... in the direction e exists along which the polynomials g of all
/// equations vanish to the given order: g(u(t)) = O(t^(order + 1)) (D13.14).
bool arc_exists(PolynomialRings& rings, const PolynomialRing& ring, const std::vector<Form>& rows,
                const Eigen::VectorXd& e, int order);

}  // namespace axode::higher_order
