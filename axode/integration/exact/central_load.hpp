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

/// How far the loads λ (normal and tangential forces of constraints) are from violating a condition: the
/// least reserve of all conditions. The reserve of a condition is its weight times λ_N or, if it has
/// tangential loads, times λ_N - |f λ_T| with inverse coefficients of friction f or, if it has a bound, times
/// bound - |λ_N|. Infinity if there are no conditions.
double least_reserve(const std::vector<LoadCondition>& conditions, const Eigen::VectorXd& lambda);

/// Finds among the loads λ + `basis` z, with any vector z, those with the largest reserve, and returns this
/// reserve (D11.31). Loads are normal and tangential forces of constraints. Their reserve is the least margin
/// by which they obey their conditions, such as λ_N ≥ 0 or a friction cone, see least_reserve(). If λ itself
/// has a reserve of more than 1e-3 `most`, it is left as it is. Otherwise an interior-point method finds the
/// largest reserve up to `most`, to about 1e-14 of `most`, in some hundred iterations of O(k³) for k columns
/// of `basis`. Allocates.
double maximise_reserve(const std::vector<LoadCondition>& conditions, const Eigen::MatrixXd& basis,
                        double most, Eigen::VectorXd& lambda);

}  // namespace axode
