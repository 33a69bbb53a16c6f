#include "axode/view/stand_ins.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "axode/eigen.hpp"
#include "axode/model/joint_kinds.hpp"

namespace axode::view {
namespace {

/// Points on each body, the ground included, in the frame of the body.
struct Places {
  std::vector<std::optional<Vec3<>>> joint;  ///< point of the joint of the body itself
  std::vector<std::vector<Vec3<>>> carried;  ///< points of other joints, frames and loops on the body
  double size = 0;                           ///< largest distance (m) of a point in `carried` from the joint
};

/// Whether a joint has a point that its description gives. A prismatic joint in a drawing has a direction
/// only, and a free joint has neither.
bool has_place(const Joint& joint, const BodyDescription* body) {
  if (joint.kind != Subgroup::prismatic && joint.kind != Subgroup::free) return true;
  return body == nullptr || !std::holds_alternative<InConstructionFrame>(body->geometry) ||
         traits(body->joint.kind).point;
}

Places places_of(const Model& model) {
  std::unordered_map<std::string_view, const BodyDescription*> described;
  for (const BodyDescription& body : model.description().bodies) described.emplace(body.name, &body);
  const auto description_of = [&](const std::string& name) {
    const auto found = described.find(name);
    return found == described.end() ? nullptr : found->second;
  };
  const auto n = static_cast<std::size_t>(model.n_bodies());
  Places places{std::vector<std::optional<Vec3<>>>(n + 1), std::vector<std::vector<Vec3<>>>(n + 1)};
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    if (!has_place(model.joint(i), description_of(body.name))) continue;
    places.joint[i] = body.S_self.r;
    places.carried[body.predecessor].push_back(body.S_prev.r);
  }
  for (const Frame& frame : model.frames().subspan(n + 1)) {
    // A fixed body has a frame of its own name. If the body is drawn, the origin of this frame means nothing.
    const BodyDescription* fixed = description_of(frame.name);
    if (fixed == nullptr || !std::holds_alternative<InConstructionFrame>(fixed->geometry))
      places.carried[frame.body].push_back(frame.pose.r);
  }
  for (const Loop& loop : model.loops().joints)
    if (traits(loop.kind).located)
      for (const Loop::End& end : loop.ends)
        places.carried[end.body].push_back((model.body(end.body).S_self * end.F).r);
  for (std::size_t i = 1; i <= n; ++i)
    for (const Vec3<>& place : places.carried[i])
      if (places.joint[i]) places.size = std::max(places.size, norm(place - *places.joint[i]));
  return places;
}

/// A capsule from one point to another, with a radius of a sixth of its length, but at most `thickest`.
ShapeDescription capsule(const Vec3<>& from, const Vec3<>& to, double thickest) {
  ShapeDescription shape{.kind = ShapeKind::capsule, .length = norm(to - from)};
  shape.pose = {rotation_to((1 / shape.length) * (to - from)), 0.5 * (from + to)};
  shape.radius = std::min(shape.length / 6, thickest);
  return shape;
}

/// The solid ellipsoid with the mass and inertia M: its second moments are m a²/5 for the semi-axes a. The
/// result is empty for a point mass.
std::vector<ShapeDescription> ellipsoid(const Inertia<>& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(to_eigen(binet_tensor(inertia_about_com(M))));
  Eigen::Matrix3d axes = moments.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Eigen::Array3d semi_axes = (5 / M.m * moments.eigenvalues().array()).max(0).sqrt();
  if (!(semi_axes[2] > 0)) return {};
  const double thinnest = 0.02 * semi_axes[2];  // so that a sheet and a wire are visible
  ShapeDescription shape{.kind = ShapeKind::ellipsoid, .pose = {from_eigen<SO3<>>(axes), center_of_mass(M)}};
  shape.size = from_eigen<Vec3<>>(semi_axes.max(thinnest).matrix());
  return {shape};
}

}  // namespace

std::vector<std::vector<ShapeDescription>> stand_ins(const Model& model) {
  const Places places = places_of(model);
  std::vector<std::vector<ShapeDescription>> all;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Inertia<>& M = model.body(i).M;
    const bool has_mass = M.m > 0;
    std::vector<ShapeDescription>& shapes = all.emplace_back();
    if (places.joint[i] || has_mass) {
      const Vec3<> from = places.joint[i] ? *places.joint[i] : center_of_mass(M);
      for (const Vec3<>& to : places.carried[i])
        if (norm(to - from) > 0.01 * places.size) shapes.push_back(capsule(from, to, 0.03 * places.size));
    }
    if (shapes.empty() && has_mass) shapes = ellipsoid(M);
  }
  return all;
}

}  // namespace axode::view
