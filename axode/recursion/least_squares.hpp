#pragma once
#include <Eigen/Core>

namespace axode {

/// A⁺ B: the X of the least size among those with the least ‖A X - B‖, column by column. A column of A counts as a combination
/// of others where what these leave of it is less than a part of the largest. Allocates, O(rows cols min(rows, cols)).
///
/// All decompositions of this kind are made here: a compiler takes seconds for one of Eigen's wherever it stands.
Eigen::MatrixXd least_squares(const Eigen::Ref<const Eigen::MatrixXd>& A,
                              const Eigen::Ref<const Eigen::MatrixXd>& B, double part);

}  // namespace axode
