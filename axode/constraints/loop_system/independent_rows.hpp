#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Determines independent rows of the loops, in the order of the loops, and the dependencies of the redundant
/// rows on them. It applies the Gram-Schmidt process to the columns of Y, which do not depend on units. It
/// serves reports and computations that need a rank; accelerations are computed without it. Allocates; O(m²
/// nv + nv³).
template <class T> class AXODE_ENTRY IndependentRows {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;

  /// Uses the present kinematics of the system. A row is redundant if less than `part` of its size remains
  /// after its projection on the rows before it has been subtracted.
  IndependentRows(LoopSystem<T>& system, ConstraintLevel level,
                  T part = std::same_as<T, float> ? T(1e-4) : T(1e-8));

  int rank() const { return static_cast<int>(independent.size()); }

  /// N with A N = 0: an orthonormal basis of the velocities that the loops allow, nv × (nv - rank).
  Matrix kernel() const;

  /// The least-squares solution λ of Aᵀ λ = f with the least Σ d² λ² for the sizes d of the rows (D7.11).
  void least_multipliers(const Vector& f, std::span<T> lambda) const;

  std::vector<int> independent, redundant;
  Matrix dependencies;  ///< m × number of redundant rows: columns n with nᵀ A = 0

 private:
  void find_dependencies(const Matrix& Y);

  int nv_, m_;
  Matrix A_;
  Vector scale_;
};

}  // namespace axode
