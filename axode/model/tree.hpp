#pragma once
#include <concepts>
#include <memory>
#include <vector>

#include "axode/lie/inertia.hpp"
#include "axode/model/body_constants.hpp"
#include "axode/model/topology.hpp"

namespace axode {

/// The real-valued data of a tree. The data of body i refer to its internal frame, which is its joint frame;
/// in this frame the motion subspace S_i is sparse. Named frames are given by their poses in the internal
/// frames of their bodies.
template <class T = double> struct TreeNumbers {
  std::vector<T> pitch;          ///< n + 1, m/rad
  std::vector<T> ratio, offset;  ///< n + 1: coupling of joint i to its leader; 1 and 0 if not coupled
  std::vector<SE3<T>> B;      ///< n + 1: pose of the joint frame at q = 0 in the predecessor's internal frame
  std::vector<Inertia<T>> M;  ///< n + 1: inertia of each body in its internal frame
  std::vector<T> armature;    ///< nv: inertia of the drives of all joints with the velocity, kg m² or kg
  std::vector<T> damping, friction;  ///< nv: N m s/rad or N s/m; N m or N
  std::vector<SE3<T>> frame_offset;  ///< pose of frame f in the internal frame of its body
  Vec3<T> g;                         ///< gravity, m/s²
};

/// The data of a tree for recursions. Integers are accessed by an arrow, as in `tree->parent[i]`, and are
/// shared by the trees of all scalar types. Real numbers are accessed by a dot, as in `tree.B[i]`.
template <class T = double> class Tree : public TreeNumbers<T> {
 public:
  Tree(std::shared_ptr<const Topology> topology, TreeNumbers<T> numbers);

  const Topology* operator->() const { return topology_.get(); }
  const std::shared_ptr<const Topology>& topology() const { return topology_; }

  // The following members are computed from the others by the constructor; kernels read them.
  std::vector<T> inertia_scale;   ///< n_screws: upper bound of Sᵀ M S of each joint screw at q = 0
  std::vector<T> inertia_arrays;  ///< ten arrays: h, Θ (xx yy zz xy xz yz), m; entry i is that of body i
  int inertia_stride = 0;         ///< distance between the starts of two of the ten arrays, in entries
  PackedConstants<T> packed;      ///< constants of n + 1 bodies

 private:
  void set_inertia_scale();
  void set_inertia_arrays();

  std::shared_ptr<const Topology> topology_;
};

/// The requirements of recursions on the type of a tree. All members of Topology are accessed by an arrow, as
/// in `tree->parent[i]`. Real-valued data are accessed by a dot, as in `tree.B[i]`; B are the poses of bodies
/// relative to their predecessors at q = 0, and M are the inertias. A function each_joint(tree, f) must call
/// f for the joint of every body. The body frames may be any frames.
template <class X, class T>
concept TreeOf = requires(const X& tree, int i) {
  { tree->parent[i] } -> std::convertible_to<int>;
  { tree.armature[i] } -> std::convertible_to<T>;
  { tree.g } -> std::convertible_to<Vec3<T>>;
  tree.B[i], tree.M[i], tree.ratio[i], tree.frame_offset[i];
};

/// cast<To>() converts a vector, pose, tensor, inertia or tree to another scalar.
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
  const auto numbers = [&](const std::vector<From>& in) {
    return each(in, [](const From& x) { return To(x); });
  };
  const auto poses = [&](const std::vector<SE3<From>>& in) {
    return each(in, [](const SE3<From>& C) { return cast<To>(C); });
  };
  return {tree.topology(),
          {.pitch = numbers(tree.pitch),
           .ratio = numbers(tree.ratio),
           .offset = numbers(tree.offset),
           .B = poses(tree.B),
           .M = each(tree.M, [](const Inertia<From>& M) { return cast<To>(M); }),
           .armature = numbers(tree.armature),
           .damping = numbers(tree.damping),
           .friction = numbers(tree.friction),
           .frame_offset = poses(tree.frame_offset),
           .g = cast<To>(tree.g)}};
}

/// Calls f with the subgroup struct of the joint of body i, and returns the result.
template <class T, class F> constexpr decltype(auto) with_joint(const Tree<T>& tree, int i, F&& f) {
  return with_subgroup(tree->kind[i], tree.pitch[i], f);
}

/// Calls f(joint, i, coupled) for every body i. `joint` has the formulas of its joint
/// (axode/model/subgroup.hpp), and `coupled` says whether the joint is coupled to another one. Bodies are
/// taken by kinds of joints, and coupled joints are last.
template <class T, class F> constexpr void each_joint(const Tree<T>& tree, F&& f) {
  for (const JointGroup& group : tree->joint_groups) {
    if (group.kind == Subgroup::helical) {
      for (int k = group.begin; k < group.end; ++k) {
        const int i = tree->by_kind[k];
        f(subgroup::Helical<T>{tree.pitch[i]}, i, group.coupled);
      }
    } else {
      with_subgroup(group.kind, T(0), [&](const auto& joint) {
        for (int k = group.begin; k < group.end; ++k) f(joint, tree->by_kind[k], group.coupled);
      });
    }
  }
}

template <class T>
Tree<T>::Tree(std::shared_ptr<const Topology> topology, TreeNumbers<T> numbers)
    : TreeNumbers<T>(std::move(numbers)), topology_(std::move(topology)) {
  set_inertia_scale();
  set_inertia_arrays();
  if constexpr (std::floating_point<T>)
    for (int i = 0; i <= topology_->n; ++i) packed.body.emplace_back(this->B[i], this->M[i]);
}

/// Computes inertia_scale, an upper bound of the inertia that each joint screw moves. For the screw (w; v) it
/// is |w|² tr Θ + |v|² m plus the armature, with the rotational inertia Θ about the joint frame's origin and
/// the mass m of the subtree with all joints at zero. Armatures of coupled joints are left out.
template <class T> void Tree<T>::set_inertia_scale() {
  std::vector<Inertia<T>> composite(this->M);
  for (int i = topology_->n; i > 0; --i)
    composite[topology_->parent[i]] += transform(this->B[i], composite[i]);
  for (int i = 1; i <= topology_->n; ++i)
    with_joint(*this, i, [&](const auto& joint) {
      for (int k = 0; k < joint.nv; ++k) {
        const Screw<T> X = joint.column(k);
        const T drive = topology_->coupled[i] ? T(0) : this->armature[topology_->iv[i] + k];
        inertia_scale.push_back(dot(X.w, X.w) * trace(composite[i].Theta) + dot(X.v, X.v) * composite[i].m +
                                drive);
      }
    });
}

template <class T> void Tree<T>::set_inertia_arrays() {
  constexpr int most_lanes = 16;
  inertia_stride = (topology_->n + 2 * most_lanes) / most_lanes * most_lanes;
  inertia_arrays.resize(10 * static_cast<std::size_t>(inertia_stride));
  for (int i = 1; i <= topology_->n; ++i) {
    const auto& [m, h, A] = this->M[i];
    T* at = inertia_arrays.data() + i;
    for (const T& x : {h.x, h.y, h.z, A.xx, A.yy, A.zz, A.xy, A.xz, A.yz, m}) *at = x, at += inertia_stride;
  }
}

}  // namespace axode
