#pragma once
#include "axode/fast/poses.hpp"
#include "axode/lie/twist.hpp"

/// Stores results of fast kernels as consecutive numbers in memory. A kernel has each vector in a register of
/// four lanes, of which one is not used. If possible, several vectors are combined so that each store fills a
/// register.
namespace axode {

namespace packed {

/// A vector of four lanes that are selected from the vectors a and b by i, j, k and l, where 0 to 3 are the
/// lanes of a and 4 to 7 are those of b.
template <int i, int j, int k, int l, class T> Vector<T> select(const Vector<T>& a, const Vector<T>& b) {
#if defined(__clang__)
  return Vector<T>(__builtin_shufflevector(a.x, b.x, i, j, k, l));
#else
  using Integer = std::conditional_t<sizeof(T) == 8, long long, int>;
  using Order [[gnu::vector_size(4 * sizeof(T))]] = Integer;
  return Vector<T>(__builtin_shuffle(a.x, b.x, Order{i, j, k, l}));
#endif
}
/// Stores the first n lanes of a from `to` on.
template <int n, class T> void store(const Vector<T>& a, T* to) { __builtin_memcpy(to, &a.x, n * sizeof(T)); }

}  // namespace packed

/// The address of the numbers of which the entries x[0], x[1], ... consist, one after the other.
template <class T, class Entry> T* numbers(Entry* x) {
  static_assert(sizeof(Entry) % sizeof(T) == 0);
  return reinterpret_cast<T*>(x);
}

/// Stores the six numbers (a; b) of a twist or twist rate from `to` on.
template <class T> void store(const packed::Vector<T>& a, const packed::Vector<T>& b, T* to) {
  packed::store<4>(packed::select<0, 1, 2, 4>(a, b), to);
  packed::store<2>(packed::permute<1, 2, 3, 3>(b), to + 4);
}
template <class T> void store(const Vec3<T>& a, const Vec3<T>& b, T* to) {
  for (const T& x : {a.x, a.y, a.z, b.x, b.y, b.z}) *to++ = x;
}

/// Stores a pose as twelve consecutive numbers: the columns of R, then r.
template <class T> void store(const Placed<Packed<T>>& C, SE3<T>* to) {
  T* const at = numbers<T>(to);
  packed::store<4>(packed::select<0, 1, 2, 4>(C.R.x, C.R.y), at);
  packed::store<4>(packed::select<1, 2, 4, 5>(C.R.y, C.R.z), at + 4);
  packed::store<4>(packed::select<2, 4, 5, 6>(C.R.z, C.r), at + 8);
}
template <class T> void store(const Placed<Plain<T>>& C, SE3<T>* to) { *to = {C.R, C.r}; }

/// The transposed product (R F)ᵀ.
template <class G, class T> typename G::Matrix transposed(const typename G::Matrix& R, const SO3<T>& F) {
  using Spread = typename G::Spread;
  return typename G::Matrix(transpose(SO3<T>{R * Spread(F.x), R * Spread(F.y), R * Spread(F.z)}));
}

}  // namespace axode
