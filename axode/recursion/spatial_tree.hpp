#pragma once
#include <algorithm>

#include "axode/recursion/forward_kinematics.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

/// Replaces x[i] of each body by the sum over the subtree of body i. x[0] remains unchanged.
template <class X> void sum_subtrees(const Topology& topology, X* x) noexcept {
  for (int i = topology.n; i > 0; --i)
    if (topology.parent[i] > 0) x[topology.parent[i]] += x[i];
}

/// The screws J_i^s of all joints in spatial representation, and the composite inertia M_i^c of the subtree
/// of each joint. Both are in inertial axes about the present position O of the origin of the root body (the
/// first body on the path from the ground), so that no digits are lost if the mechanism is far from the
/// inertial origin.
template <class T> struct SpatialTree {
  const Topology* topology = nullptr;
  BodyLinks<Spatial, T> links;
  Link<Spatial, T>* link;  ///< poses of the bodies relative to O
  Vec3<T>* origin;         ///< position of O in the inertial frame, for each body
  Inertia<T>* M_body;      ///< inertia of each body
  Inertia<T>* M;           ///< composite inertia of each subtree
  Twist<Spatial, T>* J;    ///< joint screws

  explicit SpatialTree(Arena& arena)
      : links(arena),
        link(links.link),
        origin(links.origin),
        M_body(arena.per_body<Inertia<T>>()),
        M(arena.per_body<Inertia<T>>()),
        J(arena.per_screw<Twist<Spatial, T>>()) {}
  SpatialTree(Arena& arena, const Tree<T>& tree, const T* q) noexcept : SpatialTree(arena) { run(tree, q); }

  /// Computes all members at q.
  template <TreeOf<T> AnyTree> void run(const AnyTree& t, const T* q) noexcept {
    topology = t.operator->();
    links.run(t, q);
    joint_columns(t, link, J);
    for (int i = 1; i <= t->n; ++i) M_body[i] = transform(link[i].C, t.M[i]);
    finish();
  }
  /// Computes all members from the links, screws and rigid inertias of articulated bodies.
  template <class Bodies> void take(const Topology& of_tree, const Bodies& bodies) noexcept {
    topology = &of_tree;
    std::copy_n(bodies.links.link, of_tree.n + 1, link);
    std::copy_n(bodies.links.origin, of_tree.n + 1, origin);
    std::copy_n(bodies.S, of_tree.first_screw[of_tree.n + 1], J);
    std::copy_n(bodies.M_body, of_tree.n + 1, M_body);
    finish();
  }

  /// Calls f(c, J_c) for each screw J_c of the joint of body i; c is the index of its velocity.
  template <class F> void each_screw(int i, F&& f) const {
    const int first = topology->first_screw[i];
    for (int s = first; s < topology->first_screw[i + 1]; ++s) f(topology->iv[i] + s - first, J[s]);
  }
  /// The pose of body i in the inertial frame.
  SE3<T> pose(int i) const { return {link[i].C.R, i > 0 ? origin[i] + link[i].C.r : Vec3<T>{}}; }
  /// The total mass of all bodies.
  T mass() const {
    T sum(0);
    axode::each_root(*topology, [&](int i) { sum += M[i].m; });
    return sum;
  }
  /// The centre of mass of all bodies in the inertial frame. The total mass must not be 0.
  Vec3<T> mass_center() const {
    Vec3<T> h;
    axode::each_root(*topology, [&](int i) { h += M[i].h + M[i].m * origin[i]; });
    return (T(1) / mass()) * h;
  }

  /// Computes the twists V_i = V_p + J v of all bodies (Müller, eq. Vsirec).
  void twists(const T* v, Twist<Spatial, T>* V) const noexcept {
    V[0] = {};
    for (int i = 1; i <= topology->n; ++i) {
      V[i] = V[topology->parent[i]];
      each_screw(i, [&](int c, const Twist<Spatial, T>& J_c) { V[i] += v[c] * J_c; });
    }
  }

 private:
  /// Sets the origins of all bodies to those of their root bodies, and sums the inertias of subtrees.
  void finish() noexcept {
    for (int i = 1; i <= topology->n; ++i)
      if (topology->parent[i] > 0) origin[i] = origin[topology->parent[i]];
    M_body[0] = {};
    std::copy_n(M_body, topology->n + 1, M);
    sum_subtrees(*topology, M);
  }
};

/// The twists of all bodies and the momenta Π_i of their subtrees. Both are in inertial axes about the
/// present position of the origin of the root body (the first body on the path from the ground).
template <class T> struct SubtreeMomenta {
  Twist<Spatial, T>* V;
  Momentum<Spatial, T>* Pi;

  explicit SubtreeMomenta(Arena& arena)
      : V(arena.per_body<Twist<Spatial, T>>()), Pi(arena.per_body<Momentum<Spatial, T>>()) {}

  /// Computes twists and momenta for the velocities v at the configuration of s.
  void run(const SpatialTree<T>& s, const T* v) noexcept {
    s.twists(v, V);
    for (int i = 0; i <= s.topology->n; ++i) Pi[i] = s.M_body[i] * V[i];
    sum_subtrees(*s.topology, Pi);
  }
  /// The momentum of all bodies about the inertial origin.
  Momentum<Spatial, T> whole(const SpatialTree<T>& s) const {
    Momentum<Spatial, T> sum{};
    each_root(*s.topology, [&](int i) {
      sum += Momentum<Spatial, T>{Pi[i].l + cross(s.origin[i], Pi[i].p), Pi[i].p};
    });
    return sum;
  }
};

}  // namespace axode
