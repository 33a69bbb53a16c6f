#pragma once
#include <span>
#include <type_traits>
#include <vector>

#include "axode/recursion/solvability.hpp"

namespace axode {

/// The factors of a mass matrix M = LᵀDL, where L is lower triangular with a unit diagonal and D is diagonal
/// ((D4.7), (D4.8)). An entry of L is non-zero only if both of its velocities are on one path to the ground.
/// The constructor allocates.
template <class T = double> class MassMatrixFactor {
 public:
  explicit MassMatrixFactor(const Model& model);
  /// Factorises a mass matrix M (nv × nv, row by row). If M is singular, the returned Solvability says so,
  /// and the factors must not be used. Throws std::invalid_argument for a wrong size, an M that is not
  /// symmetric, and a non-zero entry of velocities on different paths. O(n d²) for a tree of depth d, and
  /// O(nv²) to check M.
  Solvability factorize(std::type_identity_t<std::span<const T>> M);
  /// Replaces x (nv numbers) by M⁻¹ x, after factorize(). O(n d) for a tree of depth d.
  void solve(std::type_identity_t<std::span<T>> x) const;
  /// Computes M⁻¹, nv × nv entries, after factorize(). O(n² d) for a tree of depth d.
  void inverse(std::type_identity_t<std::span<T>> M_inverse) const;
  /// Entry (c, p) of L.
  T L(int c, int p) const { return c == p ? T(1) : c < p ? T(0) : H_[at(c, p)]; }
  T D(int c) const { return H_[at(c, c)]; }
  int nv() const { return nv_; }

 private:
  std::size_t at(int r, int c) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(nv_) + static_cast<std::size_t>(c);
  }
  void check(std::span<const T> M) const;

  Model model_;
  int nv_;
  std::vector<T> H_, inertia_scale_;  ///< D and L in one matrix; size of the inertia of each velocity
};

}  // namespace axode
