#pragma once
#include <concepts>
#include <vector>

#include "axode/lie/inertia.hpp"
#include "axode/model/body_constants.hpp"

namespace axode {

/// Bodies whose joints are of one kind: by_kind[begin] to by_kind[end - 1].
struct JointRun {
  Subgroup kind;
  bool coupled;  ///< q_i = ratio q_j + offset; coupled runs come last
  int begin, end;
};

/// The numbers of a model that the kernels read. Body 0 is the ground; parent[i] < i; the joint of body i is
/// index i. The internal frame of body i is its joint frame, so that S_i is sparse; frames carry the user's
/// own as offsets.
template <class T = double> struct Tree {
  int n = 0, nq = 0, nv = 0;  ///< moving bodies, coordinates, velocities
  int n_screws = 0;           ///< joint screws: a column for each degree of freedom of every joint
  std::vector<int> parent;    ///< n + 1
  std::vector<JointRun> runs;
  std::vector<int> by_kind;    ///< n
  std::vector<Subgroup> kind;  ///< n + 1
  std::vector<char> coupled;   ///< n + 1
  std::vector<int>
      first_screw;  ///< n + 2: the screws of joint i are first_screw[i] to first_screw[i + 1] - 1
  std::vector<int>
      velocity_parent;      ///< nv: M = LᵀDL has entries L(c, velocity_parent[c]), ...; -1 at the end
  std::vector<int> iq, iv;  ///< n + 1: first coordinate and velocity (of the leader for a coupled joint)
  std::vector<int> angle;   ///< iq of joints 1 to n, and 0 up to a multiple of the lanes of any SIMD register
  std::vector<int> coupled_bodies, quaternion_bodies;  ///< those whose joint is coupled; has a quaternion
  std::vector<char> branches;    ///< n + 1: whether a body other than the next one hangs on it
  std::vector<int> subtree_end;  ///< n + 1: the bodies that joint i moves are i to subtree_end[i] - 1
  std::vector<int>
      velocity_end;  ///< nv: without couplings, the velocities that move along with c are c to velocity_end[c] - 1
  int depth = 0;                 ///< velocities on the longest path from the ground
  std::vector<T> pivot_floor;    ///< n_screws: a pivot of M below this is small against what the joint moves
  std::vector<T> pitch;          ///< n + 1, m/rad
  std::vector<T> ratio, offset;  ///< n + 1: 1 and 0 for a joint with coordinates of its own
  std::vector<SE3<T>> B;      ///< n + 1: joint frame of i at q = 0 in the internal frame of its predecessor
  std::vector<Inertia<T>> M;  ///< n + 1: in the internal frame
  std::vector<T> inertia_arrays;  ///< the same in arrays: h, Θ (xx yy zz xy xz yz), m; entry i for body i
  int inertia_stride = 0;         ///< from one array to the next
  std::vector<int> hinges;  ///< n + 1: how many hinges with coordinates of their own follow, from joint i on
  PackedConstants<T> packed;         ///< the same again for sweeps, of n + 1 bodies
  std::vector<T> armature;           ///< nv, kg m² or kg, of all joints on that velocity
  std::vector<T> damping, friction;  ///< nv, N m s/rad or N s/m; N m or N
  std::vector<int>
      frame_body;  ///< frame f: 0 is the ground, 1..n the bodies as the user placed them, then extra
  std::vector<SE3<T>> frame_offset;  ///< pose of frame f in the internal frame of its body
  Vec3<T> g;                         ///< gravity, m/s²

  int n_frames() const { return static_cast<int>(frame_body.size()); }
};

/// A tree of numbers T, in whatever frames: what a kernel takes that reads joints with each_joint and poses and
/// inertias of no other place than B and M.
template <class X, class T>
concept TreeOf = std::derived_from<X, Tree<T>>;

/// The same numbers as another scalar.
template <class To, class From> constexpr Vec3<To> cast(const Vec3<From>& a) {
  return {To(a.x), To(a.y), To(a.z)};
}
template <class To, class From> constexpr SE3<To> cast(const SE3<From>& C) {
  return {{cast<To>(C.R.x), cast<To>(C.R.y), cast<To>(C.R.z)}, cast<To>(C.r)};
}
template <class To, class From> constexpr Sym3<To> cast(const Sym3<From>& A) {
  return {To(A.xx), To(A.yy), To(A.zz), To(A.xy), To(A.xz), To(A.yz)};
}
template <class To, class From> constexpr Inertia<To> cast(const Inertia<From>& M) {
  return {To(M.m), cast<To>(M.h), cast<To>(M.Theta)};
}
template <class To, class From> Tree<To> cast(const Tree<From>& tree) {
  const auto each = [](const auto& in, const auto& convert) {
    std::vector<decltype(convert(in[0]))> out;
    out.reserve(in.size());
    for (const auto& x : in) out.push_back(convert(x));
    return out;
  };
  const auto number = [](const From& x) { return To(x); };
  const auto pose = [](const SE3<From>& C) { return cast<To>(C); };
  Tree<To> r;
  r.n = tree.n, r.nq = tree.nq, r.nv = tree.nv, r.n_screws = tree.n_screws;
  r.velocity_parent = tree.velocity_parent, r.kind = tree.kind, r.coupled = tree.coupled,
  r.first_screw = tree.first_screw;
  r.angle = tree.angle, r.coupled_bodies = tree.coupled_bodies, r.quaternion_bodies = tree.quaternion_bodies,
  r.subtree_end = tree.subtree_end, r.branches = tree.branches;
  r.velocity_end = tree.velocity_end, r.depth = tree.depth;
  r.pivot_floor = each(tree.pivot_floor, number);
  r.inertia_arrays = each(tree.inertia_arrays, number), r.inertia_stride = tree.inertia_stride,
  r.hinges = tree.hinges;
  r.parent = tree.parent, r.runs = tree.runs, r.by_kind = tree.by_kind, r.iq = tree.iq, r.iv = tree.iv;
  r.pitch = each(tree.pitch, number), r.ratio = each(tree.ratio, number),
  r.offset = each(tree.offset, number);
  r.B = each(tree.B, pose), r.M = each(tree.M, [](const Inertia<From>& M) { return cast<To>(M); });
  if constexpr (std::floating_point<To>)
    for (int i = 0; i <= r.n; ++i) r.packed.body.emplace_back(r.B[i], r.M[i]);
  r.armature = each(tree.armature, number);
  r.damping = each(tree.damping, number), r.friction = each(tree.friction, number);
  r.frame_body = tree.frame_body, r.frame_offset = each(tree.frame_offset, pose);
  r.g = cast<To>(tree.g);
  return r;
}

/// f(joint) for the joint of body i.
template <class T, class F> constexpr decltype(auto) with_joint(const Tree<T>& tree, int i, F&& f) {
  return with_subgroup(tree.kind[i], tree.pitch[i], f);
}

/// f(joint, i, coupled) for every joint with coordinates of its own, kind by kind; then for the coupled ones.
template <class T, class F> constexpr void each_joint(const Tree<T>& tree, F&& f) {
  for (const JointRun& run : tree.runs) {
    if (run.kind == Subgroup::helical) {
      for (int k = run.begin; k < run.end; ++k) {
        const int i = tree.by_kind[k];
        f(subgroup::Helical<T>{tree.pitch[i]}, i, run.coupled);
      }
    } else {
      with_subgroup(run.kind, T(0), [&](const auto& joint) {
        for (int k = run.begin; k < run.end; ++k) f(joint, tree.by_kind[k], run.coupled);
      });
    }
  }
}

}  // namespace axode
