#pragma once
#include <algorithm>
#include <array>
#include <bit>

#include "axode/fast/lanes.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// The wrenches that unit multipliers of n consecutive equations of a loop exert on a body, one in each lane
/// of a SIMD register. They are moved from body to body along a path to the ground (D7.6).
template <class T, int n> struct RowsInLanes {
  using Rows = Batch<T, std::max(2U, std::bit_ceil(static_cast<unsigned>(n)))>;
  Vec3<Rows> m, f;

  RowsInLanes(const std::array<Wrench<Spatial, T>, 6>& W, int first) {
    const auto gather = [&](auto number) {
      Rows rows(T(0));
      for (std::size_t r = 0; r < n; ++r) rows.x[r] = number(W[static_cast<std::size_t>(first) + r]);
      return rows;
    };
    m = {gather([](const auto& F) { return F.m.x; }), gather([](const auto& F) { return F.m.y; }),
         gather([](const auto& F) { return F.m.z; })};
    f = {gather([](const auto& F) { return F.f.x; }), gather([](const auto& F) { return F.f.y; }),
         gather([](const auto& F) { return F.f.z; })};
  }

  friend RowsInLanes operator-(RowsInLanes F) {
    F.m = -F.m;
    F.f = -F.f;
    return F;
  }

  /// The vector a, repeated in every lane.
  template <class Vector> static Vec3<Rows> all(const Vector& a) { return spread<Rows, T>(a); }

  /// Moves the reference point of the wrenches from o to p; r is the vector from p to o.
  template <class Vector> void move(const Vector& r) { m += cross(all(r), f); }
  /// Removes from the wrenches F the part that the joint of screw S takes up, F -= x U (D7.6), and stores in
  /// `y` the entries D^-½ u, for this joint velocity, of the matrix Y of the scaled loop equations. Here U =
  /// M S with the articulated inertia M, D is the pivot of the velocity, u = Sᵀ F, and `root` is D^-½. x must
  /// be u / D, or u if U has been divided by D.
  template <class Vector>
  void eliminate(const Rows& u, const T& root, T* y, const Rows& x, const Vector& U_m, const Vector& U_f) {
    const Rows Y = Rows(root) * u;
    for (std::size_t r = 0; r < n; ++r) y[r] = Y[r];
    m -= x * all(U_m);
    f -= x * all(U_f);
  }
};

/// Calls f(std::integral_constant<int, n>()) for a number n from 1 to `most` that is known at run time only.
template <int most, class F> void with_number_of_rows(int n, const F& f) {
  if constexpr (most > 1)
    if (n < most) return with_number_of_rows<most - 1>(n, f);
  f(std::integral_constant<int, most>());
}
/// Divides the equations of a loop into groups of as many as one SIMD register holds (at most six), and calls
/// f(first, std::integral_constant<int, n>()) for each group of n equations from index `first` on.
template <class T, class F> void each_register_of_rows(int rows, const F& f) {
  constexpr int most = std::min(6, static_cast<int>(native_lanes<T>));
  for (int first = 0; first < rows; first += most)
    with_number_of_rows<most>(std::min(most, rows - first), [&](auto n) { f(first, n); });
}

}  // namespace axode
