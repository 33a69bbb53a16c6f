#include "axode/constraints/local_mobility/walks.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "axode/kinematics/path.hpp"
#include "axode/model/configuration.hpp"
#include "axode/scalar/index.hpp"

namespace axode::higher_order {
namespace {

/// The screws of a loop joint in the frame of the joint, for kinds whose free motions form a subgroup.
std::vector<Screw<>> subgroup_screws(const Loop& loop) {
  const std::array<bool, 6>& free = traits(loop.kind).free;
  std::vector<Screw<>> found;
  for (std::size_t k = 0; k < 6; ++k) {
    if (!free[k]) continue;
    Screw<> S{{double(k == 0), double(k == 1), double(k == 2)},
              {double(k == 3), double(k == 4), double(k == 5)}};
    S.v.z += S.w.z * loop.pitch;
    found.push_back(S);
  }
  return found;
}

Screw<> rotation_about(const Vec3<>& axis, const Vec3<>& point) { return {axis, cross(point, axis)}; }

/// Names for the coordinates of a loop joint: `name` for one coordinate, otherwise name[0], name[1], ...
std::vector<std::string> numbered(const std::string& name, std::size_t count) {
  if (count == 1) return {name};
  std::vector<std::string> names(count, name);
  for (std::size_t k = 0; k < count; ++k) names[k].append("[").append(std::to_string(k)).append("]");
  return names;
}

class Walker {
 public:
  Walker(const Model& model, std::span<const double> q0) : model_(model), tree_(model.tree<double>()) {
    C_.resize(static_cast<std::size_t>(tree_->n) + 1);
    for (int i = 1; i <= tree_->n; ++i) at(i) = at(tree_->parent[i]) * joint_pose(tree_, i, q0.data());
    coordinate_.assign(static_cast<std::size_t>(tree_->nv), -1);
  }

  Walks run() {
    const Loops& loops = model_.loops();
    for (const Loop& loop : loops.joints) mark(loop);
    for (const LoopCoupling& coupling : loops.couplings)
      for (const LoopCoupling::Term& term : coupling.terms) coordinate_[index(term.velocity)] = 0;
    number_velocities();
    for (const Loop& loop : loops.joints) add(loop);
    const auto n = static_cast<Eigen::Index>(out_.coordinates.size());
    out_.couplings.setZero(static_cast<Eigen::Index>(loops.couplings.size()), n);
    for (std::size_t k = 0; k < loops.couplings.size(); ++k)
      for (const LoopCoupling::Term& term : loops.couplings[k].terms)
        out_.couplings(static_cast<Eigen::Index>(k), coordinate_[index(term.velocity)]) += term.factor;
    return std::move(out_);
  }

 private:
  SE3<>& at(int i) { return C_[index(i)]; }

  /// The joints on the path from a body (included) to the body `meeting` (not included).
  std::vector<int> path(int body, int meeting) const {
    std::vector<int> found;
    for (int i = body; i != meeting; i = tree_->parent[i]) found.push_back(i);
    return found;
  }
  int meeting(const Loop& loop) const {
    return common_predecessor(tree_, loop.ends[0].body, loop.ends[1].body);
  }

  /// Sets the entry in coordinate_ of each joint velocity in the loop to 0, which marks it as a coordinate
  /// of the closure equations. Velocities that are in no loop have the entry -1.
  void mark(const Loop& loop) {
    for (const Loop::End& end : loop.ends)
      for (const int i : path(end.body, meeting(loop)))
        each_screw(tree_, i, at(i), [&](int c, const Screw<>&) { coordinate_[index(c)] = 0; });
  }

  /// Makes a coordinate of the closure equations for each joint velocity in a loop or coupling. Its entry in
  /// coordinate_, until now only a mark 0, receives the index of the coordinate. The indices of all other
  /// velocities, with the entry -1, are collected in `outside`.
  void number_velocities() {
    const std::vector<std::string> names = velocity_names(model_);
    std::vector<char> angular(names.size(), 0);
    for (int i = 1; i <= tree_->n; ++i) {
      if (tree_->coupled[i]) continue;
      with_joint(tree_, i, [&](const auto& joint) {
        for (int k = 0; k < joint.angles; ++k) angular[index(tree_->iv[i] + k)] = 1;
      });
    }
    for (int c = 0; c < tree_->nv; ++c) {
      if (coordinate_[index(c)] < 0) {
        out_.outside.push_back(c);
        continue;
      }
      coordinate_[index(c)] = static_cast<int>(out_.coordinates.size());
      out_.coordinates.push_back({names[index(c)], c, angular[index(c)] != 0});
    }
  }

