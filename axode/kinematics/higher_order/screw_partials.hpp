#pragma once
#include <algorithm>
#include <bit>
#include <functional>
#include <utility>
#include <vector>

#include "axode/kinematics/path.hpp"

/// Closed forms of the partial derivatives of the joint screws on the path to one place.
namespace axode {

/// A joint screw on the path to a place: its joint, the velocity that moves it, and its coordinates.
template <class T> struct PathScrew {
  int joint;
  int c;
  Screw<T> body_fixed;  ///< body-fixed screw J_{f,c}^b
  Screw<T> spatial;     ///< spatial screw J_c^s
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

/// The partial derivative of the body-fixed screw a along the screws alpha, alpha[0] first; all are indices
/// into path.screws.
///
/// It is [...[[J_a, J_β1], J_β2]..., J_βν] (eq. nthorderBody), where β is alpha sorted from the root
/// outwards, or 0 unless all of β lie outward of a. If several directions belong to one joint, the one that
/// acts last comes first in β.
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

/// The partial derivative of the spatial screw a along the screws alpha, alpha[0] first; all are indices into
/// path.screws. It is [J_βν, ...[J_β2, [J_β1, J_a]]...] (eq. nthorder), where β is alpha sorted from the tip
/// inwards, or 0 if one of β lies outward of a or β1 is a itself. If several directions belong to one joint,
/// the one that acts last is the outermost bracket.
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

/// The partial derivatives of all screws of a path by all multi-indices alpha of one order, computed from the
/// lower orders. With the spatial screw J^s = (w; v) and the position r of the place, the hybrid screw is J^h
/// = (w; v + w × r). By the product rule
///   ∂_α v^h = ∂_α v + Σ_{A ⊆ α} ∂_A w × ∂_{α∖A} r,    ∂_α r = ∂_{α2 ... αν} v^h of the screw α1.
/// A table keeps ∂_A w and ∂_A r of every lower order, so that each term of the sum is one cross product. It
/// has about 2/m of the numbers of the result for m screws; body-fixed and spatial derivatives need no table.
template <class Rep, class T> class ScrewPartials {
 public:
  ScrewPartials(const ScrewPath<T>& path, int order, const std::function<bool()>& go_on)
      : path_(path), go_on_(go_on) {
    if constexpr (std::same_as<Rep, Hybrid> || std::same_as<Rep, Mixed>) {
      r_.push_back({path.C.r});
      for (int k = 0; k < order; ++k) {
        std::vector<Vec3<T>> w, r;
        each_multi_index(k, [&](const std::vector<int>& alpha) {
          hybrid(alpha, [&](int, const Screw<T>& X) { w.push_back(X.w), r.push_back(X.v); });
        });
        w_.push_back(std::move(w));
        r_.push_back(std::move(r));
      }
    }
  }

  /// Calls f(alpha) for every multi-index of an order, alpha[0] changing first, while go_on() returns true.
  template <class F> void each_multi_index(int order, const F& f) const {
    std::vector<int> alpha(static_cast<std::size_t>(order), 0);
    for (bool more = true; more;) {
      if (alpha.size() > 2 && alpha[0] == 0 && alpha[1] == 0 && go_on_) stopped_ = stopped_ || !go_on_();
      if (stopped_) return;
      f(alpha);
      more = false;
      for (std::size_t k = 0; k < alpha.size() && !more; ++k) {
        more = ++alpha[k] < count();
        if (!more) alpha[k] = 0;
      }
    }
  }
  /// Calls f(a, X) with the derivative X of every screw a along alpha, alpha[0] first; its order is that of
  /// the constructor.
  template <class F> void along(const std::vector<int>& alpha, const F& f) const {
    if constexpr (std::same_as<Rep, BodyFixed>)
      for (int a = 0; a < count(); ++a) f(a, body_fixed_partial(path_, a, alpha));
    else if constexpr (std::same_as<Rep, Spatial>)
      for (int a = 0; a < count(); ++a) f(a, spatial_partial(path_, a, alpha));
    else if constexpr (std::same_as<Rep, Hybrid>)
      hybrid(alpha, f);
    else  // mixed: the angular part of the body-fixed and the linear part of the hybrid derivative
      hybrid(alpha, [&](int a, const Screw<T>& X) {
        f(a, Screw<T>{body_fixed_partial(path_, a, alpha).w, X.v});
      });
  }

 private:
  int count() const { return static_cast<int>(path_.screws.size()); }
  template <class F> void hybrid(const std::vector<int>& alpha, const F& f) const {
    const auto m = static_cast<std::size_t>(count());
    const unsigned all = (1U << alpha.size()) - 1;
    // `at` has the index in the table of ∂_A for the members A of alpha whose bits are set; alpha[0] is the
    // lowest digit of a number of base m.
    std::vector<std::size_t> at(all + 1, 0);
    for (unsigned A = 1; A <= all; ++A)
      at[A] = static_cast<std::size_t>(alpha[static_cast<std::size_t>(std::countr_zero(A))]) +
              m * at[A & (A - 1)];
    const auto size = [](unsigned A) { return static_cast<std::size_t>(std::popcount(A)); };
    for (int a = 0; a < count(); ++a) {
      Screw<T> X = spatial_partial(path_, a, alpha);
      for (unsigned A = 0; A < all; ++A) {
        const unsigned others = all & ~A;
        X.v += cross(w_[size(A)][at[A] * m + static_cast<std::size_t>(a)], r_[size(others)][at[others]]);
      }
      X.v += cross(X.w, path_.C.r);
      f(a, X);
    }
  }

  const ScrewPath<T>& path_;
  std::vector<std::vector<Vec3<T>>> w_;  ///< ∂_A w of screw a, by the order of A, at (number of A) m + a
  std::vector<std::vector<Vec3<T>>> r_;  ///< ∂_A r, by the order of A, at the number of A
  const std::function<bool()>& go_on_;
  mutable bool stopped_ = false;  ///< whether go_on_() has returned false; the table is then unfinished
};

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

  /// The derivative of column c along all directions, in the representation Rep at the place.
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

  /// Differentiates the screws begin to end - 1 of one joint. Before the call, W_ belongs to the predecessor
  /// of the joint; after it, to its body.
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
  /// Differentiates r and Rᵀ of the place: D_u r = v + w × r and D_u Rᵀ = -Rᵀ w̃ with (w; v) = W(u).
  void pose() {
    r_[0] = path_.C.r;
    Rt_[0] = transpose(path_.C.R);
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
      r_[S] = r;
      Rt_[S] = Rt;
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
