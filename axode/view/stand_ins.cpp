#include "axode/view/stand_ins.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_map>

#include "axode/eigen.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::view {
namespace {

using Color = std::array<double, 4>;
constexpr Color driven{0.88, 0.54, 0.12, 1}, passive{0.31, 0.36, 0.42, 1};

/// The points on each body and on the ground between which it is drawn, in the frame of the body.
class Points {
 public:
  explicit Points(const Model& model);

  /// The point of the joint of body i in the frame of body i; empty if the joint has no point.
  const std::optional<Vec3<>>& joint(int i) const { return joints_[i]; }
  /// The corners() of the points on a body, without points that are nearer to another one than size()/100.
  std::vector<Vec3<>> distinct(int body) const;
  /// The size of the largest body, m. The size of a body is the diagonal of the box around its points, or
  /// twice the distance of its first point from the centre of mass if that is larger.
  double size() const { return size_; }

 private:
  std::vector<std::optional<Vec3<>>> joints_;
  std::vector<std::vector<Vec3<>>> all_;
  double size_ = 0;
};

/// Whether a joint has a position, unlike free joints and prismatic joints drawn in the inertial frame.
bool has_point(const Joint& joint, const BodyDescription* body) {
  if (joint.kind != Subgroup::prismatic && joint.kind != Subgroup::free) return true;
  return body == nullptr || !std::holds_alternative<InConstructionFrame>(body->geometry) ||
         traits(body->joint.kind).point;
}

/// Calls f(body, point) for each point of a spring that runs along points, and for both ends of each line
/// along which a drive acts. The point is in the frame of the body.
template <class F> void for_line_ends(const Model& model, const F& f) {
  const auto visit = [&](const Spring::Path& path) {
    for (const Spring::Path::Point& it : path.points) {
      const Frame& frame = model.frame(it.frame);
      f(frame.body, frame.pose * it.point);
    }
  };
  for (const Spring& spring : model.springs().elements)
    if (const auto* path = std::get_if<Spring::Path>(&spring.geometry)) visit(*path);
  for (const Spring::Path& line : model.springs().drive_lines) visit(line);
}

Points::Points(const Model& model)
    : joints_(static_cast<std::size_t>(model.n_bodies()) + 1), all_(joints_.size()) {
  std::unordered_map<std::string_view, const BodyDescription*> described;
  for (const BodyDescription& body : model.description().bodies) described.emplace(body.name, &body);
  const auto description_of = [&](const std::string& name) {
    const auto found = described.find(name);
    return found == described.end() ? nullptr : found->second;
  };
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    if (!has_point(model.joint(i), description_of(body.name))) continue;
    joints_[i] = body.S_self.r;
    all_[i].push_back(body.S_self.r);
    all_[body.predecessor].push_back(body.S_prev.r);
  }
  for (const Frame& frame : model.frames().subspan(joints_.size())) {
    // A body that is fixed to another one has a frame with its own name. If the body is drawn in the
    // construction frame, the origin of this frame need not be on the body and is not used.
    const BodyDescription* fixed = description_of(frame.name);
    if (fixed == nullptr || !std::holds_alternative<InConstructionFrame>(fixed->geometry))
      all_[frame.body].push_back(frame.pose.r);
  }
  for (const Loop& loop : model.loops().joints)
    if (traits(loop.kind).located)
      for (const Loop::End& end : loop.ends)
        all_[end.body].push_back((model.body(end.body).S_self * end.F).r);
  for_line_ends(model, [&](int body, const Vec3<>& point) { all_[body].push_back(point); });
  for (int i = 1; i <= model.n_bodies(); ++i) {
    if (all_[i].empty()) continue;
    Eigen::AlignedBox3d box;
    for (const Vec3<>& point : all_[i]) box.extend(to_eigen(point));
    size_ = std::max(size_, box.diagonal().norm());
    const Inertia<>& M = model.body(i).M;
    if (M.m > 0) size_ = std::max(size_, 2 * norm(center_of_mass(M) - all_[i].front()));
  }
}

/// Returns at most 60 points: all if there are not more, otherwise those farthest in 60 directions.
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

