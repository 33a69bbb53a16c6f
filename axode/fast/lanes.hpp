#pragma once
#include <cstddef>

#include "axode/lie/vec3.hpp"
#include "axode/model/arena.hpp"
#include "axode/scalar/sine_cosine.hpp"

namespace axode {

/// How a sweep over bodies that do not depend on each other computes: several bodies at once in SIMD lanes
/// where T is one number, one body at a time where T has lanes of its own. Numbers lie in arrays, one for
/// each component.
template <class T> struct Lanes {
  using Number = T;
  static constexpr int width = 1;
  static const Number& load(const T* p) { return *p; }
  static void store(const Number& x, T* p) { *p = x; }
  static const Number& load(const T* p, int) { return *p; }
  static void store(const Number& x, T* p, int) { *p = x; }
};
template <std::floating_point T> struct Lanes<T> {
  using Number = Batch<T, native_lanes<double>>;
  static constexpr int width = static_cast<int>(native_lanes<double>);
  static Number load(const T* p) { return Number::load(p); }
  static void store(const Number& x, T* p) { x.store(p); }
  /// Where there are no more than so many numbers; the other lanes are 0.
  static Number load(const T* p, int room) {
    if (room >= width) return load(p);
    T entries[width] = {};
    for (int l = 0; l < room; ++l) entries[l] = p[l];
    return load(entries);
  }
  static void store(const Number& x, T* p, int room) {
    if (room >= width) [[likely]]
      store(x, p);
    else
      store_part(x, p, room);
  }

 private:
  [[gnu::noinline]] static void store_part(Number x, T* p, int room) {
    T entries[width];
    store(x, entries);
    for (int l = 0; l < room; ++l) p[l] = entries[l];
  }
};

/// A vector of T that lies in memory, each of its numbers in all lanes: reading spreads them for nothing.
template <class Number, class T, class Vector> Vec3<Number> spread(const Vector& a) noexcept {
  const T* const x = reinterpret_cast<const T*>(&a);
  return {Number(x[0]), Number(x[1]), Number(x[2])};
}

/// Arrays of n numbers each, with room for the lanes behind the last; component k of entry i is array(k)[i].
template <class T> struct Arrays {
  T* data;
  std::ptrdiff_t stride;

  T* array(int k) const { return data + k * stride; }
  using L = Lanes<T>;
  using Number = typename L::Number;

  Arrays(Arena& arena, int n, int entries) {
    // Whole registers; or, for entries as long as a cache line, an odd number of them, which no cache folds.
    constexpr std::ptrdiff_t lanes = Arena::most_lanes;
    stride = L::width > 1 ? (entries + 2 * lanes - 1) / lanes * lanes : entries | 1;
    data = arena.lines<T>(static_cast<std::size_t>(n * stride));
  }
  Vec3<Number> load3(int k, int i) const {
    const T* const p = array(k) + i;
    return {L::load(p), L::load(p + stride), L::load(p + 2 * stride)};
  }
  void store3(const Vec3<Number>& a, int k, int i) const {
    T* const p = array(k) + i;
    const std::ptrdiff_t step = stride;  // which no store can change
    L::store(a.x, p), L::store(a.y, p + step), L::store(a.z, p + 2 * step);
  }
  Vec3<T> get3(int k, int i) const {
    const T* const p = array(k) + i;
    return {p[0], p[stride], p[2 * stride]};
  }
  void set3(const Vec3<T>& a, int k, int i) const {
    T* const p = array(k) + i;
    p[0] = a.x, p[stride] = a.y, p[2 * stride] = a.z;
  }
  /// The sum of the products of n numbers with components k, k + 1, ... of entries i, i + 1, ...
  template <int n> Number product(const Number* x, int k, int i) const {
    const T* const p = array(k) + i;
    Number sum = x[0] * L::load(p);
    for (int m = 1; m < n; ++m) sum = sum + x[m] * L::load(p + m * stride);
    return sum;
  }
};

}  // namespace axode
