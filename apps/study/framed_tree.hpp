#pragma once
#include <algorithm>
#include <type_traits>

#include "axode/model/tree.hpp"

/// A Tree with other body frames, to compare the costs of recursions in different frames.
namespace axode {

struct UserFrames {};        ///< the user's body frames; joint screws may be any screws
struct MassCenterFrames {};  ///< frames at the centres of mass, parallel to the joint frames; h = 0
struct ConstructionFrames {
};  ///< at q = 0 all are the inertial frame: B_i = I, C_i = exp(Y_1 q_1) ... exp(Y_i q_i)

namespace framed {

/// The terms of the pose C_0 + sin q C_s + cos q C_c of a revolute joint at the angle q.
template <class T> struct Terms { SE3<T> C_0, C_s, C_c; };

/// The three terms of the pose L exp(e_z q) D as a function of q, for poses L and D.
template <class T> Terms<T> terms(const SE3<T>& L, const SE3<T>& D) {
  const SO3<T> along{{}, {}, L.R.z}, sine{L.R.y, -L.R.x, {}}, cosine{L.R.x, L.R.y, {}};
  return {{along * D.R, L.r + along * D.r}, {sine * D.R, sine * D.r}, {cosine * D.R, cosine * D.r}};
}

/// A revolute or helical joint with any constant screw X in the body frame.
template <class T, class Frames, bool helical> struct Turning : subgroup::VectorCoordinates<T, 1> {
  Terms<T> C;
  Screw<T> X;
  Vec3<T> lead;  ///< translation for q = 1, in the predecessor's frame

  /// Poses: L of the joint frame in the predecessor's frame, and D of the body frame in the joint frame.
  Turning(const SE3<T>& L, const SE3<T>& D, const T& pitch)
      : C(terms(L, D)),
        X(Ad_inv(D, Screw<T>{{T(0), T(0), T(1)}, {T(0), T(0), pitch}})),
        lead(pitch * L.R.z) {}

  SE3<T> pose(const SE3<T>&, const T* q) const {
    SE3<T> out = turned(sin(q[0]), cos(q[0]));
    if constexpr (helical) out.r += q[0] * lead;
    return out;
  }
  Twist<BodyFixed, T> twist(const T* v) const {
    if constexpr (std::same_as<Frames, MassCenterFrames>)  // n = e_z
      return {{T(0), T(0), v[0]}, {X.v.x * v[0], X.v.y * v[0], helical ? X.v.z * v[0] : T(0)}};
    else
      return {v[0] * X.w, v[0] * X.v};
  }
  std::array<T, 1> project(const Wrench<BodyFixed, T>& W) const {
    if constexpr (!std::same_as<Frames, MassCenterFrames>)
      return {dot(X.w, W.m) + dot(X.v, W.f)};
    else if constexpr (helical)
      return {W.m.z + dot(X.v, W.f)};
    else
      return {W.m.z + (X.v.x * W.f.x + X.v.y * W.f.y)};
  }
  const Screw<T>& column(int) const { return X; }

 private:
  SE3<T> turned(const T& s, const T& c) const {
    const auto sum = [&](Vec3<T> SO3<T>::*column) {
      return C.C_0.R.*column + (s * (C.C_s.R.*column) + c * (C.C_c.R.*column));
    };
    if constexpr (std::same_as<Frames, ConstructionFrames>) {
      // As the pose at q = 0 is the identity: R = I + s ñ + (c - 1) (-ñ²), r = s r_s + (c - 1) r_c
      const T k = c - T(1);
      const SO3<T>& P = C.C_c.R;
      const T xx = k * P.x.x, yy = k * P.y.y, zz = k * P.z.z, xy = k * P.x.y, xz = k * P.x.z, yz = k * P.y.z;
      const Vec3<T> n = s * X.w;
      return {
          {{T(1) + xx, xy + n.z, xz - n.y}, {xy - n.z, T(1) + yy, yz + n.x}, {xz + n.y, yz - n.x, T(1) + zz}},
          s * C.C_s.r + k * C.C_c.r};
    } else {
      const Vec3<T> r = C.C_0.r + (s * C.C_s.r + c * C.C_c.r);
      if constexpr (std::same_as<Frames, MassCenterFrames>)
        return {subgroup::turn(SO3<T>{C.C_c.R.x, C.C_c.R.y, C.C_0.R.z}, s, c), r};
      else
        return {{sum(&SO3<T>::x), sum(&SO3<T>::y), sum(&SO3<T>::z)}, r};
    }
  }
};

/// A prismatic joint along any axis, with the pose C = (R_0, r_0 + q u).
template <class T, class Frames> struct Sliding : subgroup::VectorCoordinates<T, 1> {
  SE3<T> C_0;
  Vec3<T> u, e;  ///< the axis in the frame of the predecessor and in the body frame

  Sliding(const SE3<T>& L, const SE3<T>& D, const T& /*pitch*/) : C_0(L * D), u(L.R.z), e(transpose(D.R).z) {}

  SE3<T> pose(const SE3<T>&, const T* q) const {
    if constexpr (std::same_as<Frames, ConstructionFrames>)
      return {{}, q[0] * u};
    else
      return {C_0.R, C_0.r + q[0] * u};
  }
  Twist<BodyFixed, T> twist(const T* v) const { return {{}, v[0] * e}; }
  std::array<T, 1> project(const Wrench<BodyFixed, T>& W) const { return {dot(e, W.f)}; }
  Screw<T> column(int) const { return {{}, e}; }
};

/// The type of the body frame's pose in the joint frame: a vector if both are parallel, otherwise SE3.
template <class Frames, class T>
using Offset = std::conditional_t<std::same_as<Frames, MassCenterFrames>, Vec3<T>, SE3<T>>;

template <class T> SE3<T> moved(const SE3<T>& C, const SE3<T>& D) { return C * D; }
template <class T> SE3<T> moved(const SE3<T>& C, const Vec3<T>& d) { return {C.R, C.r + C.R * d}; }
template <class T> Twist<BodyFixed, T> expressed_in(const SE3<T>& D, const Twist<BodyFixed, T>& V) {
  return twist<BodyFixed>(Ad_inv(D, screw(V)));
}
template <class T> Twist<BodyFixed, T> expressed_in(const Vec3<T>& d, const Twist<BodyFixed, T>& V) {
  const ScrewOperationScope<T> scope(ScrewOperation::translation);
  return {V.w, V.v + cross(V.w, d)};
}
template <class T> Wrench<BodyFixed, T> brought_back(const SE3<T>& D, const Wrench<BodyFixed, T>& W) {
  const Wrench<Spatial, T> W_joint = coAd(D, W);  // the joint frame takes the role of the inertial frame
  return {W_joint.m, W_joint.f};
}
template <class T> Wrench<BodyFixed, T> brought_back(const Vec3<T>& d, const Wrench<BodyFixed, T>& W) {
  const ScrewOperationScope<T> scope(ScrewOperation::translation);
  return {W.m + cross(d, W.f), W.f};
}

/// A joint with several degrees of freedom whose body frame is not the joint frame. The body frame has the
/// pose L exp(S q) D relative to the predecessor, with the pose L of the joint frame at q = 0, the joint
/// screws S and coordinates q, and the pose D of the body frame in the joint frame.
template <class Joint, class T, class Offset> struct Conjugated {
  static constexpr int nq = Joint::nq, nv = Joint::nv;
  const SE3<T>& L;
  const Offset& D;
  const Screw<T>* X;

  SE3<T> pose(const SE3<T>&, const T* q) const { return moved(Joint::pose(L, q), D); }
  Twist<BodyFixed, T> twist(const T* v) const { return expressed_in(D, Joint::twist(v)); }
  auto project(const Wrench<BodyFixed, T>& W) const { return Joint::project(brought_back(D, W)); }
  const Screw<T>& column(int k) const { return X[k]; }
};

}  // namespace framed

/// The tree in the body frames that the type Frames chooses. A joint whose body frame remains the joint frame
/// does not change. All other joints get constant screws, of which all six entries may be non-zero.
template <class T, class Frames> class FramedTree {
 public:
  static constexpr bool central = std::same_as<Frames, MassCenterFrames>;
  using InertiaOfBody = std::conditional_t<central, CentralInertia<T>, Inertia<T>>;

 private:
  const Tree<T> tree_;

 public:
  const std::vector<T>&pitch = tree_.pitch, &ratio = tree_.ratio, &offset = tree_.offset;
  const std::vector<T>& inertia_scale = tree_.inertia_scale;
  const std::vector<T>&armature = tree_.armature, &damping = tree_.damping, &friction = tree_.friction;
  const Vec3<T>& g = tree_.g;
  std::vector<SE3<T>> B, frame_offset;  ///< as in Tree, but in the frames Frames, like all members below
  std::vector<InertiaOfBody> M;         ///< n + 1: inertia of each body
  std::vector<JointGroup> joint_groups;
  std::vector<int> by_kind;
  std::vector<std::ptrdiff_t>
      at;  ///< for each joint group: index of its first joint in revolute, helical or prismatic;
           ///< -1 if the frames of its bodies are their joint frames
  std::vector<framed::Turning<T, Frames, false>> revolute;
  std::vector<framed::Turning<T, Frames, true>> helical;
  std::vector<framed::Sliding<T, Frames>> prismatic;
  std::vector<SE3<T>> L;                     ///< n + 1: joint frame in the predecessor's frame, at q = 0
  std::vector<framed::Offset<Frames, T>> D;  ///< n + 1: body frame in the joint frame
  std::vector<Screw<T>> X;                   ///< n_screws: joint screws in the body frame

  explicit FramedTree(Tree<T> of)
      : tree_(std::move(of)), B(tree_.B), frame_offset(tree_.frame_offset), by_kind(tree_->by_kind) {
    const Tree<T>& tree = tree_;
    const std::vector<SE3<T>> in_joint = offsets(tree);
    X.resize(static_cast<std::size_t>(tree->n_screws));
    for (int i = 0; i <= tree->n; ++i) {
      L.push_back(inverse(in_joint[tree->parent[i]]) * tree.B[i]);
      B[i] = L[i] * in_joint[i];
      if constexpr (central) {
        D.push_back(in_joint[i].r);
        M.push_back({tree.M[i].m, tree.M[i].m > T(0) ? inertia_about_com(tree.M[i]) : tree.M[i].Theta});
      } else {
        D.push_back(in_joint[i]);
        M.push_back(transform(inverse(in_joint[i]), tree.M[i]));
      }
    }
    for (int f = 0; f < tree->n_frames(); ++f)
      frame_offset[f] = inverse(in_joint[tree->frame_body[f]]) * tree.frame_offset[f];
    axode::each_joint(tree, [&](const auto& joint, int i, bool) {
      for (int k = 0; k < joint.nv; ++k) X[tree->first_screw[i] + k] = Ad_inv(in_joint[i], joint.column(k));
    });
    sort_joints(tree->joint_groups, in_joint);
  }
  FramedTree(const FramedTree&) = delete;
  FramedTree& operator=(const FramedTree&) = delete;
  const Topology* operator->() const { return tree_.operator->(); }

  /// The list of the joints that have one velocity, constants of their own and the same kind as the argument.
  template <class Tree> static auto& own(Tree& tree, const subgroup::Revolute<T>&) { return tree.revolute; }
  template <class Tree> static auto& own(Tree& tree, const subgroup::Helical<T>&) { return tree.helical; }
  template <class Tree> static auto& own(Tree& tree, const subgroup::Prismatic<T>&) { return tree.prismatic; }

 private:
  /// The poses of the body frames Frames in the joint frames.
  static std::vector<SE3<T>> offsets(const Tree<T>& tree) {
    std::vector<SE3<T>> D(static_cast<std::size_t>(tree->n + 1)), C(D);
    for (int i = 1; i <= tree->n; ++i) {
      C[i] = C[tree->parent[i]] * tree.B[i];
      if constexpr (central)
        D[i].r = tree.M[i].m > T(0) ? center_of_mass(tree.M[i]) : Vec3<T>{};
      else if constexpr (std::same_as<Frames, UserFrames>)
        D[i] = tree.frame_offset[i];
      else
        D[i] = inverse(C[i]);
    }
    return D;
  }
  /// Whether joint screws are the same in the body frame, whose pose in the joint frame is D.
  static bool keeps_its_joint(Subgroup kind, const SE3<T>& D) {
    const Vec3<T> x = D.R.x - Vec3<T>{T(1), T(0), T(0)}, y = D.R.y - Vec3<T>{T(0), T(1), T(0)};
    const bool at_joint = !(dot(x, x) + dot(y, y) + dot(D.r, D.r) > T(0));
    return at_joint || (central && kind == Subgroup::prismatic);
  }
  /// Splits each group of joints into those that stay the same and those that get constants of their own.
  void sort_joints(const std::vector<JointGroup>& before, const std::vector<SE3<T>>& in_joint) {
    joint_groups.clear();
    for (const JointGroup& group : before) {
      const auto begin = by_kind.begin() + group.begin, end = by_kind.begin() + group.end;
      const auto middle =
          std::stable_partition(begin, end, [&](int i) { return keeps_its_joint(group.kind, in_joint[i]); });
      const int split = static_cast<int>(middle - by_kind.begin());
      if (begin != middle) add_group({group.kind, group.coupled, group.begin, split}, -1);
      if (middle == end) continue;
      std::ptrdiff_t first = 0;
      with_subgroup(group.kind, T(1), [&](const auto& joint) {
        if constexpr (std::remove_cvref_t<decltype(joint)>::nv == 1) {
          auto& joints = own(*this, joint);
          first = std::ssize(joints);
          for (auto i = middle; i != end; ++i) joints.emplace_back(L[*i], in_joint[*i], pitch[*i]);
        }
      });
      add_group({group.kind, group.coupled, split, group.end}, first);
    }
  }
  void add_group(const JointGroup& group, std::ptrdiff_t first) {
    joint_groups.push_back(group);
    at.push_back(first);
  }
};

/// Calls f(joint, i, coupled) for every joint, kind by kind; the coupled joints come last.
template <class T, class Frames, class F>
constexpr void each_joint(const FramedTree<T, Frames>& tree, F&& f) {
  for (std::size_t r = 0; r < tree.joint_groups.size(); ++r) {
    const JointGroup& group = tree.joint_groups[r];
    const auto over = [&](const auto& joint_of) {
      for (int k = group.begin; k < group.end; ++k) f(joint_of(k), tree.by_kind[k], group.coupled);
    };
    const auto stored = [&](const auto& joints) {
      over([&](int k) -> const auto& {
        return joints[static_cast<std::size_t>(tree.at[r] + k - group.begin)];
      });
    };
    if (tree.at[r] < 0 && group.kind == Subgroup::helical)
      over([&](int k) { return subgroup::Helical<T>{tree.pitch[tree.by_kind[k]]}; });
    else if (tree.at[r] < 0)
      with_subgroup(group.kind, T(0),
                    [&](const auto& joint) { over([&](int) -> const auto& { return joint; }); });
    else
      with_subgroup(group.kind, T(1), [&]<class Joint>(const Joint& joint) {
        if constexpr (Joint::nv == 1)
          stored(tree.own(tree, joint));
        else
          over([&](int k) {
            const int i = tree.by_kind[k];
            return framed::Conjugated<Joint, T, framed::Offset<Frames, T>>{tree.L[i], tree.D[i],
                                                                           &tree.X[tree->first_screw[i]]};
          });
      });
  }
}

}  // namespace axode