std::vector<Vec3<>> Points::distinct(int body) const {
  std::vector<Vec3<>> points;
  for (const Vec3<>& point : corners(all_[body]))
    if (std::ranges::none_of(points, [&](const Vec3<>& p) { return norm(p - point) <= 0.01 * size_; }))
      points.push_back(point);
  return points;
}

/// A capsule from one point to another. Its radius is a sixth of its length, but at most `thickest`.
ShapeDescription capsule(const Vec3<>& from, const Vec3<>& to, double thickest) {
  ShapeDescription shape{.kind = ShapeKind::capsule, .length = norm(to - from)};
  shape.pose = {rotation_to((1 / shape.length) * (to - from)), 0.5 * (from + to)};
  shape.radius = std::min(shape.length / 6, thickest);
  return shape;
}

/// The convex hull of balls of the given radius about points in the body frame. The points are expressed in a
/// frame at their mean.
StandIn hull(int body, std::vector<Vec3<>> points, double radius) {
  Vec3<> mean{};
  for (const Vec3<>& point : points) mean = mean + 1.0 / static_cast<double>(points.size()) * point;
  for (Vec3<>& point : points) point = point - mean;
  return {body, {.pose = {{}, mean}, .radius = radius}, std::move(points)};
}

/// The homogeneous solid with the mass and inertia M of a body: a cylinder if exactly two principal moments
/// are equal, otherwise an ellipsoid. The result is empty for a point mass.
std::optional<ShapeDescription> solid(const Inertia<>& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(to_eigen(binet_tensor(inertia_about_com(M))));
  Eigen::Matrix3d axes = moments.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Eigen::Array3d second = (moments.eigenvalues().array() / M.m).max(0);  // mean squares of x, y and z,
                                                                               // m²
  ShapeDescription shape{.pose = {from_eigen<SO3<>>(axes), center_of_mass(M)}};
  if (!(second[2] > 0)) return std::nullopt;
  const auto equal = [&](int a, int b) { return second[b] - second[a] <= 1e-3 * second[2]; };
  if (equal(0, 1) == equal(1, 2)) {
    const double thinnest = 0.02 * std::sqrt(5 * second[2]);  // so that a sheet and a wire are visible
    shape.kind = ShapeKind::ellipsoid;
    shape.size = from_eigen<Vec3<>>((5 * second).sqrt().max(thinnest).matrix());
    return shape;
  }
  const int axis = equal(0, 1) ? 2 : 0;
  shape.kind = ShapeKind::cylinder;
  shape.pose.R = rotation_to(from_eigen<Vec3<>>(Eigen::Vector3d(axes.col(axis))));
  shape.radius = std::sqrt(std::max(4 * second[1], 1e-3 * second[2]));
  shape.length = std::sqrt(std::max(12 * second[axis], 1e-2 * second[2]));
  return shape;
}

/// Whether a body has the inertia of a rod along the line through its centre of mass and a point: the moment
/// of inertia about the line is less than 0.3 times that about axes normal to it.
bool is_rod(const Inertia<>& M, const Vec3<>& point) {
  const Vec3<> to_com = center_of_mass(M) - point, e = (1 / norm(to_com)) * to_com;
  const Sym3<> Theta = inertia_about_com(M);
  const double along = dot(e, Theta * e);
  return along < 0.3 * (Theta.xx + Theta.yy + Theta.zz - along) / 2;
}

/// Appends the placeholder shapes of body i to `all`.
void add_body(std::vector<StandIn>& all, const Model& model, int i, const Points& points) {
  const Inertia<>& M = model.body(i).M;
  const bool slides = model.joint(i).kind == Subgroup::prismatic;
  const double radius = (slides ? 0.02 : 0.03) * points.size();
  const std::vector<Vec3<>> own = points.distinct(i);
  if (own.size() > 2) {
    all.push_back(hull(i, own, radius));
  } else if (own.size() == 2) {
    all.push_back({i, capsule(own[0], own[1], radius)});
  } else if (M.m > 0) {
    const bool has_arm = !own.empty() && norm(center_of_mass(M) - own[0]) > 0.01 * points.size();
    if (has_arm && is_rod(M, own[0])) {
      all.push_back({i, capsule(own[0], 2.0 * center_of_mass(M) - own[0], radius)});
      return;
    }
    if (has_arm) all.push_back({i, capsule(own[0], center_of_mass(M), radius)});
    if (const std::optional<ShapeDescription> body = solid(M)) all.push_back({i, *body});
  }
}

