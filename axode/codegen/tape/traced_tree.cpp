#include "axode/codegen/tape/traced_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>

namespace axode::codegen {
namespace {

constexpr double noise = 1e-15;

void snap(std::initializer_list<double*> entries, double size) {
  for (double* x : entries)
    if (std::abs(*x) <= noise * size) *x = 0;
}
void snap(Vec3<>& a) { snap({&a.x, &a.y, &a.z}, std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)})); }
void snap(SE3<>& C) {
  for (Vec3<>* column : {&C.R.x, &C.R.y, &C.R.z}) {
    snap(*column);
    for (double* x : {&column->x, &column->y, &column->z})
      if (std::abs(std::abs(*x) - 1) <= noise) *x = std::copysign(1, *x);
  }
  snap(C.r);
}

/// Whether a joint cannot move an inertia M in its frame: it gives M no momentum and does not change it.
bool is_at_rest(Subgroup kind, const Inertia<>& M) {
  bool at_rest = true;
  with_subgroup(kind, 1.0, [&](const auto& joint) {
    for (int k = 0; k < joint.nv; ++k) {
      const auto [w, v] = joint.column(k);
      const Twist<Spatial> S{w, v};
      const Momentum<Spatial> P = M * S;
      const Inertia<> rate = inertia_rate(S, M);
      const std::array changes{P.l.x,         P.l.y,         P.l.z,         P.p.x,         P.p.y,
                               P.p.z,         rate.h.x,      rate.h.y,      rate.h.z,      rate.Theta.xx,
                               rate.Theta.yy, rate.Theta.zz, rate.Theta.xy, rate.Theta.xz, rate.Theta.yz};
      at_rest = at_rest && std::ranges::all_of(changes, [](double x) { return x == 0; });
    }
  });
  return at_rest;
}

/// The part of the inertia M of a body (in its joint frame) that can be added to the predecessor instead,
/// because the joint cannot move it. All entries are independent but xx and yy, of which a joint that turns
/// about z leaves only the sum at rest.
Inertia<> share_of_predecessor(Subgroup kind, const Inertia<>& M) {
  const auto& [xx, yy, zz, xy, xz, yz] = M.Theta;
  Inertia<> share;
  const auto add = [&](const Inertia<>& unit, double amount) {
    if (is_at_rest(kind, unit)) share += {amount * unit.m, amount * unit.h, amount * unit.Theta};
  };
  add({1, {}, {}}, M.m);
  add({0, {1, 0, 0}, {}}, M.h.x);
  add({0, {0, 1, 0}, {}}, M.h.y);
  add({0, {0, 0, 1}, {}}, M.h.z);
  add({0, {}, {1, 0, 0, 0, 0, 0}}, xx);
  add({0, {}, {0, 1, 0, 0, 0, 0}}, yy);
  add({0, {}, {0, 0, 1, 0, 0, 0}}, zz);
  add({0, {}, {0, 0, 0, 1, 0, 0}}, xy);
  add({0, {}, {0, 0, 0, 0, 1, 0}}, xz);
  add({0, {}, {0, 0, 0, 0, 0, 1}}, yz);
  add({0, {}, {1, 1, 0, 0, 0, 0}}, yy - share.Theta.yy);
  return share;
}

/// Moves the parts share_of_predecessor() of all inertias to the predecessors, from the leaves to the ground.
void move_inertias(const Topology& topology, TreeNumbers<double>& tree) {
  for (int i = topology.n; i > 0; --i) {
    Inertia<>& M = tree.M[i];
    const Inertia<> share = share_of_predecessor(topology.kind[i], M);
    const double Theta = trace(M.Theta), h = norm(M.h);
    tree.M[topology.parent[i]] += transform(tree.B[i], share);
    M = {M.m - share.m, M.h - share.h, M.Theta - share.Theta};
    snap({&M.h.x, &M.h.y, &M.h.z}, h);
    snap({&M.Theta.xx, &M.Theta.yy, &M.Theta.zz, &M.Theta.xy, &M.Theta.xz, &M.Theta.yz}, Theta);
  }
  tree.M[0] = {};
}

}  // namespace

Tree<double> traced_tree(const Tree<double>& tree) {
  TreeNumbers<double> traced = tree;
  for (SE3<>& B : traced.B) snap(B);
  for (SE3<>& offset : traced.frame_offset) snap(offset);
  move_inertias(*tree.topology(), traced);
  return {tree.topology(), std::move(traced)};
}

}  // namespace axode::codegen
