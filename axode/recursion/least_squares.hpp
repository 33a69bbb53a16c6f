#pragma once
#include <Eigen/Core>

namespace axode {

/// Computes A⁺ B: of all X that minimise ‖A X - B‖, column by column, the one with the least norm. The rank
/// of A is the number of pivots of a complete orthogonal decomposition that are larger than the number `part`
/// times the largest pivot. Allocates, O(rows cols min(rows, cols)).
Eigen::MatrixXd least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A,
                              const Eigen::Ref<const Eigen::MatrixXd>& B, double part);

}  // namespace axode
