#pragma once
#include <span>
#include <type_traits>
#include <vector>

#include "axode/recursion/solvability.hpp"

namespace axode {

/// The factors of M = LᵀDL. L is lower triangular with a unit diagonal; as in M, only entries of velocities
/// on one path are non-zero. The constructor allocates the memory. See (D4.7) and (D4.8) of docs/derivations.
template <class T = double> class MassMatrixFactor {
 public:
  explicit MassMatrixFactor(const Model& model);
  /// Factorises M. O(n d²), and O(nv²) to check its entries. If the mass matrix is singular, the factors must
  /// not be used. Throws std::invalid_argument for a wrong size, an M that is not symmetric, and a non-zero
  /// entry of velocities on different paths.
  Solvability factorize(std::type_identity_t<std::span<const T>> M);
  /// Replaces x by M⁻¹ x, O(n d).
  void solve(std::type_identity_t<std::span<T>> x) const;
  /// Computes M⁻¹, nv × nv entries, O(n² d).
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
  std::vector<T> H_, inertia_scale_;  ///< the factors, and the inertia scale of each velocity
};

}  // namespace axode