/// The pin, ball, pad or sleeve of a joint. z of `pose` is the axis of the joint. Free joints are not drawn.
ShapeDescription joint_part(Subgroup kind, const SE3<>& pose, double radius, const Color& color) {
  ShapeDescription shape{.pose = pose, .color = color};
  if (kind == Subgroup::revolute || kind == Subgroup::helical) {
    shape.kind = ShapeKind::cylinder;
    shape.radius = 1.25 * radius;
    shape.length = 3 * radius;
  } else if (kind == Subgroup::spherical) {
    shape.kind = ShapeKind::sphere;
    shape.radius = 1.5 * radius;
  } else if (kind == Subgroup::planar) {
    shape.size = {6 * radius, 6 * radius, radius};
  } else if (kind == Subgroup::prismatic) {
    shape.size = {3.2 * radius, 3.2 * radius, 7 * radius};
  }
  return shape;
}

/// The rail of a body that slides on the ground. It runs through the centre of mass in the direction of the
/// joint, from the lower limit to the upper one; a missing limit is replaced by -size or size.
ShapeDescription rail(const Body& body, const Dof& dof, double size) {
  const Vec3<> center = body.M.m > 0 ? center_of_mass(body.M) : body.S_self.r, at = body.A * center,
               e = body.S_prev.R.z;
  const double lower = std::isfinite(dof.lower) ? dof.lower : -size,
               upper = std::isfinite(dof.upper) ? dof.upper : size;
  return capsule(at + lower * e, at + upper * e, 0.02 * size);
}

/// The kind of joint whose drawing a loop joint gets. Empty if it is not drawn: a rolling contact, or a loop
/// joint that constrains only directions.
std::optional<Subgroup> like_joint(LoopKind kind) {
  const LoopTraits& loop = traits(kind);
  if (!loop.located || loop.has("center")) return std::nullopt;
  if (loop.has("points") || loop.free[0]) return Subgroup::spherical;
  return loop.free[3] ? Subgroup::planar : Subgroup::revolute;
}

}  // namespace

std::vector<StandIn> stand_ins(const Model& model, const std::vector<bool>& seen) {
  const Points points(model);
  const double radius = 0.03 * points.size();
  std::vector<StandIn> all;
  const Vec3<> g = model.gravity();
  const Vec3<> up = norm(g) > 0 ? (-1 / norm(g)) * g : Vec3<>{0, 0, 1};
  const auto add_mount = [&](const Vec3<>& point) {
    ShapeDescription mount{.pose = {rotation_to(up), point - 2.4 * radius * up}};
    mount.size = {7 * radius, 7 * radius, 1.6 * radius};
    if (!seen[0]) all.push_back({0, mount});
  };
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    if (!seen[i]) add_body(all, model, i, points);
    const bool on_rail = body.predecessor == 0 && model.joint(i).kind == Subgroup::prismatic;
    if (on_rail && !seen[i] && !points.joint(i) && points.size() > 0)
      all.push_back({0, rail(body, model.joint(i).dof[0], points.size())});
    const bool shown = seen[i] && (seen[body.predecessor] || body.predecessor == 0);
    if (shown || !points.joint(i) || radius == 0) continue;
    const Joint& joint = model.joint(i);
    all.push_back({i, joint_part(joint.kind, body.S_self, radius, joint.passive ? passive : driven)});
    if (body.predecessor == 0) add_mount(body.S_prev.r);
  }
  for (const Loop& loop : model.loops().joints) {
    const std::optional<Subgroup> kind = like_joint(loop.kind);
    if (!kind || radius == 0) continue;
    for (const Loop::End& end : loop.ends) {
      const SE3<> pose = model.body(end.body).S_self * end.F;
      const Loop::End& other = loop.ends[&end == loop.ends.data() ? 1 : 0];
      if (end.body == 0 && !seen[other.body]) add_mount(pose.r);
      if (end.body != 0 && !seen[end.body])
        all.push_back({end.body, joint_part(*kind, pose, radius, passive)});
    }
  }
  for_line_ends(model, [&](int body, const Vec3<>& point) {
    if (body == 0 && radius > 0) add_mount(point);
  });
  return all;
}

}  // namespace axode::view
