#include "axode/view/points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>

#include "axode/eigen.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::view {
namespace {

using Described = std::unordered_map<std::string_view, const BodyDescription*>;

Described described_bodies(const Model& model) {
  Described described;
  for (const BodyDescription& body : model.description().bodies) described.emplace(body.name, &body);
  return described;
}

const BodyDescription* find(const Described& described, const std::string& name) {
  const auto found = described.find(name);
  return found == described.end() ? nullptr : found->second;
}

/// Whether the origin of a body frame is one of the points between which the body is drawn. It is not if the
/// axis and point of the body's joint are given in the inertial frame at q = 0, because the body frame may
/// then be far from the body.
bool has_origin(const BodyDescription& body) {
  return !std::holds_alternative<InConstructionFrame>(body.geometry);
}

/// Whether the description gives a point for a joint. If the body is described in the inertial frame at q =
/// 0, a prismatic joint has a direction only, and a free joint has neither direction nor point.
bool has_point(const Joint& joint, const BodyDescription* body) {
  if (joint.kind != Subgroup::prismatic && joint.kind != Subgroup::free) return true;
  return body == nullptr || has_origin(*body) || traits(body->joint.kind).has("point");
}

/// The length of the diagonal of a box around points, m.
double diagonal(const std::vector<Vec3<>>& points) {
  Eigen::AlignedBox3d box;
  for (const Vec3<>& point : points) box.extend(to_eigen(point));
  return points.empty() ? 0 : box.diagonal().norm();
}

/// Returns the points or, if there are many, only those that lie farthest in one of many directions. The
/// viewer computes the convex hull of these points, which would take long for many of them.
std::vector<Vec3<>> corners(const std::vector<Vec3<>>& points) {
  constexpr int directions = 60;
  if (points.size() <= directions) return points;
  std::vector<Vec3<>> found;
  for (int k = 0; k < directions; ++k) {  // a Fibonacci lattice on the sphere
    const double z = 1 - (2 * k + 1.0) / directions, r = std::sqrt(1 - z * z), angle = k * 2.399963229728653;
    const Vec3<> n{r * std::cos(angle), r * std::sin(angle), z};
    found.push_back(*std::ranges::max_element(points, {}, [&](const Vec3<>& p) { return dot(n, p); }));
  }
  return found;
}

}  // namespace

Points::Points(const Model& model)
    : joints_(static_cast<std::size_t>(model.n_bodies()) + 1),
      all_(joints_.size()),
      lengths_(joints_.size()) {
  const Described described = described_bodies(model);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    if (!has_point(model.joint(i), find(described, body.name))) continue;
    joints_[i] = body.S_self.r;
    all_[i].push_back(body.S_self.r);
    all_[body.predecessor].push_back(body.S_prev.r);
  }
  for (const Frame& frame : model.frames().subspan(joints_.size())) {
    // A fixed body has a frame with its own name.
    const BodyDescription* fixed = find(described, frame.name);
    if (fixed == nullptr || has_origin(*fixed)) all_[frame.body].push_back(frame.pose.r);
  }
  for (const Loop& loop : model.loops().joints)
    if (traits(loop.kind).located)
      for (const Loop::End& end : loop.ends)
        all_[end.body].push_back((model.body(end.body).S_self * end.F).r);
  for_line_ends(model, [&](int body, const Vec3<>& point) { all_[body].push_back(point); });
  add_fixed_bodies(model);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    lengths_[i] = diagonal(all_[i]);
    const Inertia<>& M = model.body(i).M;
    if (M.m > 0 && !all_[i].empty())
      lengths_[i] = std::max(lengths_[i], 2 * norm(center_of_mass(M) - all_[i].front()));
  }
  for (int i = 0; i <= model.n_bodies(); ++i)
    for (const Vec3<>& point : all_[i]) reference_.push_back(model.body(i).A * point);
  size_ = std::ranges::max(lengths_);
  for (const auto& [name, points] : fixed_) size_ = std::max(size_, diagonal(points));
  for (const std::vector<Vec3<>>& points : all_) distinct_.push_back(distinct(points));
}

void Points::add_fixed_bodies(const Model& model) {
  const Described described = described_bodies(model);
  std::unordered_map<std::string_view, SE3<>> poses;  // of the bodies that are fixed to the ground
  for (const Frame& frame : model.frames().subspan(joints_.size()))
    if (frame.body == 0 && find(described, frame.name) != nullptr) poses.emplace(frame.name, frame.pose);
  for (const BodyDescription& body : model.description().bodies) {
    const auto pose = poses.find(body.name);
    if (pose == poses.end()) continue;
    if (has_origin(body)) {
      fixed_[body.name].push_back(pose->second.r);
      if (poses.contains(body.predecessor)) fixed_[body.predecessor].push_back(pose->second.r);
    }
    if (!body.inertia || body.inertia->mass == 0) continue;
    const Vec3<>& com = body.inertia->com;
    fixed_[body.name].push_back(body.inertia->in == GivenIn::body_frame ? pose->second * com : com);
  }
  for (int i = 1; i <= model.n_bodies(); ++i) {
    if (model.body(i).predecessor != 0 || !joints_[i] || model.joint(i).kind == Subgroup::free) continue;
    // A joint of several axes has bodies in between that no description names; they come before their last
    // one.
    int last = i;
    while (find(described, model.body(last).name) == nullptr && last < model.n_bodies()) ++last;
    const BodyDescription* body = find(described, model.body(last).name);
    if (body != nullptr && poses.contains(body->predecessor))
      fixed_[body->predecessor].push_back(model.body(i).S_prev.r);
  }
}

double Points::lowest(const Vec3<>& up) const {
  double height = INFINITY;
  for (const Vec3<>& point : reference_) height = std::min(height, dot(up, point));
  return height;
}

std::vector<Vec3<>> Points::distinct(const std::vector<Vec3<>>& all) const {
  std::vector<Vec3<>> points;
  for (const Vec3<>& point : corners(all))
    if (std::ranges::none_of(points, [&](const Vec3<>& p) { return norm(p - point) <= 0.01 * size_; }))
      points.push_back(point);
  return points;
}

}  // namespace axode::view
