#pragma once
#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>

#include "axode/model/model.hpp"
#include "axode/scalar/sine_cosine.hpp"

/// What counts as a singular mass matrix, in one place.
namespace axode {

/// Whether accelerations (or velocities) could be found from forces (or momenta): the mass matrix must be
/// positive definite. It is not where a joint moves no mass, or where it moves mass only as other joints do
/// as well. The inertia of a frame asks more: the frame must be able to move in all directions.
struct [[nodiscard]] Solvability {
  int singular_body = 0;    ///< the body on whose joint the elimination stopped; 0 where all went well
  bool not_finite = false;  ///< whether NaN or infinity came in, or came out because numbers overflowed
  int directions = 6;       ///< in which the frame can move whose inertia was asked for
  bool ok() const { return singular_body == 0 && !not_finite && directions == 6; }
  bool operator==(const Solvability&) const = default;
};
/// One sentence for the user.
std::string to_string(const Model& model, const Solvability& solvability);

/// The body that a velocity moves; of coupled joints that of the leader.
inline int body_of_velocity(const Topology& topology, int c) noexcept {
  int i = topology.n;
  while (topology.coupled[i] || topology.iv[i] > c) --i;
  return i;
}

/// The part of what feeds it with every joint at zero below which the quick kernels leave a pivot to those that look more
/// closely: a third of the digits, so that two such pivots in a row leave digits to the next. (It may be fed more in
/// other configurations.)
template <std::floating_point S>
inline constexpr S doubtful_part = std::same_as<S, float> ? S(4e-3) : S(1e-6);

/// Judges the pivots of an elimination.
template <class T> class PivotJudge {
 public:
  /// The pivot of velocity c: what is left, after the other joints have given way, of an inertia of the size fed(). It
  /// counts as 0 where it may be what rounding left of that.
  template <class Fed> void see(int c, const T& pivot, const Fed& fed) {
    if (singular_velocity_ >= 0 || T(16 * unit_roundoff<T>) * fed() < pivot)
      return;  // what follows the first is no news
    singular_velocity_ = c;
    not_finite_ = !(pivot - pivot < T(1));
  }
  Solvability verdict(const Topology& topology) const {
    if (not_finite_) return {.not_finite = true};
    return {.singular_body = singular_velocity_ < 0 ? 0 : body_of_velocity(topology, singular_velocity_)};
  }

 private:
  int singular_velocity_ = -1;
  bool not_finite_ = false;
};

/// Whether n numbers are finite: x - x is 0 or NaN. Several at once in four sums, for one sum waits for itself.
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

/// The verdict of an elimination, and on its n results: all NaN where it failed.
template <class T> Solvability solved(Solvability verdict, std::ptrdiff_t n, T* results) {
  if (!verdict.ok()) {
    for (std::ptrdiff_t k = 0; k < n; ++k) results[k] = T(std::numeric_limits<double>::quiet_NaN());
  } else if constexpr (std::floating_point<T>) {
    verdict.not_finite = !all_finite(n, results);
  }
  return verdict;
}
/// The same for several results.
template <class T> Solvability solved(Solvability verdict, std::initializer_list<std::span<T>> results) {
  Solvability all = verdict;
  for (const std::span<T>& x : results)
    if (const Solvability one = solved(verdict, std::ssize(x), x.data()); all.ok()) all = one;
  return all;
}

}  // namespace axode
