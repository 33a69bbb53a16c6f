#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/constraints/local_mobility/walks.hpp"

/// Computes power series for a loop of joints by Lie brackets of joint screws. The joint coordinates are
/// given polynomials in some variables, and the series are in these variables. One series is log f, where f
/// is the product of the exponentials of all joints around the loop, the identity if the loop is closed. The
/// other series is t times the spatial twist of the last body of the loop, if the variables move along a ray
/// t u from 0 with t as time. A series is a matrix of coefficients with a row for each of the six screw
/// coordinates and a column for each monomial.
namespace axode::higher_order {

/// Computes the power series V of the spatial twist of the last body of a loop, up to the given degree. The
/// coordinates x of the joints are n polynomials in the variables of `ring`, without constants. The variables
/// move along a ray t u from 0 with t as time, and V is the twist of this motion, multiplied by t (D13.3,
/// D13.4).
Eigen::MatrixXd twist_series(const PolynomialRing& ring, const std::vector<PassedJoint>& loop,
                             const Eigen::Ref<const Eigen::MatrixXd>& x, int degree);

/// Computes log f of the product f of exponentials from its twist_series() V, up to a degree (D13.6).
Eigen::MatrixXd logarithm_series(const PolynomialRing& ring, const Eigen::MatrixXd& V, int degree);

}  // namespace axode::higher_order
