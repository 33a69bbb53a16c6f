#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Determines which loop equations A v = 0 are independent, and how the redundant ones depend on them.
/// Equations are taken in the order of the loops. The method is the Gram-Schmidt process on the columns of Y
/// = D^-½ L⁻ᵀ Aᵀ, where LᵀD L is the mass matrix of the spanning tree. Y has a column for each equation, and
/// does not depend on the units of the joint velocities. Allocates; O(m² nv + nv³) for m equations.
template <class T> class AXODE_ENTRY IndependentRows {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;

  /// Determines the independent equations among the loop equations A v = 0 at the velocity level, or among
  /// the equations that make the position residuals 0, whose Jacobian is then A, at the position level. The
  /// kinematics must have been updated. Each equation has a column of Y = D^-½ L⁻ᵀ Aᵀ, with the mass matrix
  /// LᵀD L of the spanning tree. An equation is redundant if its column, minus the projection on earlier
  /// independent columns, has a norm of at most `part` times the size of the equation. This size is the norm
  /// of its column, but not less than a limit for rounding errors (D7.7).
  IndependentRows(LoopSystem<T>& system, ConstraintLevel level,
                  T part = std::same_as<T, float> ? T(1e-4) : T(1e-8));

  int rank() const { return static_cast<int>(independent.size()); }

  /// Computes N with A N = 0: an orthonormal basis of the velocities that the loops allow, nv × (nv - rank).
  Matrix kernel() const;
  /// Computes an orthonormal basis, as columns, of the drive forces that move the mechanism, for drives at
  /// the velocities `drives`. Forces orthogonal to them only act against each other and against the loops.
  /// Their number is decided for the velocities D^½ v, on which the unit of length has no influence, with the
  /// limit for redundant equations.
  Eigen::MatrixXd effective_forces(const std::vector<int>& drives) const;

  /// Computes multipliers λ of the loop equations A v = 0 for which the constraint forces Aᵀ λ approximate
  /// the forces f (nv) best (least squares). If several do, the least Σ d² λ² decides, where d² is the
  /// diagonal entry of A M⁻¹ Aᵀ for an equation, with the mass matrix M, but not less than a lower limit
  /// (D7.11).
  void least_multipliers(const Vector& f, std::span<T> lambda) const;

  std::vector<int> independent, redundant;
  Matrix dependencies;  ///< m × (number of redundant rows): column k is a vector n with nᵀ A = 0 and n = 1 at
                        ///< redundant row k

 private:
  void find_dependencies(const Matrix& Y);

  int nv_, m_;
  T part_;
  Matrix A_;
  Vector scale_, root_;
};

}  // namespace axode
