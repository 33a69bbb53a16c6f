#include "axode/dynamics/mass_matrix/mass_matrix_factor.hpp"

#include <algorithm>
#include <cmath>

#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/sparse_factor.hpp"

namespace axode {

template <class T>
MassMatrixFactor<T>::MassMatrixFactor(const Model& model)
    : model_(model),
      nv_(model.nv()),
      H_(static_cast<std::size_t>(nv_) * static_cast<std::size_t>(nv_)),
      inertia_scale_(static_cast<std::size_t>(nv_)) {
  const Tree<T>& tree = model_.tree<T>();
  for (int i = 1; i <= tree->n; ++i)
    for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s)
      inertia_scale_[static_cast<std::size_t>(tree->iv[i] + s - tree->first_screw[i])] +=
          tree.inertia_scale[s];
}

/// Throws std::invalid_argument if the mass matrix M is not symmetric, or if an entry M_rc is not 0 although
/// neither of the velocities r and c is an ancestor of the other in the elimination tree of M. Without
/// couplings the ancestors of a velocity are the velocities before it on the path from the ground. A number
/// counts as 0 if it is at most 1e-9 √(M_rr M_cc), or 1e-3 √(M_rr M_cc) for float.
template <class T> void MassMatrixFactor<T>::check(std::span<const T> M) const {
  const std::vector<int>& parent = model_.topology().velocity_parent;
  constexpr double rounding = std::same_as<T, double> ? 1e-9 : 1e-3;
  const auto entry = [&](int r, int c) { return static_cast<double>(M[at(r, c)]); };
  const auto refuse = [&](int r, int c, const std::string& why) {
    throw std::invalid_argument("M(" + std::to_string(r) + ", " + std::to_string(c) + ") is " +
                                to_text(entry(r, c)) + why);
  };
  for (int r = 0; r < nv_; ++r)
    for (int c = r - 1, path = parent[r]; c >= 0; --c) {
      const double size = rounding * std::sqrt(std::abs(entry(r, r) * entry(c, c)));
      if (std::abs(entry(r, c) - entry(c, r)) > size)
        refuse(r, c,
               " and M(" + std::to_string(c) + ", " + std::to_string(r) + ") is " + to_text(entry(c, r)) +
                   "; a mass matrix is symmetric");
      while (path > c) path = parent[path];
      if (path != c && std::abs(entry(r, c)) > size)
        refuse(r, c,
               "; velocities " + std::to_string(r) + " and " + std::to_string(c) +
                   " are on different paths, where a mass matrix is 0");
    }
}

template <class T> Solvability MassMatrixFactor<T>::factorize(std::type_identity_t<std::span<const T>> M) {
  check_size("M", M.size(), H_.size(), "nv * nv");
  check(M);
  std::copy(M.begin(), M.end(), H_.begin());
  PivotCheck<T> check;
  axode::factorize(model_.tree<T>(), inertia_scale_.data(), H_.data(), check);
  return check.verdict(model_.topology());
}

template <class T> void MassMatrixFactor<T>::solve(std::type_identity_t<std::span<T>> x) const {
  check_size("x", x.size(), static_cast<std::size_t>(nv_), "nv");
  axode::solve(model_.tree<T>(), H_.data(), x.data());
}

template <class T> void MassMatrixFactor<T>::inverse(std::type_identity_t<std::span<T>> M_inverse) const {
  check_size("M_inverse", M_inverse.size(), H_.size(), "nv * nv");
  const std::size_t nv = static_cast<std::size_t>(nv_);
  std::fill(M_inverse.begin(), M_inverse.end(), T(0));
  for (std::size_t c = 0; c < nv; ++c) {
    M_inverse[c * nv + c] = T(1);
    solve(M_inverse.subspan(c * nv, nv));
  }
}

template class MassMatrixFactor<double>;
template class MassMatrixFactor<float>;

}  // namespace axode
