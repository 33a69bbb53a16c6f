#pragma once
#include <algorithm>

#include "axode/derivatives/displacement/displacement.hpp"
#include "axode/derivatives/displacement/number_rows.hpp"
#include "axode/fast/poses.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// The inertia M, the Coriolis inertia B and the wrench F of a body, or their sums over bodies. F is the
/// wrench that the joints of a body must exert on it for its motion under gravity and applied wrenches. For a
/// twist X = (w; v), B X is the wrench that gives mass elements with velocities r' the Coriolis acceleration
/// 2 w × r'. If the bodies are displaced, the change of F follows from M, B and F (D1.11). All are in
/// inertial axes about the present origin of the root body, which is the body of the branch that is joined to
/// the ground.
template <class T> struct MovingInertia {
  Inertia<T> M;
  CoriolisInertia<T> B;
  Wrench<Spatial, T> F;  ///< M V' + B V / 2 minus the applied wrenches

  static constexpr int size = 28;  ///< number of numbers
  /// Offsets of the moment and the force of F among the numbers.
  static constexpr int moment = 22, force = 25;

  /// Reads all members from an array x of numbers.
  template <class Numbers> static constexpr MovingInertia from(const Numbers& x) {
    const auto vector = [&](int k) { return Vec3<T>{x[k], x[k + 1], x[k + 2]}; };
    return {{x[0], vector(1), {x[4], x[5], x[6], x[7], x[8], x[9]}},
            {{vector(10), vector(13), vector(16)}, vector(19)},
            {vector(moment), vector(force)}};
  }
  /// Writes all members to an array x of numbers.
  template <class Numbers> constexpr void to(Numbers& x) const {
    const auto set = [&](const Vec3<T>& a, int k) {
      x[k] = a.x;
      x[k + 1] = a.y;
      x[k + 2] = a.z;
    };
    x[0] = M.m;
    set(M.h, 1);
    x[4] = M.Theta.xx;
    x[5] = M.Theta.yy;
    x[6] = M.Theta.zz;
    x[7] = M.Theta.xy;
    x[8] = M.Theta.xz;
    x[9] = M.Theta.yz;
    set(B.D.x, 10);
    set(B.D.y, 13);
    set(B.D.z, 16);
    set(B.p, 19);
    set(F.m, moment);
    set(F.f, force);
  }

  [[gnu::always_inline]] static constexpr MovingInertia of(const Inertia<T>& M, const Motion6<T>& V,
                                                           const Motion6<T>& dV) {
    const auto B = CoriolisInertia<T>::of(M, V);
    const Momentum<Spatial, T> Pi = M * dV;
    return {M, B, {Pi.l + B.D * V.w, Pi.p + cross(V.w, B.p)}};
  }
};

/// The screws and wrenches that belong to one joint screw S. The derivatives of the joint forces τ are sums
/// of powers of a wrench that belongs to one joint screw on a screw that belongs to another ((D1.16) and
/// (D1.17) of docs/derivations). The screws are S, its first two time derivatives ψ' and ψ'' as a screw that
/// is fixed to the predecessor, and σ. The wrenches are U, P, R and Bᵀ S, which consists of a moment t alone:
///   σ = ψ' + [V, S],   U = M S,   P = M ψ'' + B ψ' - ad_Sᵀ F,   R = M σ + B S.
/// V is the twist of the body that the joint moves. M, B and F belong to the subtree of this body: M is the
/// inertia, and F the wrench that the joint transmits. B is the Coriolis inertia: for a twist X = (w; v), B X
/// is the wrench that gives mass elements with velocities r' the Coriolis acceleration 2 w × r'.
template <class T> struct ScrewEffects {
  Motion6<T> S, psi_2, sigma;
  Wrench<Spatial, T> U, P, R;
  Vec3<T> psi_1, t;  ///< psi_1: angular part of ψ'

  static constexpr int size = 42;  ///< number of numbers

  /// Computes for a joint screw S the quantities
  ///   ψ' = [V_p, S],   ψ'' = [V'_p, S] + [V_p, ψ'],   σ = ψ' + [V, S],
  ///   U = M S,   P = M ψ'' + B ψ' - ad_Sᵀ F,   R = M σ + B S,   and t, the moment of Bᵀ S.
  /// `moved` has three quantities of the subtree: the inertia M, the wrench F that the joint transmits, and
  /// the Coriolis inertia B. For a twist X = (w; v), B X is the wrench that gives mass elements with
  /// velocities r' the Coriolis acceleration 2 w × r'. V_p and dV_p are the twist of the predecessor and its
  /// rate, and V is the twist of the body. If there are loads, the caller must add N S to P, where N is the
  /// load stiffness of the subtree: N X is the change, by a displacement X of the subtree, of the wrench that
  /// balances its loads, as seen in a frame that is displaced with it.
  [[gnu::always_inline]] static constexpr ScrewEffects of(const MovingInertia<T>& moved, const Motion6<T>& S,
                                                          const Motion6<T>& V_p, const Motion6<T>& dV_p,
                                                          const Motion6<T>& V) {
    const CarriedScrew<T> psi(V_p, dV_p, S);
    const Motion6<T> sigma = psi.first + ad(V, S);
    const auto M = [&](const Motion6<T>& X) {
      const Momentum<Spatial, T> Pi = moved.M * X;
      return Wrench<Spatial, T>{Pi.l, Pi.p};
    };
    return {S,
            psi.second,
            sigma,
            M(S),
            M(psi.second) + moved.B * psi.first + coad(S, moved.F),
            M(sigma) + moved.B * S,
            psi.first.w,
            moved.B.transposed_times(S)};
  }
};

