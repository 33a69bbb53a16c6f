#include "axode/codegen/tape/traced_tree.hpp"

#include <algorithm>
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

/// The part of the inertia M of a body (in its joint frame) that can be added to the predecessor instead,
/// because its effect on the predecessor does not depend on the coordinate of the joint.
Inertia<> share_of_predecessor(Subgroup kind, const Inertia<>& M) {
  const double Theta = M.Theta.yy;
  switch (kind) {
    case Subgroup::revolute: return {M.m, {0, 0, M.h.z}, {Theta, Theta, 0, 0, 0, 0}};
    case Subgroup::prismatic: return {0, {}, M.Theta};
    case Subgroup::spherical: return {M.m, {}, {}};
    case Subgroup::helical:
    case Subgroup::planar:
    case Subgroup::free: break;
  }
  return {};
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
