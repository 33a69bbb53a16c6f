#pragma once
#include <cmath>
#include <ranges>

#include "axode/lie/inertia.hpp"

/// finite(x) says whether every number of a vector, tensor, pose or range is finite.
namespace axode {

inline bool finite(double x) { return std::isfinite(x); }
inline bool finite(const Vec3<>& a) { return finite(a.x) && finite(a.y) && finite(a.z); }
inline bool finite(const SO3<>& R) { return finite(R.x) && finite(R.y) && finite(R.z); }
inline bool finite(const SE3<>& C) { return finite(C.R) && finite(C.r); }
inline bool finite(const Sym3<>& A) {
  return finite(Vec3<>{A.xx, A.yy, A.zz}) && finite(Vec3<>{A.xy, A.xz, A.yz});
}
inline bool finite(const Inertia<>& M) { return finite(M.m) && finite(M.h) && finite(M.Theta); }
/// Whether all numbers of a range are finite, without branches, so that the compiler can vectorise the loop.
template <std::ranges::range Numbers> bool finite(const Numbers& x) {
  std::ranges::range_value_t<Numbers> none(0);
  for (const auto x_k : x) none += x_k - x_k;
  return none == none;
}

}  // namespace axode
