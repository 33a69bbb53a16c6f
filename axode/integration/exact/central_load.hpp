#pragma once
#include <Eigen/Core>
#include <vector>

namespace axode {

/// A condition for the loads λ of constraints: the least `reserve` by which it holds.
struct LoadCondition {
  int normal = 0;            ///< index of the load λ_N ≥ 0
  std::vector<int> tangent;  ///< loads with |f λ_T| ≤ λ_N, or none
  Eigen::VectorXd factors;   ///< f, the inverse coefficients of friction
  double bound = 0;          ///< if positive: |λ_N| ≤ bound instead of λ_N ≥ 0
  double weight = 1;         ///< factor of the reserve
};

/// The reserve of the loads λ: the least, over all conditions, of weight λ_N, weight (λ_N - |f λ_T|) or
/// weight (bound - |λ_N|). Infinity if there are no conditions.
double least_reserve(const std::vector<LoadCondition>& conditions, const Eigen::VectorXd& lambda);

/// Moves the loads λ along the columns of `basis` to those with the largest reserve, up to `most`, and
/// returns this reserve (D11.31); loads with a reserve of 1e-3 `most` are left as they are. It is found by an
/// interior-point method to about 1e-14 of `most`. O(k³) for each of some hundred iterations, with k columns.
/// Allocates.
double maximise_reserve(const std::vector<LoadCondition>& conditions, const Eigen::MatrixXd& basis,
                        double most, Eigen::VectorXd& lambda);

}  // namespace axode