  PassedJoint passed(int i, bool backwards) {
    PassedJoint joint;
    each_screw(tree_, i, at(i), [&](int c, const Screw<>& S) {
      joint.S.push_back(backwards ? -S : S);
      joint.coordinates.push_back(coordinate_[index(c)]);
    });
    if (tree_->kind[i] != Subgroup::prismatic) out_.centers.push_back(at(i).r);
    return joint;
  }

  /// Makes a part of a loop joint from its screws, and adds a coordinate for each of them.
  PassedJoint own(std::vector<Screw<>> screws, const std::vector<std::string>& names) {
    PassedJoint joint{std::move(screws), {}};
    for (std::size_t k = 0; k < joint.S.size(); ++k) {
      joint.coordinates.push_back(static_cast<int>(out_.coordinates.size()));
      out_.coordinates.push_back({names[k], -1, dot(joint.S[k].w, joint.S[k].w) > 0});
    }
    return joint;
  }

  /// Makes the parts of a loop joint in their order from its first to its second body. Throws
  /// std::invalid_argument if it is not made of subgroups, as a rolling contact is not.
  std::vector<PassedJoint> joint_of(const Loop& loop) {
    const std::array<SE3<>, 2> F{at(loop.ends[0].body) * loop.ends[0].F,
                                 at(loop.ends[1].body) * loop.ends[1].F};
    if (traits(loop.kind).located) out_.centers.push_back(F[1].r);
    if (loop.kind == LoopKind::universal)
      return {own({rotation_about(F[0].R.z, F[1].r)}, {loop.name + ".first"}),
              own({rotation_about(F[1].R.z, F[1].r)}, {loop.name + ".second"})};
    if (loop.kind == LoopKind::rod) {
      out_.centers.push_back(F[0].r);
      const SO3<> R = rotation_to((1 / norm(F[1].r - F[0].r)) * (F[1].r - F[0].r));
      return {own({rotation_about(R.x, F[0].r), rotation_about(R.y, F[0].r), rotation_about(R.z, F[0].r)},
                  numbered(loop.name + ".first", 3)),
              own({rotation_about(R.x, F[1].r)}, {loop.name + ".second[0]"}),
              own({rotation_about(R.y, F[1].r)}, {loop.name + ".second[1]"})};
    }
    const LoopTraits& kind = traits(loop.kind);
    if (kind.rows + std::ranges::count(kind.free, true) != 6)
      throw std::invalid_argument("loop \"" + loop.name + "\" is of kind \"" + std::string(kind.name) +
                                  "\", which no product of exponentials describes; remove it to find the "
                                  "mobility of the others");
    std::vector<Screw<>> screws = subgroup_screws(loop);
    for (Screw<>& S : screws) S = Ad(F[1], S);
    if (loop.kind == LoopKind::cylindrical)
      return {own(std::move(screws), {loop.name + ".rotation", loop.name + ".translation"})};
    const std::vector<std::string> names = numbered(loop.name, screws.size());
    return {own(std::move(screws), names)};
  }

  void add(const Loop& loop) {
    std::vector<PassedJoint> joints;
    const std::vector<int> up = path(loop.ends[0].body, meeting(loop)),
                           down = path(loop.ends[1].body, meeting(loop));
    for (auto i = up.rbegin(); i != up.rend(); ++i) joints.push_back(passed(*i, false));
    for (PassedJoint& joint : joint_of(loop)) joints.push_back(std::move(joint));
    for (const int i : down) joints.push_back(passed(i, true));
    out_.loops.push_back(std::move(joints));
  }

  const Model& model_;
  const Tree<double>& tree_;
  std::vector<SE3<>> C_;         ///< poses of the joint frames at q0
  std::vector<int> coordinate_;  ///< index of the coordinate of each velocity; -1 outside all loops
  Walks out_;
};

}  // namespace

Walks walks(const Model& model, std::span<const double> q0) { return Walker(model, q0).run(); }

}  // namespace axode::higher_order
