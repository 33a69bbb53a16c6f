#pragma once
#include <algorithm>

#include "axode/fast/packed_store.hpp"

namespace axode {

/// The Jacobians of places (frames on bodies) at one configuration, from poses of the bodies and screws of
/// the joints that are computed once. For each place with position r_f, only the columns of the joints on its
/// path to the ground are computed. With a joint screw (ω; v) in inertial axes about the origin r of the body
/// that the joint moves, a column in hybrid representation is
///   J_c^h = (ω; v + ω × (r_f - r)).
/// It takes 15 products and sums, and 30 more in body-fixed representation. Except in spatial representation,
/// positions are relative to the root body (the first body on the path from the ground), so that no digits
/// are lost far from the inertial origin.
template <class T, class G = typename FastGeometry<T>::type> struct FastJacobians {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  /// A joint screw for a unit velocity, about the origin r of the body of the joint.
  struct Column {
    Vector w, v, r;
    Factor w_;
  };
  FastPoses<T, G> poses;
  Placed<G>* body;
  Column* column;

  explicit FastJacobians(Arena& arena)
      : poses(arena), body(arena.per_body<Placed<G>>()), column(arena.per_screw<Column>()) {}

  /// Computes the poses of the bodies and the screws of the joints at q.
  template <class Rep> void run(const Tree<T>& tree, const T* q) noexcept {
    using From = typename FastPoses<T, G>::From;
    body[0] = {Matrix(SO3<T>{}), Vector{}};
    const auto keep = [&](int i, const Placed<G>& at) {
      body[i] = at;
      Column* const column_i = column + tree->first_screw[i];
      if (is_hinge(tree, i)) [[likely]]
        *column_i = {at.R.z, Vector{}, at.r, Factor(at.R.z)};
      else
        set_columns(tree, i, column_i);
    };
    poses.template run<std::same_as<Rep, Spatial> ? From::inertial_frame : From::root>(tree, q, keep);
  }

  /// Writes the Jacobian J (nv columns) in representation Rep of a frame on body i. F is the pose of this
  /// frame relative to the internal frame of the body, which is the joint frame that moves with the body.
  template <class Rep>
  void write(const Tree<T>& tree, int i, const SE3<T>& F, Twist<Rep, T>* J) const noexcept {
    const ScrewInRep<Rep> in_rep(body[i], F);
    if (!tree->coupled_bodies.empty()) return add_up(tree, i, in_rep, J);
    const auto clear = [J](int from, int to) { std::fill(numbers<T>(J + from), numbers<T>(J + to), T(0)); };
    const int* const parent = tree->velocity_parent.data();
    int end = tree->nv;  // The columns from `end` on are written.
    for (int c = tree->first_screw[i + 1] - 1; c >= 0; end = c, c = parent[c]) {
      if (c + 1 < end) clear(c + 1, end);
      const auto [w, v] = in_rep(column[c]);
      store(w, v, numbers<T>(J + c));
    }
    if (end > 0) clear(0, end);
  }

 private:
  [[gnu::noinline]] void set_columns(const Tree<T>& tree, int i, Column* out) const noexcept {
    const Placed<G>& at = body[i];
    const SO3<T> R{at.R.x, at.R.y, at.R.z};
    with_joint(tree, i, [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = tree.ratio[i] * Ad(R, joint.column(k));
        const Vector w(X.w);
        out[k] = {w, Vector(X.v), at.r, Factor(w)};
      }
    });
  }
  /// Converts joint screws to columns of the Jacobian, in representation Rep, of one frame on a body.
  template <class Rep> struct ScrewInRep {
    Vector r{};
    Matrix Rt;

    ScrewInRep(const Placed<G>& at, const SE3<T>& F) {
      if constexpr (!std::same_as<Rep, Spatial>) r = at.r + at.R * Spread(F.r);
      if constexpr (std::same_as<Rep, BodyFixed> || std::same_as<Rep, Mixed>)
        Rt = transposed<G, T>(at.R, F.R);
    }
    std::pair<Vector, Vector> operator()(const Column& X) const {
      const Vector v = X.v + cross(X.w_, Factor(r - X.r));
      if constexpr (std::same_as<Rep, BodyFixed>)
        return {Rt * Spread(X.w), Rt * Spread(v)};
      else if constexpr (std::same_as<Rep, Mixed>)
        return {Rt * Spread(X.w), v};
      else
        return {X.w, v};
    }
  };
  /// Writes the Jacobian J of one frame on a body for a tree with coupled joints. A coupled joint has the
  /// velocity of another joint, its leader, times a constant ratio. The column of the leader's velocity is
  /// the sum of the screw of the leader and of the screws of the joints coupled to it, each times its ratio.
  /// Only joints on the path from the body to the ground contribute.
  template <class Rep>
  [[gnu::noinline]] void add_up(const Tree<T>& tree, int i, const ScrewInRep<Rep>& in_rep,
                                Twist<Rep, T>* J) const noexcept {
    std::fill_n(J, tree->nv, Twist<Rep, T>{});
    for (; i > 0; i = tree->parent[i])
      for (int k = tree->first_screw[i], c = tree->iv[i]; k < tree->first_screw[i + 1]; ++k, ++c) {
        const auto [w, v] = in_rep(column[k]);
        J[c] += Twist<Rep, T>{w, v};
      }
  }
};

}  // namespace axode
