#pragma once
#include <Eigen/Core>
#include <vector>

#include "axode/constraints/local_mobility/polynomial_ring.hpp"
#include "axode/constraints/local_mobility/walks.hpp"

/// Series of the product of exponentials of a loop, by brackets alone. A series is a matrix of polynomials,
/// 6 × ring.size().
namespace axode::higher_order {

/// The spatial twist of the last body along rays, multiplied by the parameter of the ray, for polynomials x
/// (n × ring.size()) without constants, up to a degree (D13.3, D13.4).
Eigen::MatrixXd twist_series(const PolynomialRing& ring, const std::vector<PassedJoint>& loop,
                             const Eigen::Ref<const Eigen::MatrixXd>& x, int degree);

/// log f of the product f from its twist_series (D13.6).
Eigen::MatrixXd logarithm_series(const PolynomialRing& ring, const Eigen::MatrixXd& V, int degree);

}  // namespace axode::higher_order
