#pragma once
#include <algorithm>
#include <array>
#include <bit>

#include "axode/derivatives/displacement/displacement.hpp"
#include "axode/fast/poses.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// The inertia M, the Coriolis inertia B and the wrench F of a body, or their sums over bodies. The change of
/// F follows from them when the bodies are displaced (D1.11). They are in inertial axes about one point for
/// each tree.
template <class T> struct MovingInertia {
  Inertia<T> M;
  CoriolisInertia<T> B;
  Wrench<Spatial, T> F;  ///< M V' + B V / 2 minus the applied wrenches

  static constexpr std::size_t size = 28;  ///< number of numbers
  using Entries = std::array<T, size>;

  static constexpr MovingInertia of(const Inertia<T>& M, const Motion6<T>& V, const Motion6<T>& dV) {
    const auto B = CoriolisInertia<T>::of(M, V);
    const Momentum<Spatial, T> Pi = M * dV;
    return {M, B, {Pi.l + B.D * V.w, Pi.p + cross(V.w, B.p)}};
  }
};

/// The screws and wrenches of one joint screw S that are needed for the derivatives of τ: these are sums of
/// products of a screw of one joint screw with a wrench of another ((D1.16) and (D1.17) of docs/derivations).
/// With the inertia M, the Coriolis inertia B and the wrench F of the subtree, and the twist V of the body,
/// they are
///   σ = ψ' + [V, S],   U = M S,   P = M ψ'' + B ψ' - ad_Sᵀ F,   R = M σ + B S,
/// the moment t of the wrench Bᵀ S, and the time derivatives ψ' and ψ'' of S as a screw that is fixed to the
/// predecessor.
template <class T> struct ScrewEffects {
  Motion6<T> S, psi_2, sigma;
  Wrench<Spatial, T> U, P, R;
  Vec3<T> psi_1, t;  ///< psi_1: angular part of ψ'

  static constexpr std::size_t size = 42;
  using Entries = std::array<T, size>;

  /// Computes all members for a joint screw S, except the part of the wrench P that is due to loads. `moved`
  /// has the inertia, the Coriolis inertia and the wrench of the subtree. V_p and dV_p are the twist of the
  /// predecessor and its rate, and V is the twist of the body.
  static constexpr ScrewEffects of(const MovingInertia<T>& moved, const Motion6<T>& S, const Motion6<T>& V_p,
                                   const Motion6<T>& dV_p, const Motion6<T>& V) {
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

/// Loads the six-vectors from entry i on, one in each SIMD lane; set6() stores one six-vector in entry i.
template <class T> Motion6<typename Lanes<T>::Number> load6(const Arrays<T>& x, int i) {
  return {x.load3(0, i), x.load3(3, i)};
}
template <class T> void set6(const Arrays<T>& x, int i, const Motion6<T>& X) {
  x.set3(X.w, 0, i);
  x.set3(X.v, 3, i);
}

/// Sums n arrays over subtrees, from an entry for each body to one for each joint screw in `of_columns`.
template <class T>
void sum_subtrees(const Topology& topology, int n, const Arrays<T>& of_bodies,
                  const Arrays<T>& of_columns) noexcept {
  using L = Lanes<T>;
  for (int i = topology.n; i > 0; --i)
    if (const int p = topology.parent[i]; p > 0)
      for (int k = 0; k < n; ++k) of_bodies.array(k)[p] += of_bodies.array(k)[i];
  for (int i = 1, next; i <= topology.n; i = next) {
    const int c = topology.first_screw[i], hinges = topology.hinges[i];
    next = i + std::max(hinges, 1);
    if (hinges > 0)  // lanes beyond the last hinge are overwritten by the next bodies
      for (int k = 0; k < n; ++k)
        for (int x = 0; x < hinges; x += L::width)
          L::store(L::load(of_bodies.array(k) + i + x), of_columns.array(k) + c + x);
    else
      for (int k = 0; k < n; ++k)
        std::fill(of_columns.array(k) + c, of_columns.array(k) + topology.first_screw[next],
                  of_bodies.array(k)[i]);
  }
}

/// The joint screws of a moving tree, and the quantities on which displacements along them depend, in
/// inertial axes about the origins of the roots at this instant. A column is one joint screw; columns of a
/// subtree are adjacent. The screw of a coupled joint is for a unit velocity of its leader. Takes about 650
/// products and sums for a hinge.
template <class T> struct MovingScrews {
  using L = Lanes<T>;
  using Number = typename L::Number;
  struct SpatialMotion {
    Motion6<T> V, dV;
  };

  FastPoses<T> poses;
  Arrays<T> C, V, dV;     ///< for each body: its pose (columns of R, then r), its twist, and the rate of its
                          ///< twist with gravity included
  SpatialMotion* moving;  ///< V and dV of each body
  Arrays<T> moved;        ///< MovingInertia of each body; after compose() that of its subtree
  Arrays<T> S, V_p, dV_p,
      V_i;            ///< for each column: the screw, the twist of the predecessor and its rate, and the
                      ///< twist of the body
  Arrays<T> subtree;  ///< for each column: MovingInertia of the subtree

  explicit MovingScrews(Arena& arena)
      : poses(arena),
        C(arena, 12, arena.topology().n + 1),
        V(arena, 6, arena.topology().n + 1),
        dV(arena, 6, arena.topology().n + 1),
        moving(arena.per_body<SpatialMotion>()),
        moved(arena, static_cast<int>(MovingInertia<T>::size), arena.topology().n + 1),
        S(arena, 6, arena.topology().n_screws),
        V_p(arena, 6, arena.topology().n_screws),
        dV_p(arena, 6, arena.topology().n_screws),
        V_i(arena, 6, arena.topology().n_screws),
        subtree(arena, static_cast<int>(MovingInertia<T>::size), arena.topology().n_screws) {}

  /// Computes the motion and the MovingInertia of each body, and the joint screws.
  template <class Real>
  void run(const Tree<Real>& tree, const T* q, const T* v, const T* a, const Vec3<T>& g) noexcept {
    moving[0] = {{}, {{}, -g}};
    poses.template run<FastPoses<T>::From::root>(tree, q, [&](int i, const auto& at) {
      const SE3<T> C_i = axode::pose<T>(at);
      SpatialMotion next = moving[tree->parent[i]];
      if (is_hinge(tree, i)) [[likely]] {
        const int s = tree->first_screw[i], c = tree->iv[i];
        add(s, {C_i.R.z, cross(C_i.r, C_i.R.z)}, moving[tree->parent[i]], v[c], a[c], next);
        set6(V_i, s, next.V);
      } else {
        add_joint(tree, i, C_i, v, a, next);
      }
      C.set3(C_i.R.x, 0, i);
      C.set3(C_i.R.y, 3, i);
      C.set3(C_i.R.z, 6, i);
      C.set3(C_i.r, 9, i);
      set6(V, i, next.V);
      set6(dV, i, next.dV);
      moving[i] = next;
    });
    for (int i = 0; i <= tree->n; i += L::width) {
      const SE3<Number> at{{C.load3(0, i), C.load3(3, i), C.load3(6, i)}, C.load3(9, i)};
      const Inertia<Number> M = transform(at, inertias_in_lanes<T>(tree, i));
      const auto numbers = std::bit_cast<typename MovingInertia<Number>::Entries>(
          MovingInertia<Number>::of(M, load6(V, i), load6(dV, i)));
      for (std::size_t k = 0; k < numbers.size(); ++k)
        L::store(numbers[k], moved.array(static_cast<int>(k)) + i);
    }
  }

  /// Applies an external wrench W (in inertial axes about O) on body i, before compose().
  void load(int i, const Wrench<Spatial, T>& W) const noexcept {
    moved.set3(moved.get3(22, i) - W.m, 22, i);
    moved.set3(moved.get3(25, i) - W.f, 25, i);
  }

  /// Sums MovingInertia over the subtree of each joint.
  void compose(const Topology& topology) noexcept {
    sum_subtrees(topology, static_cast<int>(MovingInertia<T>::size), moved, subtree);
  }
  /// The wrench that the joint of body i transmits to the body, after compose().
  Wrench<Spatial, T> transmitted(int i) const { return {moved.get3(22, i), moved.get3(25, i)}; }

  /// The ScrewEffects of the columns from c on, one column in each lane, after compose().
  ScrewEffects<Number> effects(int c) const {
    return ScrewEffects<Number>::of(subtree_of_columns(c), load6(S, c), load6(V_p, c), load6(dV_p, c),
                                    load6(V_i, c));
  }
  /// MovingInertia of the bodies from i on, one body in each lane, before compose().
  MovingInertia<Number> bodies(int i) const { return several(moved, i); }
  /// MovingInertia of the subtrees of the joint screws from c on, one in each SIMD lane, after compose().
  MovingInertia<Number> subtree_of_columns(int c) const { return several(subtree, c); }
  MovingInertia<T> subtree_of_column(int c) const {
    typename MovingInertia<T>::Entries numbers;
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = subtree.array(static_cast<int>(k))[c];
    return std::bit_cast<MovingInertia<T>>(numbers);
  }
  /// The pose of body i in inertial axes, relative to the origin of its root.
  SE3<T> pose(int i) const { return {{C.get3(0, i), C.get3(3, i), C.get3(6, i)}, C.get3(9, i)}; }
  Motion6<T> screw(int c) const { return {S.get3(0, c), S.get3(3, c)}; }

 private:
  /// Adds the motion of one joint screw S_c (column c) with the velocity v and the acceleration a, and stores
  /// the screw. The twist of the body increases by v S_c, and its rate by a S_c + v [V_p, S_c], where V_p is
  /// the twist of the predecessor.
  void add(int c, const Motion6<T>& S_c, const SpatialMotion& p, const T& v, const T& a,
           SpatialMotion& next) noexcept {
    set6(S, c, S_c);
    set6(V_p, c, p.V);
    set6(dV_p, c, p.dV);
    const Motion6<T> psi = ad(p.V, S_c);
    next.V += v * S_c;
    next.dV += a * S_c + v * psi;
  }
  template <class Real>
  [[gnu::noinline]] void add_joint(const Tree<Real>& tree, int i, const SE3<T>& C_i, const T* v, const T* a,
                                   SpatialMotion& next) noexcept {
    const SpatialMotion p = next;
    const int first = tree->first_screw[i], c = tree->iv[i];
    const T ratio(tree.ratio[i]);
    with_subgroup(tree->kind[i], T(tree.pitch[i]), [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = joint.column(C_i, k);
        add(first + k, ratio * Motion6<T>{X.w, X.v}, p, v[c + k], a[c + k], next);
      }
      for (int k = 0; k < joint.nv; ++k) set6(V_i, first + k, next.V);
    });
  }
  static MovingInertia<Number> several(const Arrays<T>& x, int first) {
    typename MovingInertia<Number>::Entries numbers;
    for (std::size_t k = 0; k < numbers.size(); ++k)
      numbers[k] = L::load(x.array(static_cast<int>(k)) + first);
    return std::bit_cast<MovingInertia<Number>>(numbers);
  }
};

}  // namespace axode
