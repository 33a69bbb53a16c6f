#pragma once
#include <cstddef>

#include "axode/lie/vec3.hpp"
#include "axode/model/arena.hpp"
#include "axode/scalar/sine_cosine.hpp"

namespace axode {

/// SIMD lanes for computations in which no body depends on another one. If T is double or float, `width`
/// bodies are computed at once, one in each lane; if T has lanes of its own, as a Batch has, one body is
/// computed at a time. Numbers are stored in arrays, one for each component.
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
  /// Loads the first `room` numbers from p on, at most `width`; the other lanes are 0.
  static Number load(const T* p, int room) {
    if (room >= width) return load(p);
    T entries[width] = {};
    for (int l = 0; l < room; ++l) entries[l] = p[l];
    return load(entries);
  }
  /// Stores the first `room` lanes from p on, at most `width`.
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

/// The three numbers of a vector in memory, each loaded into all SIMD lanes.
template <class Number, class T, class Vector> Vec3<Number> spread(const Vector& a) noexcept {
  const T* const x = reinterpret_cast<const T*>(&a);
  return {Number(x[0]), Number(x[1]), Number(x[2])};
}

/// Arrays of numbers, one for each component of the entries: component k of entry i is array(k)[i]. A
/// register may be loaded from any entry on, because each array has room for the lanes beyond its last entry.
template <class T> struct Arrays {
  T* data;
  std::ptrdiff_t stride;

  T* array(int k) const { return data + k * stride; }
  using L = Lanes<T>;
  using Number = typename L::Number;

  Arrays(Arena& arena, int n, int entries) {
    // The stride is a whole number of registers. If each entry fills a cache line, the stride is odd instead,
    // so that the arrays do not share cache sets.
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
    const std::ptrdiff_t step = stride;  // a local copy, which no store can change
    L::store(a.x, p);
    L::store(a.y, p + step);
    L::store(a.z, p + 2 * step);
  }
  Vec3<T> get3(int k, int i) const {
    const T* const p = array(k) + i;
    return {p[0], p[stride], p[2 * stride]};
  }
  void set3(const Vec3<T>& a, int k, int i) const {
    T* const p = array(k) + i;
    p[0] = a.x;
    p[stride] = a.y;
    p[2 * stride] = a.z;
  }
  /// Returns Σ x[m] array(k + m)[i] over m = 0 to n - 1, the product of n numbers x with the components k to
  /// k + n - 1 of entry i (such as a wrench) of these arrays. The first SIMD lane has the result for entry i,
  /// the second lane that for entry i + 1, and so on.
  template <int n> Number product(const Number* x, int k, int i) const {
    const T* const p = array(k) + i;
    Number sum = x[0] * L::load(p);
    for (int m = 1; m < n; ++m) sum = sum + x[m] * L::load(p + m * stride);
    return sum;
  }
};

}  // namespace axode
