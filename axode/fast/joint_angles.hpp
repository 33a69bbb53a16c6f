#pragma once
#include "axode/model/arena.hpp"
#include "axode/model/tree.hpp"
#include "axode/scalar/sine_cosine.hpp"

namespace axode {

/// Sine and cosine of the first coordinate of joint i, in entry i - 1; not used if it is not an angle.
template <class T> struct JointAngles {
  T* sine;
  T* cosine;

  explicit JointAngles(Arena& arena) : sine(arena.per_lane<T>()), cosine(arena.per_lane<T>()) {}

  template <class S> void run(const Tree<S>& tree, const T* q) noexcept {
    if constexpr (std::floating_point<T>) {
      constexpr int lanes = static_cast<int>(native_lanes<T>);
      for (int k = 0; k < tree->n; k += lanes) {
        Batch<T, native_lanes<T>> angle;
        for (int l = 0; l < lanes; ++l) angle.x[l] = q[tree->angle[k + l]];
        const auto r = sine_cosine(angle);
        r.sine.store(sine + k);
        r.cosine.store(cosine + k);
      }
    } else {
      for (int k = 0; k < tree->n; ++k) set(k, q[tree->angle[k]]);
    }
    for (const int i : tree->coupled_bodies)
      set(i - 1, T(tree.ratio[i]) * q[tree->iq[i]] + T(tree.offset[i]));
  }

 private:
  void set(int k, const T& angle) {
    const SineCosine<T> r = sine_cosine(angle);
    sine[k] = r.sine;
    cosine[k] = r.cosine;
  }
};

}  // namespace axode
