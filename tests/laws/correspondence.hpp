#pragma once
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/laws/law.hpp"

/// Two models of one mechanism: which joint and which frame of the one is which of the other, by name.
namespace axode::test {

using NameOfOther = std::function<std::string(const std::string&)>;

class Correspondence {
 public:
  /// `name_in_b` says what a joint or frame of `a` is called in `b`. What `b` does not have has no
  /// counterpart.
  Correspondence(
      const Model& a, const Model& b, const NameOfOther& name_in_b = [](const std::string& s) { return s; })
      : a_(a), b_(b) {
    std::unordered_map<std::string, int> joints, frames;
    for (int i = 1; i <= b.n_bodies(); ++i) joints.emplace(b.joint(i).name, i);
    for (int f = 0; f < b.n_frames(); ++f) frames.emplace(b.frame(f).name, f);
    const auto find = [](const auto& map, const std::string& name) {
      const auto found = map.find(name);
      return found == map.end() ? -1 : found->second;
    };
    joint_.push_back(-1);
    for (const Joint& joint : a.joints()) joint_.push_back(find(joints, name_in_b(joint.name)));
    for (const Frame& frame : a.frames())
      frame_.push_back(frame.name == "ground" ? 0 : find(frames, name_in_b(frame.name)));
  }

  /// The joint or frame of `b`, or -1.
  int joint(int i) const { return joint_[static_cast<std::size_t>(i)]; }
  int frame(int f) const { return frame_[static_cast<std::size_t>(f)]; }

  /// The state of `a` as one of `b`: the same coordinates of each joint, the same components of each load.
  /// Joints of `b` without a counterpart stay neutral and at rest.
  State<double> carry(const State<double>& state) const {
    const std::size_t nv = static_cast<std::size_t>(b_.nv());
    State<double> out{neutral(b_), std::vector<double>(nv), std::vector<double>(nv)};
    each_joint([&](const Joint& in_a, const Joint& in_b) {
      for (int k = 0; k < in_a.nq; ++k) out.q[in_b.iq + k] = state.q[in_a.iq + k];
      for (int k = 0; k < in_a.nv; ++k)
        out.v[in_b.iv + k] = state.v[in_a.iv + k], out.a[in_b.iv + k] = state.a[in_a.iv + k];
    });
    out.wrenches = state.wrenches;
    for (AppliedWrench<>& load : out.wrenches) load.frame = frame(load.frame);
    return out;
  }

  /// Of generalised forces of `a` and of `b`, those of the joints that both have, in one order.
  template <class T>
  std::array<std::vector<T>, 2> common(const std::vector<T>& tau_a, const std::vector<T>& tau_b) const {
    std::array<std::vector<T>, 2> out;
    each_joint([&](const Joint& in_a, const Joint& in_b) {
      for (int k = 0; k < in_a.nv; ++k)
        out[0].push_back(tau_a[in_a.iv + k]), out[1].push_back(tau_b[in_b.iv + k]);
    });
    return out;
  }

 private:
  /// f(joint of a, joint of b) for those with coordinates of their own.
  template <class F> void each_joint(const F& f) const {
    for (int i = 1; i <= a_.n_bodies(); ++i)
      if (!a_.joint(i).leader && joint(i) > 0) f(a_.joint(i), b_.joint(joint(i)));
  }

  Model a_, b_;
  std::vector<int> joint_, frame_;
};

/// Loads in the spatial representation, in which they do not depend on where body frames are.
inline void make_loads_spatial(const Model& model, State<double>& state) {
  Trial<double> trial(model, state);
  const std::vector<SE3<>> C = trial.poses();
  for (AppliedWrench<>& load : state.wrenches)
    with_representation(load.representation, [&](auto rep) {
      const Wrench<decltype(rep)> W{load.m, load.f};
      load = AppliedWrench<>(load.frame, change<Spatial>(C[static_cast<std::size_t>(load.frame)], W));
    });
}

/// The displacement of a joint in its joint frame, and the coordinates of such a displacement.
inline SE3<> displacement(Subgroup kind, double pitch, const double* q) {
  return with_subgroup(kind, pitch, [&](const auto& joint) { return joint.pose(SE3<>{}, q); });
}
inline std::vector<double> coordinates(Subgroup kind, const SE3<>& D) {
  const Quaternion<> a = quaternion(D.R);
  if (kind == Subgroup::spherical) return {a.x, a.y, a.z, a.w};
  if (kind == Subgroup::planar) return {std::atan2(D.R.x.y, D.R.x.x), D.r.x, D.r.y};
  return {a.x, a.y, a.z, a.w, D.r.x, D.r.y, D.r.z};
}
/// S v, and the components Sᵀ X of a screw or wrench along the columns of S.
inline Screw<> joint_screw(Subgroup kind, double pitch, const double* v) {
  return with_subgroup(kind, pitch, [&](const auto& joint) { return screw(joint.twist(v)); });
}
inline std::vector<double> components(Subgroup kind, double pitch, const Screw<>& X) {
  return with_subgroup(kind, pitch, [&](const auto& joint) {
    const auto parts = joint.project(Wrench<BodyFixed>{X.w, X.v});
    return std::vector<double>(parts.begin(), parts.end());
  });
}

}  // namespace axode::test
