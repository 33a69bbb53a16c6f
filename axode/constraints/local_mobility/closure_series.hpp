#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/constraints/local_mobility/walks.hpp"

/// Power series of the product f of the joint exponentials around a loop, which is the identity if the loop
/// is closed, computed from brackets of joint screws. A series is a matrix of coefficients with six rows.
namespace axode::higher_order {

/// Computes the power series of the spatial twist of the last body of a loop, for joint coordinates that grow
/// in proportion to a parameter from 0; the twist is multiplied by this parameter. The coordinates x are n
/// polynomials without constants. Terms up to `degree` are computed (D13.3, D13.4).
Eigen::MatrixXd twist_series(const PolynomialRing& ring, const std::vector<PassedJoint>& loop,
                             const Eigen::Ref<const Eigen::MatrixXd>& x, int degree);

/// Computes log f of the product f of exponentials from its twist_series() V, up to a degree (D13.6).
Eigen::MatrixXd logarithm_series(const PolynomialRing& ring, const Eigen::MatrixXd& V, int degree);

}  // namespace axode::higher_order
