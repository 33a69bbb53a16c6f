#pragma once
#include <algorithm>
#include <array>

#include "axode/fast/lanes.hpp"
#include "axode/lie/packed.hpp"
#include "axode/lie/twist.hpp"
#include "axode/scalar/transpose.hpp"

namespace axode {

/// A row of n numbers for each body or joint screw. Code for one body writes and reads its row by a few
/// whole vectors; code in SIMD lanes transposes the rows of several bodies, one body in each lane.
/// Three-vectors begin at multiples of four, so that each fills a register of four lanes.
template <class T, int n> struct NumberRows {
  using L = Lanes<T>;
  using Number = typename L::Number;
  static constexpr int size = (n + 7) / 8 * 8;  ///< distance of two rows, a whole number of registers
  static constexpr int blocks = (n + L::width - 1) / L::width;  ///< registers of a row that are in use
  using Components = std::array<Number, size>;

  T* data;

  NumberRows(Arena& arena, int rows)
      : data(arena.lines<T>(static_cast<std::size_t>(rows + L::width) * static_cast<std::size_t>(size))) {}

  T* row(int i) const { return data + static_cast<std::ptrdiff_t>(i) * size; }

  /// Loads component k of the rows i(0), i(1), ..., one row in each lane, into x[k].
  template <class Row> [[gnu::always_inline]] void load(const Row& i, Components& x) const {
    if constexpr (L::width == 1) {
      const T* const from = row(i(0));
      for (int k = 0; k < n; ++k) x[k] = from[k];
    } else {
      const T* from[L::width];
      for (int l = 0; l < L::width; ++l) from[l] = row(i(l));
      unrolled<blocks>([&](auto b) __attribute__((always_inline)) {
        std::array<Number, L::width> block;
        unrolled<L::width>([&](auto l) __attribute__((always_inline)) {
          block[l] = L::load(from[l] + b * L::width);
        });
        transpose(block);
        unrolled<L::width>([&](auto l) __attribute__((always_inline)) { x[b * L::width + l] = block[l]; });
      });
    }
  }
  /// Stores lane l of x[k] as component k of row i + l.
  [[gnu::always_inline]] void store(const Components& x, int i) const {
    if constexpr (L::width == 1) {
      std::copy_n(x.data(), n, row(i));
    } else {
      T* const to = row(i);
      unrolled<blocks>([&](auto b) __attribute__((always_inline)) {
        std::array<Number, L::width> block;
        unrolled<L::width>([&](auto l) __attribute__((always_inline)) {
          block[l] = x[std::min(b * L::width + l, n - 1)];
        });
        transpose(block);
        unrolled<L::width>([&](auto l) __attribute__((always_inline)) {
          L::store(block[l], to + l * size + b * L::width);
        });
      });
    }
  }
  /// Replaces the row of each body but the ground by the sum of the rows of its subtree.
  void sum_subtrees(const Topology& topology) const noexcept {
    for (int i = topology.n; i > 0; --i) {
      if (topology.parent[i] == 0) continue;
      const T* const from = row(i);
      T* const to = row(topology.parent[i]);
      for (int k = 0; k < n; k += L::width) L::store(L::load(to + k) + L::load(from + k), to + k);
    }
  }

  /// The three-vectors of a row begin at its components 0, 4, 8, ...
  Vec3<T> get3(int i, int k) const { return {row(i)[k], row(i)[k + 1], row(i)[k + 2]}; }
  void set3(const Vec3<T>& a, int i, int k) const {
    T* const to = row(i) + k;
    to[0] = a.x;
    to[1] = a.y;
    to[2] = a.z;
  }
  void set3(const packed::Vector<T>& a, int i, int k) const requires std::floating_point<T> {
    __builtin_memcpy(row(i) + k, &a.x, sizeof a.x);
  }
  static Vec3<Number> vector(const Components& x, int k) { return {x[k], x[k + 1], x[k + 2]}; }
};

}  // namespace axode
