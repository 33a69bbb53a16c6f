#pragma once
#include <concepts>
#include <vector>

#include "axode/lie/packed.hpp"
#include "axode/model/subgroup.hpp"

namespace axode {

/// The constants of one body in recursions over the tree: the pose of its joint frame at q = 0 in the joint
/// frame of its predecessor (rotation B, position r), and its inertia (mass m, first moment of mass h,
/// rotational inertia Theta about the origin). For a hinge with the angle θ, columns(sin θ, cos θ) returns
/// the rotation R = B exp(e_z θ), and rows(sin θ, cos θ) its transpose.
template <class G> struct BodyConstants;

template <class T> struct BodyConstants<Plain<T>> {
  SO3<T> B;
  Vec3<T> r, h;
  Sym3<T> Theta;
  T m;

  BodyConstants(const SE3<T>& B_i, const Inertia<T>& M)
      : B(B_i.R), r(B_i.r), h(M.h), Theta(M.Theta), m(M.m) {}
  SO3<T> columns(const T& s, const T& c) const { return subgroup::turn(B, s, c); }
  SO3<T> rows(const T& s, const T& c) const { return transpose(columns(s, c)); }
  const Vec3<T>& r_factor() const { return r; }
  const Vec3<T>& h_factor() const { return h; }
};

template <std::floating_point T> struct BodyConstants<Packed<T>> {
  packed::Matrix<T> B, Bt,
      exchanged;  ///< B.R, its transpose, and the columns of the transpose with x and y exchanged
  packed::Factor<T> r_, h_;
  Vec3<T> r, h;
  Sym3<T> Theta;
  T m;

  BodyConstants(const SE3<T>& B_i, const Inertia<T>& M)
      : B(B_i.R), Bt(transpose(B_i.R)), r_(B_i.r), h_(M.h), r(B_i.r), h(M.h), Theta(M.Theta), m(M.m) {
    const auto exchange = [](const packed::Vector<T>& a) { return packed::permute<1, 0, 2, 3>(a); };
    exchanged = {exchange(Bt.x), exchange(Bt.y), exchange(Bt.z)};
  }
  packed::Matrix<T> columns(T s, T c) const { return {c * B.x + s * B.y, c * B.y - s * B.x, B.z}; }
  packed::Matrix<T> rows(T s, T c) const {
    using V = packed::Vector<T>;
    const V cosine(c * V(T(1), T(1), T(0)).x + V(T(0), T(0), T(1)).x), sine = s * V(T(1), T(-1), T(0));
    const auto turn = [&](const V& a, const V& b) { return V(cosine.x * a.x + sine.x * b.x); };
    return {turn(Bt.x, exchanged.x), turn(Bt.y, exchanged.y), turn(Bt.z, exchanged.z)};
  }
  const packed::Factor<T>& r_factor() const { return r_; }
  const packed::Factor<T>& h_factor() const { return h_; }
};

/// The constants of all bodies, each vector in a SIMD register; empty if T is not a floating-point type.
template <class T> struct PackedConstants {};
template <std::floating_point T> struct PackedConstants<T> { std::vector<BodyConstants<Packed<T>>> body; };

}  // namespace axode
