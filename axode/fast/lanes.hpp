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
};
template <std::floating_point T> struct Lanes<T> {
  using Number = Batch<T, native_lanes<double>>;
  static constexpr int width = static_cast<int>(native_lanes<double>);
  static Number load(const T* p) { return Number::load(p); }
  static void store(const Number& x, T* p) { x.store(p); }
};

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
    return {L::load(array(k) + i), L::load(array(k + 1) + i), L::load(array(k + 2) + i)};
  }
  void store3(const Vec3<Number>& a, int k, int i) const {
    L::store(a.x, array(k) + i), L::store(a.y, array(k + 1) + i), L::store(a.z, array(k + 2) + i);
  }
  Vec3<T> get3(int k, int i) const { return {array(k)[i], array(k + 1)[i], array(k + 2)[i]}; }
  void set3(const Vec3<T>& a, int k, int i) const {
    array(k)[i] = a.x, array(k + 1)[i] = a.y, array(k + 2)[i] = a.z;
  }
};

}  // namespace axode
