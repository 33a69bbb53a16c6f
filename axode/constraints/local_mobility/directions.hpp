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

/// Whether an arc u(t) = e t + u_2 t² + ... solves the polynomial equations g(u) = 0 up to a given order in
/// t: g(u(t)) = O(t^(order + 1)) (D13.14). `rows` has the polynomials g, the coordinates u are the variables
/// of `ring`, and e is a unit vector in which the terms of lowest degree of all g vanish. The coefficients
/// u_2, u_3, ... are searched for by least squares.
bool arc_exists(PolynomialRings& rings, const PolynomialRing& ring, const std::vector<Form>& rows,
                const Eigen::VectorXd& e, int order);

}  // namespace axode::higher_order
