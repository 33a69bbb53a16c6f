#pragma once
#include "axode/recursion/forward_kinematics.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// Σ of something of every body over the subtree behind each joint; of bodies with different roots nothing is summed.
template <class X> void sum_subtrees(const Topology& topology, X* x) noexcept {
  for (int i = topology.n; i > 0; --i)
    if (topology.parent[i] > 0) x[topology.parent[i]] += x[i];
}

/// What every formula on joint screws in spatial representation starts from: J_i^s of all joints and the
/// inertia M_i^c of all that joint i moves. Only bodies of one root meet in such a formula, so everything is about the
/// origin O of the root body at this instant, in inertial axes: nothing is lost where the mechanism is far from the
/// inertial origin.
template <class T> struct SpatialTree {
  const Topology* topology = nullptr;
  BodyLinks<Spatial, T> links;
  Link<Spatial, T>* link;  ///< the poses of the bodies against O
  Vec3<T>* origin;         ///< O of each body, in the inertial frame
  Inertia<T>* M_body;
  Inertia<T>* M;  ///< composite
  Twist<Spatial, T>* J;

  explicit SpatialTree(Arena& arena)
      : links(arena),
        link(links.link),
        origin(links.origin),
        M_body(arena.per_body<Inertia<T>>()),
        M(arena.per_body<Inertia<T>>()),
        J(arena.per_screw<Twist<Spatial, T>>()) {}
  SpatialTree(Arena& arena, const Tree<T>& tree, const T* q) noexcept : SpatialTree(arena) { run(tree, q); }

  template <TreeOf<T> AnyTree> void run(const AnyTree& t, const T* q) noexcept {
    topology = t.operator->();
    links.run(t, q);
    for (int i = 1; i <= t->n; ++i)
      if (t->parent[i] > 0) origin[i] = origin[t->parent[i]];
    joint_columns(t, link, J);
    M_body[0] = M[0] = {};
    for (int i = 1; i <= t->n; ++i) M_body[i] = M[i] = transform(link[i].C, t.M[i]);
    sum_subtrees(*topology, M);
  }

  /// f(c, J_c) for the screws of the joint of body i, with the index c of the velocity.
  template <class F> void each_screw(int i, F&& f) const {
    const int first = topology->first_screw[i];
    for (int s = first; s < topology->first_screw[i + 1]; ++s) f(topology->iv[i] + s - first, J[s]);
  }
  SE3<T> pose(int i) const { return {link[i].C.R, i > 0 ? origin[i] + link[i].C.r : Vec3<T>{}}; }
  T mass() const {
    T sum(0);
    axode::each_root(*topology, [&](int i) { sum += M[i].m; });
    return sum;
  }
  /// The centre of mass of everything, in the inertial frame. There must be a mass.
  Vec3<T> mass_center() const {
    Vec3<T> h;
    axode::each_root(*topology, [&](int i) { h += M[i].h + M[i].m * origin[i]; });
    return (T(1) / mass()) * h;
  }

  /// V_i = V_p + J v of all bodies (eq. Vsirec).
  void twists(const T* v, Twist<Spatial, T>* V) const noexcept {
    V[0] = {};
    for (int i = 1; i <= topology->n; ++i) {
      V[i] = V[topology->parent[i]];
      each_screw(i, [&](int c, const Twist<Spatial, T>& J_c) { V[i] += v[c] * J_c; });
    }
  }
};

/// Twists of all bodies, and the momenta of their subtrees, Π_i^A, about the origins of a SpatialTree.
template <class T> struct SubtreeMomenta {
  Twist<Spatial, T>* V;
  Momentum<Spatial, T>* Pi;

  explicit SubtreeMomenta(Arena& arena)
      : V(arena.per_body<Twist<Spatial, T>>()), Pi(arena.per_body<Momentum<Spatial, T>>()) {}

  void run(const SpatialTree<T>& s, const T* v) noexcept {
    s.twists(v, V);
    for (int i = 0; i <= s.topology->n; ++i) Pi[i] = s.M_body[i] * V[i];
    sum_subtrees(*s.topology, Pi);
  }
  /// The momentum of everything, about the inertial origin.
  Momentum<Spatial, T> whole(const SpatialTree<T>& s) const {
    Momentum<Spatial, T> sum{};
    each_root(*s.topology, [&](int i) {
      sum += Momentum<Spatial, T>{Pi[i].l + cross(s.origin[i], Pi[i].p), Pi[i].p};
    });
    return sum;
  }
};

}  // namespace axode
