#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {

/// Determines which loop equations A v = 0 are independent, in the order of the loops, and how the redundant
/// ones depend on them. It applies the Gram-Schmidt process to the columns of Y = D^-½ L⁻ᵀ Aᵀ, which do not
/// depend on units; L and D are the factors of the mass matrix LᵀD L of the spanning tree. It serves reports
/// and computations that need a rank; accelerations are computed without it. Allocates; O(m² nv + nv³) for m
/// equations.
template <class T> class AXODE_ENTRY IndependentRows {
 public:
  using Vector = Eigen::VectorX<T>;
  using Matrix = Eigen::MatrixX<T>;

  /// Analyses the loop equations at the position or the velocity level, at the present kinematics of the
  /// system. An equation is redundant if its column of Y = D^-½ L⁻ᵀ Aᵀ, after the projection on the columns
  /// of earlier independent equations has been subtracted, has a norm of at most `part` times the size of the
  /// equation, LoopSystem::scale() (D7.7).
  IndependentRows(LoopSystem<T>& system, ConstraintLevel level,
                  T part = std::same_as<T, float> ? T(1e-4) : T(1e-8));

  int rank() const { return static_cast<int>(independent.size()); }

  /// Computes N with A N = 0: an orthonormal basis of the velocities that the loops allow, nv × (nv - rank).
  Matrix kernel() const;

  /// Computes multipliers λ of the loop equations A v = 0 whose constraint forces Aᵀ λ are nearest to f (nv)
  /// in the sense of least squares. If many multipliers give these forces, it takes those for which Σ d² λ²
  /// is least, with the sizes d of the equations, LoopSystem::scale() (D7.11).
  void least_multipliers(const Vector& f, std::span<T> lambda) const;

  std::vector<int> independent, redundant;
  Matrix dependencies;  ///< m × (number of redundant rows): column k is a vector n with nᵀ A = 0 and n = 1 at
                        ///< redundant row k

 private:
  void find_dependencies(const Matrix& Y);

  int nv_, m_;
  Matrix A_;
  Vector scale_;
};

}  // namespace axode
