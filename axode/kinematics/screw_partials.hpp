#pragma once
#include <algorithm>
#include <vector>

#include "axode/kinematics/path.hpp"

/// Closed forms of the partial derivatives of the joint screws on the path to one place.
namespace axode {

/// A joint screw on the path to a place: its joint, the velocity that moves it, and its coordinates.
template <class T> struct PathScrew {
  int joint;
  int c;
  Screw<T> body_fixed;  ///< J_{f,c}^b
  Screw<T> spatial;     ///< J_c^s
};

/// The path to a place, from the root outwards.
template <class T> struct ScrewPath {
  std::vector<PathScrew<T>> screws;
  SE3<T> C;  ///< pose of the place

  ScrewPath(const Tree<T>& tree, const T* q, const Place<T>& place) {
    C = each_body_fixed_column(tree, q, place, [&](int i, int c, const Screw<T>& X) {
      screws.push_back({i, c, X, {}});
    });
    std::stable_sort(screws.begin(), screws.end(),
                     [](const auto& a, const auto& b) { return a.joint < b.joint; });
    for (PathScrew<T>& screw : screws) screw.spatial = Ad(C, screw.body_fixed);
  }
};

/// The derivatives of screw a along screws alpha, alpha[0] first; all are indices into path.screws.
///
/// Body-fixed (eq. nthorderBody): [...[[J_a, J_β1], J_β2]..., J_βν] for β sorted from the root outwards, zero
/// unless all lie outward of a. Among directions of one joint the one that acts last comes first.
template <class T> Screw<T> body_fixed_partial(const ScrewPath<T>& path, int a, std::vector<int> alpha) {
  const auto joint = [&](int k) { return path.screws[k].joint; };
  std::reverse(alpha.begin(), alpha.end());
  std::stable_sort(alpha.begin(), alpha.end(), [&](int k, int l) { return joint(k) < joint(l); });
  Screw<T> X = path.screws[a].body_fixed;
  for (const int k : alpha) {
    if (joint(k) <= joint(a)) return {};
    X = ad(X, path.screws[k].body_fixed);
  }
  return X;
}

/// Spatial (eq. nthorder): [J_βν, ...[J_β2, [J_β1, J_a]]...] for β sorted from the tip inwards, zero if one
/// lies outward of a or β1 is a itself. Among directions of one joint the one that acts last comes outermost.
template <class T> Screw<T> spatial_partial(const ScrewPath<T>& path, int a, std::vector<int> alpha) {
  const auto joint = [&](int k) { return path.screws[k].joint; };
  std::stable_sort(alpha.begin(), alpha.end(), [&](int k, int l) { return joint(k) > joint(l); });
  if (!alpha.empty() && alpha.front() == a) return {};
  Screw<T> X = path.screws[a].spatial;
  for (const int k : alpha) {
    if (joint(k) > joint(a)) return {};
    X = ad(path.screws[k].spatial, X);
  }
  return X;
}

/// The members of alpha whose bits are set in mask, in order.
inline std::vector<int> subset(const std::vector<int>& alpha, unsigned mask) {
  std::vector<int> members;
  for (std::size_t k = 0; k < alpha.size(); ++k)
    if (mask >> k & 1U) members.push_back(alpha[k]);
  return members;
}

template <class T> Vec3<T> position_partial(const ScrewPath<T>& path, const std::vector<int>& alpha);

/// Hybrid: J^h = (w; v + w × r) in the spatial (w; v), so the product rule over all ways to split alpha.
template <class T> Screw<T> hybrid_partial(const ScrewPath<T>& path, int a, const std::vector<int>& alpha) {
  Screw<T> X = spatial_partial(path, a, alpha);
  const unsigned all = (1U << alpha.size()) - 1;
  for (unsigned mask = 0; mask <= all; ++mask)
    X.v += cross(spatial_partial(path, a, subset(alpha, mask)).w,
                 position_partial(path, subset(alpha, all & ~mask)));
  return X;
}

/// The derivatives of the position r of the place: ∂r/∂q_k is the linear part of J_k^h.
template <class T> Vec3<T> position_partial(const ScrewPath<T>& path, const std::vector<int>& alpha) {
  if (alpha.empty()) return path.C.r;
  return hybrid_partial(path, alpha.front(), {alpha.begin() + 1, alpha.end()}).v;
}

template <class Rep, class T>
Screw<T> partial(const ScrewPath<T>& path, int a, const std::vector<int>& alpha) {
  if constexpr (std::same_as<Rep, BodyFixed>)
    return body_fixed_partial(path, a, alpha);
  else if constexpr (std::same_as<Rep, Spatial>)
    return spatial_partial(path, a, alpha);
  else if constexpr (std::same_as<Rep, Hybrid>)
    return hybrid_partial(path, a, alpha);
  else  // angular part as body-fixed, linear part as hybrid
    return {body_fixed_partial(path, a, alpha).w, hybrid_partial(path, a, alpha).v};
}

/// Directional derivatives along several directions at once. For a set S of directions X^S means D_S X, the
/// derivative along all of them, the lowest index innermost. With W_i(u) = Σ J_c u_c over the path to body i,
///   D_S J_c = Σ_{A ⊆ S∖s} [W_i(u_s)^A, J_c^{S∖s∖A}],  s the lowest index in S,
/// by the product rule on D_u J_c = [W_i(u), J_c]; r and Rᵀ of the place follow in the same way.
template <class T> class DirectionalDerivatives {
 public:
  DirectionalDerivatives(const ScrewPath<T>& path, int order, const T* directions, int nv)
      : path_(path),
        sets_(1U << order),
        order_(order),
        J_(path.screws.size() * sets_),
        W_(order * sets_),
        r_(sets_),
        Rt_(sets_) {
    const int n = static_cast<int>(path.screws.size());
    for (int begin = 0, end = 0; begin < n; begin = end) {
      while (end < n && path.screws[end].joint == path.screws[begin].joint) ++end;
      body(begin, end, directions, nv);
    }
    pose();
  }

  /// D_S of column c for all directions, in a representation at the place.
  template <class Rep> Screw<T> of(int c) const {
    const unsigned S = sets_ - 1;
    if constexpr (std::same_as<Rep, Spatial>) return J(c, S);
    const Screw<T> X{J(c, S).w, linear(c, S)};
    if constexpr (std::same_as<Rep, Hybrid>) return X;
    Screw<T> Y;
    each_subset(S, [&](unsigned A) {
      Y.w += Rt_[A] * J(c, S & ~A).w;
      Y.v += Rt_[A] * linear(c, S & ~A);
    });
    return std::same_as<Rep, Mixed> ? Screw<T>{Y.w, X.v} : Y;
  }

 private:
  const Screw<T>& J(int c, unsigned S) const { return J_[c * sets_ + S]; }
  static int lowest(unsigned S) { return S & 1U ? 0 : 1 + lowest(S >> 1); }
  template <class F> static void each_subset(unsigned S, F&& f) {
    for (unsigned A = S;; A = (A - 1) & S) {
      f(A);
      if (A == 0) break;
    }
  }
  Vec3<T> linear(int c, unsigned S) const {
    Vec3<T> v = J(c, S).v;
    each_subset(S, [&](unsigned A) { v += cross(J(c, A).w, r_[S & ~A]); });
    return v;
  }

  /// The screws begin..end - 1 of one joint; W_ is that of its predecessor before and of its body after.
  void body(int begin, int end, const T* directions, int nv) {
    for (int c = begin; c < end; ++c) J_[c * sets_] = path_.screws[c].spatial;
    for (unsigned S = 0; S < sets_; ++S) {
      if (S > 0) {
        const int s = lowest(S);
        const unsigned rest = S & (S - 1);
        for (int c = begin; c < end; ++c) {
          Screw<T> sum;
          each_subset(rest, [&](unsigned A) { sum = sum + ad(W_[s * sets_ + A], J(c, rest & ~A)); });
          J_[c * sets_ + S] = sum;
        }
      }
      for (int s = 0; s < order_; ++s)
        for (int c = begin; c < end; ++c)
          W_[s * sets_ + S] = W_[s * sets_ + S] + directions[s * nv + path_.screws[c].c] * J(c, S);
    }
  }
  /// r and Rᵀ of the place: D_u r = v + w × r and D_u Rᵀ = -Rᵀ w̃ with (w; v) = W(u).
  void pose() {
    r_[0] = path_.C.r, Rt_[0] = transpose(path_.C.R);
    for (unsigned S = 1; S < sets_; ++S) {
      const int s = lowest(S);
      const unsigned rest = S & (S - 1);
      Vec3<T> r = W_[s * sets_ + rest].v;
      SO3<T> Rt{{}, {}, {}};
      each_subset(rest, [&](unsigned A) {
        const Vec3<T>& w = W_[s * sets_ + A].w;
        r += cross(w, r_[rest & ~A]);
        const SO3<T>& Q = Rt_[rest & ~A];  // -Q w̃ e = Q (e × w)
        const Vec3<T> x{T(0), -w.z, w.y}, y{w.z, T(0), -w.x}, z{-w.y, w.x, T(0)};
        Rt = {Rt.x + Q * x, Rt.y + Q * y, Rt.z + Q * z};
      });
      r_[S] = r, Rt_[S] = Rt;
    }
  }

  const ScrewPath<T>& path_;
  unsigned sets_;
  int order_;
  std::vector<Screw<T>> J_, W_;
  std::vector<Vec3<T>> r_;
  std::vector<SO3<T>> Rt_;
};

}  // namespace axode
