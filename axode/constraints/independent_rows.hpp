#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system.hpp"

namespace axode {

/// Which rows of the loops are independent, in the order of the loops, and how the others depend on them: Gram and
/// Schmidt's way on the columns of Y, where units do not matter. For reports and for what needs a rank; accelerations do
/// not. Allocates, O(m² nv + nv³).
template <class T> class IndependentRows {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;

  /// At the place where the system is. A row is redundant by others where what they leave of it is less than a part of its
  /// size: 1e-8 (float 1e-4), or how far the loops are from closed.
  IndependentRows(LoopSystem<T>& system, ConstraintLevel level,
                  T part = std::same_as<T, float> ? T(1e-4) : T(1e-8));

  int rank() const { return static_cast<int>(independent.size()); }

  /// N with A N = 0: an orthonormal basis of the velocities that the loops allow, nv × (nv - rank).
  Matrix kernel() const;

  /// λ with Aᵀ λ = f as far as there is one, least in Σ d² λ² with the sizes d of the rows.
  void least_multipliers(const Vector& f, std::span<T> lambda) const;

  std::vector<int> independent, redundant;
  Matrix dependencies;  ///< m × redundant: the n with nᵀ A = 0

 private:
  void find_dependencies(const Matrix& Y);

  int nv_, m_;
  Matrix A_;
  Vector scale_;
};

}  // namespace axode