/// Stores the six-vectors (a; b), one in each SIMD lane, in arrays with one array for each component: the
/// vector in lane l becomes components k to k + 5 of entry i + l.
template <class Number, class T>
void store6(const Vec3<Number>& a, const Vec3<Number>& b, const Arrays<T>& to, int k, int i) {
  to.store3(a, k, i);
  to.store3(b, k + 3, i);
}
/// Loads the six-vectors of the entries i, i + 1, ..., one in each SIMD lane.
template <class T> Motion6<typename Lanes<T>::Number> load6(const Arrays<T>& x, int i) {
  return {x.load3(0, i), x.load3(3, i)};
}

/// A joint screw S, the twist V_p of the predecessor and its rate with gravity included, and the twist V of
/// the body that the joint moves.
template <class T> struct MovingColumn { Motion6<T> S, V_p, dV_p, V; };

/// The joint screws of a moving tree, and the quantities of its bodies from which the derivatives of the
/// joint forces are computed: the poses, the twists and their rates, and the inertia, the Coriolis inertia
/// and the wrench (MovingInertia) of each body or, after compose(), of its subtree. All are in inertial axes
/// about the present origin of the root body, which is the body of the branch that is joined to the ground. A
/// column is one joint screw; columns of a subtree are adjacent. The screw of a coupled joint is for a unit
/// velocity of its leader, the joint that it follows.
template <class T> struct MovingScrews {
  using L = Lanes<T>;
  using Number = typename L::Number;
  using G = typename FastGeometry<T>::type;
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  struct SpatialMotion {
    Vector w, v, dw, dv;
  };
  /// Offsets of the vectors in a row of `bodies`, the array with one row for each body: the columns of its
  /// rotation R, its position r, its twist (w; v), and the rate of its twist with gravity included.
  struct OfBody {
    static constexpr int R_x = 0, R_y = 4, R_z = 8, r = 12, w = 16, v = 20, dw = 24, dv = 28;
  };
  /// Offsets of the six-vectors in a row of `columns`, the array with one row for each joint screw: the screw
  /// S, the twist V_p of the joint's predecessor, the rate dV_p of this twist with gravity included, and the
  /// twist V of the body that the joint moves. The offset is that of the angular part; the linear part begins
  /// four numbers later.
  struct OfColumn {
    static constexpr int S = 0, V_p = 8, dV_p = 16, V = 24;
  };

  FastPoses<T> poses;
  NumberRows<T, 32> bodies, columns;
  SpatialMotion* branch;  ///< motions of bodies with more than one successor
  NumberRows<T, MovingInertia<T>::size>
      moved;     ///< MovingInertia of each body; after compose() that of its subtree
  int* body_of;  ///< for each column: the body that its joint moves

  explicit MovingScrews(Arena& arena)
      : poses(arena),
        bodies(arena, arena.topology().n + 1),
        columns(arena, arena.topology().n_screws),
        branch(arena.per_body<SpatialMotion>()),
        moved(arena, arena.topology().n + 1),
        body_of(arena.per_screw<int>()) {}

  /// Computes the motion and the MovingInertia of each body, and the joint screws.
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const Vec3<T>& g) noexcept {
    SpatialMotion last{Vector{}, Vector{}, Vector{}, Vector(-g)};
    branch[0] = last;
    poses.template run<FastPoses<T>::From::root>(tree, q, [&](int i, const auto& at) {
      const int p = tree->parent[i], s = tree->first_screw[i];
      if (p != i - 1) last = branch[p];
      if (is_hinge(tree, i)) [[likely]] {
        const int c = tree->iv[i];
        body_of[s] = i;
        last = moved_by(s, at.R.z, cross(Factor(at.r), Factor(at.R.z)), last, last, v[c], a[c]);
        set_twist(s, last);
      } else {
        last = moved_by_joint(tree, i, axode::pose<T>(at), v, a, last);
      }
      bodies.set3(at.R.x, i, OfBody::R_x);
      bodies.set3(at.R.y, i, OfBody::R_y);
      bodies.set3(at.R.z, i, OfBody::R_z);
      bodies.set3(at.r, i, OfBody::r);
      bodies.set3(last.w, i, OfBody::w);
      bodies.set3(last.v, i, OfBody::v);
      bodies.set3(last.dw, i, OfBody::dw);
      bodies.set3(last.dv, i, OfBody::dv);
      if (tree->branches[i]) branch[i] = last;
    });
    for (int i = 1; i <= tree->n; i += L::width) {
      typename NumberRows<T, 32>::Components x;
      bodies.load([i](int l) { return i + l; }, x);
      const auto vector = [&](int k) { return bodies.vector(x, k); };
      const SE3<Number> at{{vector(OfBody::R_x), vector(OfBody::R_y), vector(OfBody::R_z)},
                           vector(OfBody::r)};
      const Inertia<Number> M = transform(at, inertias_in_lanes<T>(tree, i));
      typename decltype(moved)::Components numbers;
      MovingInertia<Number>::of(M, {vector(OfBody::w), vector(OfBody::v)},
                                {vector(OfBody::dw), vector(OfBody::dv)})
          .to(numbers);
      moved.store(numbers, i);
    }
  }

  /// Applies an external wrench W (in inertial axes about O) on body i, before compose().
  void load(int i, const Wrench<Spatial, T>& W) const noexcept {
    moved.set3(moved.get3(i, MovingInertia<T>::moment) - W.m, i, MovingInertia<T>::moment);
    moved.set3(moved.get3(i, MovingInertia<T>::force) - W.f, i, MovingInertia<T>::force);
  }

  /// Replaces the inertia, the Coriolis inertia B and the wrench of each body by their sums over the subtree
  /// of the body. All are in the same axes about the same point. For a twist X = (w; v), B X is the wrench
  /// that gives mass elements with velocities r' the Coriolis acceleration 2 w × r'.
  void compose(const Topology& topology) noexcept { moved.sum_subtrees(topology); }
  /// The wrench that the joint of body i transmits to the body, after compose().
  Wrench<Spatial, T> transmitted(int i) const {
    return {moved.get3(i, MovingInertia<T>::moment), moved.get3(i, MovingInertia<T>::force)};
  }

  /// The joint screws c, c + 1, ... and the motions that belong to them, one in each SIMD lane.
  [[gnu::always_inline]] MovingColumn<Number> columns_from(int c) const {
    typename NumberRows<T, 32>::Components x;
    columns.load([c](int l) { return c + l; }, x);
    const auto six_of = [&](int k) {
      return Motion6<Number>{columns.vector(x, k), columns.vector(x, k + 4)};
    };
    return {six_of(OfColumn::S), six_of(OfColumn::V_p), six_of(OfColumn::dV_p), six_of(OfColumn::V)};
  }
  /// The rates of the twists of the bodies that the joint screws c, c + 1, ... move, one in each SIMD
  /// lane. Lanes beyond the last of all `n_columns` joint screws repeat the last one.
  Motion6<Number> twist_rates_of_columns(int c, int n_columns) const {
    typename NumberRows<T, 32>::Components x;
    bodies.load([&](int l) { return body_of[std::min(c + l, n_columns - 1)]; }, x);
    return {bodies.vector(x, OfBody::dw), bodies.vector(x, OfBody::dv)};
  }
  /// The inertia M, the Coriolis inertia B and the wrench F of the bodies i, i + 1, ..., one body in each
  /// SIMD lane. F is the wrench that the body needs for its motion under gravity, minus the applied wrenches.
  /// For a twist X = (w; v), B X is the wrench that gives mass elements with velocities r' the Coriolis
  /// acceleration 2 w × r'. The function must be called before compose(), which replaces these quantities by
  /// sums over subtrees.
  MovingInertia<Number> bodies_from(int i) const {
    return in_lanes([i](int l) { return i + l; });
  }
  /// The inertia M, the Coriolis inertia B and the wrench F of the subtrees that the joint screws c, c + 1,
  /// ... move, one subtree in each SIMD lane. F is the wrench that the joint transmits to the subtree for its
  /// motion under gravity and applied wrenches. For a twist X = (w; v), B X is the wrench that gives mass
  /// elements with velocities r' the Coriolis acceleration 2 w × r'. compose() must have summed the three
  /// quantities over the subtrees before. Lanes beyond the last of all `n_columns` joint screws repeat the
  /// last one.
  [[gnu::always_inline]] MovingInertia<Number> subtrees_of_columns(int c, int n_columns) const {
    return in_lanes([&](int l) { return body_of[std::min(c + l, n_columns - 1)]; });
  }
  MovingInertia<T> subtree_of_column(int c) const { return MovingInertia<T>::from(moved.row(body_of[c])); }
  /// The pose of body i in inertial axes, relative to the origin of the root body, which is the first body on
  /// the path from the ground to body i.
  SE3<T> pose(int i) const {
    return {{bodies.get3(i, OfBody::R_x), bodies.get3(i, OfBody::R_y), bodies.get3(i, OfBody::R_z)},
            bodies.get3(i, OfBody::r)};
  }
  /// A six-vector of column c.
  Motion6<T> six(int c, int k) const { return {columns.get3(c, k), columns.get3(c, k + 4)}; }
  Motion6<T> screw(int c) const { return six(c, OfColumn::S); }

 private:
  /// Adds the motion along one joint screw S = (e; s), with the velocity dq and the acceleration ddq, to the
  /// motion `before`, which has the twist V_b and its rate V'_b. Returns the twist V_b + S dq and its rate
  /// V'_b + S ddq + [V_p, S] dq, where V_p is the twist of the predecessor, whose motion is `p`. For the
  /// first screw of a joint, `before` is `p`; for a later one it also contains the motions along the earlier
  /// screws. Stores S, V_p and the rate of V_p in row c of `columns`.
  [[gnu::always_inline]] SpatialMotion moved_by(int c, const Vector& e, const Vector& s,
                                                const SpatialMotion& p, const SpatialMotion& before,
                                                const T& dq, const T& ddq) const noexcept {
    columns.set3(e, c, OfColumn::S);
    columns.set3(s, c, OfColumn::S + 4);
    columns.set3(p.w, c, OfColumn::V_p);
    columns.set3(p.v, c, OfColumn::V_p + 4);
    columns.set3(p.dw, c, OfColumn::dV_p);
    columns.set3(p.dv, c, OfColumn::dV_p + 4);
    const Factor e_(e), w_p(p.w);
    const Vector turned = cross(w_p, e_), moved_on = cross(Factor(p.v), e_) + cross(w_p, Factor(s));
    return {before.w + dq * e, before.v + dq * s, before.dw + (ddq * e + dq * turned),
            before.dv + (ddq * s + dq * moved_on)};
  }
  void set_twist(int c, const SpatialMotion& of_body) const noexcept {
    columns.set3(of_body.w, c, OfColumn::V);
    columns.set3(of_body.v, c, OfColumn::V + 4);
  }
  template <class Real>
  [[gnu::noinline]] SpatialMotion moved_by_joint(const Tree<Real>& tree, int i, const SE3<T>& C_i, const T* v,
                                                 const T* a, const SpatialMotion& p) const noexcept {
    const int first = tree->first_screw[i], c = tree->iv[i];
    const T ratio(tree.ratio[i]);
    SpatialMotion next = p;
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = joint.column(C_i, k);
        body_of[first + k] = i;
        next = moved_by(first + k, Vector(ratio * X.w), Vector(ratio * X.v), p, next, v[c + k], a[c + k]);
      }
      for (int k = 0; k < joint.nv; ++k) set_twist(first + k, next);
    });
    return next;
  }
  template <class Row> [[gnu::always_inline]] MovingInertia<Number> in_lanes(const Row& row) const {
    typename decltype(moved)::Components x;
    moved.load(row, x);
    return MovingInertia<Number>::from(x);
  }
};

}  // namespace axode
