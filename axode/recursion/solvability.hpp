#pragma once
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "axode/model/model.hpp"
#include "axode/scalar/sine_cosine.hpp"

/// The criterion by which a mass matrix counts as singular, in one place for all algorithms.
namespace axode {

/// Whether accelerations could be computed from forces, or velocities from momenta. This needs a positive
/// definite mass matrix. The mass matrix is singular if some motion of the joints moves no mass: the motion
/// of a joint without mass, or of several joints whose motions cancel for all bodies with mass. An
/// operational-space inertia exists only if, in addition, the frame can move in all six directions.
struct [[nodiscard]] Solvability {
  int singular_body = 0;    ///< the body of the joint with the first pivot that counts as 0, or 0
  bool not_finite = false;  ///< whether an argument is NaN or infinite, or a result overflowed
  int directions = 6;       ///< operational-space inertia: directions in which the frame can move
  /// The body of a joint whose gear locks itself so strongly that there are no or several accelerations; 0 if
  /// there is none. See (D9.12).
  int locked_body = 0;
  bool ok() const { return singular_body == 0 && !not_finite && directions == 6 && locked_body == 0; }
  bool operator==(const Solvability&) const = default;
};
/// One sentence: whether the mass matrix is positive definite, or else the reason, the joint and a remedy.
std::string to_string(const Model& model, const Solvability& solvability);

/// The body whose joint has velocity c. If coupled joints share the velocity, it is the body of their leader.
inline int body_of_velocity(const Topology& topology, int c) noexcept {
  int i = topology.n;
  while (topology.coupled[i] || topology.iv[i] > c) --i;
  return i;
}

/// Relative threshold for pivots of the mass matrix. If a pivot is less than this fraction of the inertia
/// that its velocity moves at q = 0 (Tree::inertia_scale), the mass matrix may be singular, and an algorithm
/// that estimates rounding errors takes over.
template <class T>
inline constexpr auto pivot_threshold =
    std::conditional_t<std::floating_point<T>, T, double>(unit_roundoff<T> > 1e-10 ? 4e-3 : 1e-6);

/// Determines from the pivots of an elimination whether the mass matrix is singular (D4.10).
template <class T> class PivotCheck {
 public:
  /// Checks the pivot of velocity c, which is the inertia that remains after the elimination of other
  /// velocities. It was computed from numbers of the magnitude scale(), and counts as 0 if it is so small
  /// that it may be a rounding error of these numbers. Only the first pivot that counts as 0 is stored.
  template <class Scale> void add(int c, const T& pivot, const Scale& scale) {
    if (singular_velocity_ >= 0 || T(16 * unit_roundoff<T>) * scale() < pivot) return;
    singular_velocity_ = c;
    not_finite_ = !(pivot - pivot < T(1));
  }
  /// The result of all checks. If the first pivot that counts as 0 is NaN or infinite, it is not_finite.
  Solvability verdict(const Topology& topology) const {
    if (not_finite_) return {.not_finite = true};
    return {.singular_body = singular_velocity_ < 0 ? 0 : body_of_velocity(topology, singular_velocity_)};
  }

 private:
  int singular_velocity_ = -1;
  bool not_finite_ = false;
};

/// Whether the n numbers x are all finite, by the sum of x - x, which is 0 or NaN.
template <std::floating_point T> bool all_finite(std::ptrdiff_t n, const T* x) {
  using Several = Batch<T, native_lanes<T>>;
  constexpr std::ptrdiff_t lanes = native_lanes<T>;
  Several sum[4]{T(0), T(0), T(0), T(0)};
  const auto add = [&](int m, const T* at) {
    const Several several = Several::load(at);
    sum[m] += several - several;
  };
  std::ptrdiff_t k = 0;
  for (; k + 4 * lanes <= n; k += 4 * lanes)
    for (int m = 0; m < 4; ++m) add(m, x + k + m * lanes);
  for (; k + lanes <= n; k += lanes) add(0, x + k);
  T rest(0);
  for (; k < n; ++k) rest += x[k] - x[k];
  const Several all = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  for (std::size_t l = 0; l < native_lanes<T>; ++l) rest += all[l];
  return rest == T(0);
}

/// Returns the verdict on a computation with n results: whether the elimination succeeded (`verdict`) and,
/// for floating-point T, whether all results are finite. If the elimination failed, all results are set to
/// NaN.
template <class T> Solvability solved(Solvability verdict, std::ptrdiff_t n, T* results) {
  if (!verdict.ok()) {
    for (std::ptrdiff_t k = 0; k < n; ++k) results[k] = T(std::numeric_limits<double>::quiet_NaN());
  } else if constexpr (std::floating_point<T>) {
    verdict.not_finite = !all_finite(n, results);
  }
  return verdict;
}
/// Returns the verdict on a computation with several arrays of results: whether the elimination succeeded
/// (`verdict`) and whether all results are finite. If the elimination failed, all results are set to NaN.
template <class T> Solvability solved(Solvability verdict, std::initializer_list<std::span<T>> results) {
  Solvability all = verdict;
  for (const std::span<T>& x : results)
    if (const Solvability one = solved(verdict, std::ssize(x), x.data()); all.ok()) all = one;
  return all;
}

}  // namespace axode
