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

/// The reserve by which the loads λ satisfy all conditions: the least reserve of a condition. That of a
/// condition is its weight times λ_N, times λ_N - |f λ_T| if it has tangential loads, or times bound - |λ_N|
/// if it has a bound. Infinity if there are no conditions.
double least_reserve(const std::vector<LoadCondition>& conditions, const Eigen::VectorXd& lambda);

/// Moves the loads λ along the columns of `basis` to the loads whose reserve is largest, up to `most`, and
/// returns this reserve (D11.31). If λ already has a reserve of more than 1e-3 `most`, it is left as it is.
/// An interior-point method finds the reserve to about 1e-14 of `most`, in some hundred iterations of O(k³)
/// for k columns. Allocates.
double maximise_reserve(const std::vector<LoadCondition>& conditions, const Eigen::MatrixXd& basis,
                        double most, Eigen::VectorXd& lambda);

}  // namespace axode
