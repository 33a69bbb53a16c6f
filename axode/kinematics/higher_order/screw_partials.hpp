#pragma once
#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "axode/kinematics/path.hpp"

/// Closed forms of the partial derivatives of the joint screws on the path from the ground to a place, which
/// is a frame on a body.
namespace axode {

/// A joint screw on the path from the ground to a place (a frame on a body): the index of its joint, the
/// index c of its velocity, and the screw in body-fixed, spatial and hybrid representation at the place.
template <class T> struct PathScrew {
  int joint;
  int c;
  Screw<T> body_fixed;  ///< body-fixed screw J_{f,c}^b
  Screw<T> spatial;     ///< spatial screw J_c^s
  Screw<T> hybrid;      ///< hybrid screw J_{f,c}^h; its linear part is ∂r/∂q_c of the position r
};

/// The joint screws on the path from the ground to a place (a frame on a body), from the ground outwards, and
/// the pose of the place.
template <class T> struct ScrewPath {
  std::vector<PathScrew<T>> screws;
  SE3<T> C;  ///< pose of the frame to which the path leads

  ScrewPath(const Tree<T>& tree, const T* q, const Place<T>& place) {
    C = each_body_fixed_column(tree, q, place, [&](int i, int c, const Screw<T>& X) {
      screws.push_back({i, c, X, {}, {}});
    });
    std::stable_sort(screws.begin(), screws.end(),
                     [](const auto& a, const auto& b) { return a.joint < b.joint; });
    for (PathScrew<T>& screw : screws) {
      screw.spatial = Ad(C, screw.body_fixed);
      screw.hybrid = Ad(C.R, screw.body_fixed);
    }
  }
};

/// The partial derivatives, of any order ν, of the joint screws on the path from the ground to a place (a
/// frame on a body) with respect to the joint coordinates, along left-trivialised directions. They are nested
/// brackets of joint screws in the body-fixed and the spatial representation (Müller, eqs. nthorderBody and
/// nthorder), and nested vector products in the hybrid and the mixed one ((D15.1) to (D15.4) of
/// docs/derivations). A multi-index α has ν indices into path.screws; the derivative along α[0] is taken
/// first. The constructor allocates, the other functions do not.
template <class Rep, class T> class ScrewPartials {
 public:
  ScrewPartials(const ScrewPath<T>& path, int order)
      : screws_(path.screws),
        alpha_(static_cast<std::size_t>(order)),
        chain_(static_cast<std::size_t>(order)),
        tails_(static_cast<std::size_t>(order)) {}

  /// Calls f(alpha, a, X) for every joint screw a of the path and every multi-index alpha, a list of `order`
  /// indices of joint screws in any order, with repetitions. X is the partial derivative of screw a along the
  /// joint velocities of the screws in alpha, along that of alpha[0] first. The order matters only for
  /// velocities of the same joint, whose left-trivialised directions need not commute. Ends early if
  /// should_continue() returns false.
  template <class F> void each(const std::function<bool()>& should_continue, const F& f) {
    std::fill(alpha_.begin(), alpha_.end(), 0);
    for (bool more = true; more;) {
      if (alpha_.size() > 2 && alpha_[0] == 0 && alpha_[1] == 0 && should_continue && !should_continue())
        return;
      along([&](int a, const Screw<T>& X) { f(alpha_, a, X); });
      more = false;
      for (std::size_t k = 0; k < alpha_.size() && !more; ++k) {
        more = ++alpha_[k] < count();
        if (!more) alpha_[k] = 0;
      }
    }
  }

 private:
  int count() const { return static_cast<int>(screws_.size()); }
  int joint(int a) const { return screws_[static_cast<std::size_t>(a)].joint; }
  const PathScrew<T>& screw(int a) const { return screws_[static_cast<std::size_t>(a)]; }

  /// Calls f(a, X) with the derivative X of every joint screw a along the screws in the multi-index alpha_.
  template <class F> void along(const F& f) {
    sort();
    if constexpr (std::same_as<Rep, BodyFixed>) {
      for (int a = 0; a < count(); ++a) f(a, body_fixed(a));
    } else if constexpr (std::same_as<Rep, Spatial>) {
      for (int a = 0; a < count(); ++a) f(a, spatial(a));
    } else {
      put_tails();
      std::size_t inward = 0;  // number of directions whose joints do not lie outward of the joint of a
      for (int a = 0; a < count(); ++a) {
        while (inward < chain_.size() && joint(chain_[inward]) <= joint(a)) ++inward;
        const Vec3<T> w = std::same_as<Rep, Hybrid> ? spatial_rotation(a) : body_fixed_rotation(a);
        f(a, Screw<T>{w, linear(a, inward)});
      }
    }
  }
  /// Sorts the directions alpha_, which are indices of joint screws, into chain_: from the ground outwards,
  /// and directions of the same joint in the reverse order of alpha_.
  void sort() {
    std::size_t n = 0;
    for (std::size_t k = alpha_.size(); k-- > 0; ++n) {
      std::size_t at = n;
      for (; at > 0 && joint(chain_[at - 1]) > joint(alpha_[k]); --at) chain_[at] = chain_[at - 1];
      chain_[at] = alpha_[k];
    }
  }
  bool all_outward_of(int a) const { return chain_.empty() || joint(chain_.front()) > joint(a); }
  bool moves_screw(int a) const {
    return chain_.empty() || (joint(chain_.back()) <= joint(a) && chain_.back() != a);
  }

  Screw<T> body_fixed(int a) const {
    if (!all_outward_of(a)) return {};
    Screw<T> X = screw(a).body_fixed;
    for (const int k : chain_) X = ad(X, screw(k).body_fixed);
    return X;
  }
  Screw<T> spatial(int a) const {
    if (!moves_screw(a)) return {};
    Screw<T> X = screw(a).spatial;
    for (std::size_t k = chain_.size(); k-- > 0;) X = ad(screw(chain_[k]).spatial, X);
    return X;
  }
  /// The angular part of the derivative body_fixed(a).
  Vec3<T> body_fixed_rotation(int a) const {
    if (!all_outward_of(a)) return {};
    Vec3<T> w = screw(a).body_fixed.w;
    for (const int k : chain_) w = cross(w, screw(k).body_fixed.w);
    return w;
  }
  /// The angular part of the derivative spatial(a).
  Vec3<T> spatial_rotation(int a) const {
    if (!moves_screw(a)) return {};
    return rotated(chain_.size(), screw(a).hybrid.w);
  }
  /// The vector w_β1 × (w_β2 × ... (w_βn × x)) with the first n directions β of the chain.
  Vec3<T> rotated(std::size_t n, Vec3<T> x) const {
    while (n-- > 0) x = cross(screw(chain_[n]).hybrid.w, x);
    return x;
  }
  /// Computes, for each k, one mixed derivative of the position of the place (a frame on a body, to which the
  /// path of joint screws leads): that along the velocities of all joint screws chain_[k], chain_[k + 1], ...
  /// to the last one of chain_. chain_ lists the screws along which derivatives are taken, from the ground
  /// outwards.
  void put_tails() {
    for (std::size_t k = chain_.size(); k-- > 0;) {
      const Screw<T>& J = screw(chain_[k]).hybrid;
      tails_[k] = k + 1 == chain_.size() ? J.v : cross(J.w, tails_[k + 1]);
    }
  }
  /// The linear part of the partial derivative of the hybrid screw a along the n directions in chain_, which
  /// are joint screws of the path to a place (a frame on a body). It is the mixed derivative, of order n + 1,
  /// of the position of the place: once along screw a, and then once along each of these directions (D15.4).
  /// `inward` is the number of directions that belong to the joint of screw a or to joints between it and the
  /// ground.
  Vec3<T> linear(int a, std::size_t inward) const {
    const Screw<T>& J = screw(a).hybrid;
    return rotated(inward, inward == chain_.size() ? J.v : cross(J.w, tails_[inward]));
  }

  const std::vector<PathScrew<T>>& screws_;
  std::vector<int> alpha_;      ///< indices of screws; alpha_[0] acts first
  std::vector<int> chain_;      ///< alpha_ sorted from the ground outwards, see sort()
  std::vector<Vec3<T>> tails_;  ///< derivative of the position along chain_[k], chain_[k + 1], ...
};

/// Derivatives of the joint screws J_c on the path to a place (a frame on a body) with respect to q, along
/// several directions u_s one after the other. D_S X is the derivative of X along all directions u_s with s
/// in the set S. The derivative along one direction u is D_u J_c = [W_i(u), J_c], where i is the body that
/// J_c moves, and W_i(u) is its twist for the joint velocities u. The product rule gives
///
///   D_S J_c = Σ_{A ⊆ S∖s} [D_A W_i(u_s), D_{S∖s∖A} J_c],  s the lowest index in S.
///
/// Consecutive directions that are equal form a run. D_S depends only on how many directions of each run are
/// in S. Such a list of numbers, one for each run, is called a part. Hence the sum over sets A becomes a sum
/// over parts, weighted with the number of sets that a part represents, a product of binomial coefficients.
template <class T> class DirectionalDerivatives {
 public:
  /// Computes the derivatives of all screws. `directions` has `order` rows of nv joint velocities, of which
  /// the first acts first. Throws std::invalid_argument if no memory can hold the derivatives.
  /// should_continue(), which may be empty, is called between sums, at the latest after 100,000 products of
  /// screws or one longer sum. If it returns false, the computation ends and stopped() is true from then on.
  DirectionalDerivatives(const ScrewPath<T>& path, int order, const T* directions, int nv,
                         const std::function<bool()>& should_continue)
      : path_(path), should_continue_(should_continue) {
    for (int s = 0; s < order; ++s) {
      const T* const u = directions + static_cast<std::ptrdiff_t>(s) * nv;
      bool repeated = false;
      if constexpr (std::is_floating_point_v<T>) repeated = s > 0 && std::equal(u, u + nv, u - nv);
      if (repeated)
        ++runs_.back().length;
      else
        runs_.push_back({u, 1, 0});
    }
    const std::size_t n = path.screws.size(),
                      most = std::vector<Screw<T>>().max_size() / (n + runs_.size() + 1);
    for (Run& run : runs_) {
      run.stride = parts_;
      if (parts_ > most / (run.length + 1))
        throw std::invalid_argument("the derivative along " + std::to_string(order) + " directions, " +
                                    std::to_string(runs_.size()) +
                                    " of them unlike the one before, does not fit into memory");
      parts_ *= run.length + 1;
    }
    J_.resize(n * parts_);
    W_.resize(runs_.size() * parts_);
    r_.resize(parts_);
    Rt_.resize(parts_);
    for (std::size_t begin = 0, end = 0; begin < n; begin = end) {
      while (end < n && path.screws[end].joint == path.screws[begin].joint) ++end;
      body(begin, end);
    }
    pose();
  }

  /// Whether the caller's function has ended the computation; results are then meaningless.
  bool stopped() const { return stopped_; }

  /// The derivative D_uν ... D_u1 of joint screw c of the path, once along each of the ν directions u (joint
  /// velocities) that the constructor received. The components of the screw are those in the representation
  /// Rep at the frame on a body to which the path leads.
  template <class Rep> Screw<T> of(int c) {
    const std::size_t S = parts_ - 1, a = static_cast<std::size_t>(c);
    if constexpr (std::same_as<Rep, Spatial>) return J(a, S);
    const Screw<T> X{J(a, S).w, linear(a, S)};
    if constexpr (std::same_as<Rep, Hybrid>) return X;
    Screw<T> Y;
    each_part(S, [&](std::size_t A, const T& weight) {
      if (stops_at(S - A)) return;
      Y.w += weight * (Rt_[A] * J(a, S - A).w);
      Y.v += weight * (Rt_[A] * linear(a, S - A));
    });
    return std::same_as<Rep, Mixed> ? Screw<T>{Y.w, X.v} : Y;
  }

 private:
  /// A run: `length` equal consecutive directions u (nv numbers) of the list of given directions. A selection
  /// of directions from this list matters only by its number of directions from each run. It is called a
  /// part, and these numbers are coded as one index S: the number from this run is S / stride % (length + 1).
  struct Run {
    const T* u;
    std::size_t length, stride;
  };

  /// Whether the computation ends before the products for a part S, of which there are at most S + 1.
  bool stops_at(std::size_t S) {
    constexpr std::size_t often = 100'000;
    products_ += S + 1;
    if (stopped_ || products_ < often) return stopped_;
    products_ = 0;
    stopped_ = should_continue_ && !should_continue_();
    return stopped_;
  }
  const Screw<T>& J(std::size_t c, std::size_t S) const { return J_[c * parts_ + S]; }
  std::size_t count(std::size_t run, std::size_t S) const {
    return S / runs_[run].stride % (runs_[run].length + 1);
  }
  /// The first run from which the part S (a selection of directions) has a direction. S must not be empty.
  std::size_t lowest(std::size_t S) const {
    std::size_t s = 0;
    while (count(s, S) == 0) ++s;
    return s;
  }
  /// Calls f(A, weight) for all parts A of a part S. A part is a selection from the given directions,
  /// described by its number of directions from each run of equal consecutive directions. None of the numbers
  /// of A is more than the number of S for the same run. `weight` is the number of ways to choose the
  /// directions of A from those of S.
  template <class F> void each_part(std::size_t S, const F& f) const { each_part(S, runs_.size(), 0, 1, f); }
  template <class F>
  void each_part(std::size_t S, std::size_t runs, std::size_t A, double weight, const F& f) const {
    if (runs == 0) return f(A, T(weight));
    const std::size_t n = count(runs - 1, S);
    for (std::size_t k = 0; k <= n; ++k) {
      each_part(S, runs - 1, A + k * runs_[runs - 1].stride, weight, f);
      weight = weight * static_cast<double>(n - k) / static_cast<double>(k + 1);
    }
  }
  Vec3<T> linear(std::size_t c, std::size_t S) const {
    Vec3<T> v = J(c, S).v;
    each_part(S, [&](std::size_t A, const T& weight) { v += weight * cross(J(c, A).w, r_[S - A]); });
    return v;
  }

  /// Computes the derivatives of the joint screws begin to end - 1 of the path, which belong to one joint,
  /// along every part. A part stands for all selections of the given directions u_s that have the same number
  /// of directions from each run of equal consecutive directions. W_ has, for each run s and each part, the
  /// derivative along this part of W(u_s), the spatial twist of a body for the joint velocities u_s. Before
  /// the call this body is the predecessor of the joint's body, and after the call the joint's body.
  void body(std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) J_[c * parts_] = path_.screws[c].spatial;
    for (std::size_t S = 0; S < parts_; ++S) {
      if (S > 0) {
        const std::size_t s = lowest(S), rest = S - runs_[s].stride;
        for (std::size_t c = begin; c < end; ++c) {
          if (stops_at(rest)) return;
          Screw<T> sum;
          each_part(rest, [&](std::size_t A, const T& weight) {
            sum = sum + weight * ad(W_[s * parts_ + A], J(c, rest - A));
          });
          J_[c * parts_ + S] = sum;
        }
      }
      for (std::size_t s = 0; s < runs_.size(); ++s)
        for (std::size_t c = begin; c < end; ++c)
          W_[s * parts_ + S] = W_[s * parts_ + S] + runs_[s].u[path_.screws[c].c] * J(c, S);
    }
  }
  /// Differentiates the position r and the transposed rotation Rᵀ of the frame on a body to which the path
  /// leads: D_u r = v + w × r and D_u Rᵀ = -Rᵀ w̃. Here (w; v) = W(u) is the spatial twist of this body for
  /// the joint velocities u.
  void pose() {
    r_[0] = path_.C.r;
    Rt_[0] = transpose(path_.C.R);
    for (std::size_t S = 1; S < parts_; ++S) {
      const std::size_t s = lowest(S), rest = S - runs_[s].stride;
      if (stops_at(rest)) return;
      Vec3<T> r = W_[s * parts_ + rest].v;
      SO3<T> Rt{{}, {}, {}};
      each_part(rest, [&](std::size_t A, const T& weight) {
        const Vec3<T> w = weight * W_[s * parts_ + A].w;
        r += cross(w, r_[rest - A]);
        const SO3<T>& Q = Rt_[rest - A];  // -Q w̃ e = Q (e × w)
        const Vec3<T> x{T(0), -w.z, w.y}, y{w.z, T(0), -w.x}, z{-w.y, w.x, T(0)};
        Rt = {Rt.x + Q * x, Rt.y + Q * y, Rt.z + Q * z};
      });
      r_[S] = r;
      Rt_[S] = Rt;
    }
  }

  const ScrewPath<T>& path_;
  const std::function<bool()>& should_continue_;
  std::size_t products_ = 0;  ///< since should_continue_ was called, at least the number of products
  bool stopped_ = false;
  std::vector<Run> runs_;
  std::size_t parts_ = 1;  ///< number of parts: the product of length + 1 of all runs
  std::vector<Screw<T>> J_, W_;
  std::vector<Vec3<T>> r_;
  std::vector<SO3<T>> Rt_;
};

}  // namespace axode
