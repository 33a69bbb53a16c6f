#include "axode/view/stand_ins.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "axode/eigen.hpp"
#include "axode/view/joint_parts.hpp"
#include "axode/view/levels.hpp"
#include "axode/view/points.hpp"

namespace axode::view {
namespace {

using Color = std::array<double, 4>;
constexpr Color driven{0.88, 0.54, 0.12, 1}, passive{0.31, 0.36, 0.42, 1};

/// The radius of bars as a fraction of the size of the mechanism.
constexpr double thickness = 0.03;

/// A capsule from one point to another, with a radius of a sixth of its length, but at most `thickest`.
ShapeDescription capsule(const Vec3<>& from, const Vec3<>& to, double thickest) {
  ShapeDescription shape{.kind = ShapeKind::capsule, .length = norm(to - from)};
  shape.pose = {rotation_to((1 / shape.length) * (to - from)), 0.5 * (from + to)};
  shape.radius = std::min(shape.length / 6, thickest);
  return shape;
}

/// The convex hull of balls about points, in a frame at their mean.
StandIn hull(int body, std::vector<Vec3<>> points, double radius) {
  Vec3<> mean{};
  for (const Vec3<>& point : points) mean = mean + 1.0 / static_cast<double>(points.size()) * point;
  for (Vec3<>& point : points) point = point - mean;
  return {body, {.pose = {{}, mean}, .radius = radius}, StandIn::Form::hull, std::move(points)};
}

/// The two points between which all others lie; empty if they are not in one line.
std::optional<std::array<Vec3<>, 2>> ends_of_line(const std::vector<Vec3<>>& points, double close) {
  const auto farthest = [&](const Vec3<>& from) {
    return *std::ranges::max_element(points, {}, [&](const Vec3<>& p) { return norm(p - from); });
  };
  const Vec3<> a = farthest(points.front()), b = farthest(a), e = (1 / norm(b - a)) * (b - a);
  const auto in_line = [&](const Vec3<>& p) { return norm(p - a - dot(e, p - a) * e) <= close; };
  if (!std::ranges::all_of(points, in_line)) return std::nullopt;
  return std::array{a, b};
}

/// A bar or a plate between at least two points.
StandIn between(int body, const std::vector<Vec3<>>& points, double radius, double close) {
  if (const auto line = ends_of_line(points, close)) return {body, capsule((*line)[0], (*line)[1], radius)};
  return hull(body, points, radius);
}

/// A solid that has the mass and inertia M of a body: a cylinder if exactly two principal moments are equal,
/// otherwise an ellipsoid. Empty for a point mass.
std::optional<ShapeDescription> solid(const Inertia<>& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(to_eigen(binet_tensor(inertia_about_com(M))));
  Eigen::Matrix3d axes = moments.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Eigen::Array3d second =
      (moments.eigenvalues().array() / M.m).max(0);  // second moments of x, y and z,
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

/// Makes a solid, whose size was computed from the inertia of a body, smaller if it reaches farther than
/// `most` (m) from its centre. This can happen if the inertia is wrong or contains the rotors of drives.
void shrink(ShapeDescription& shape, double most) {
  const bool round = shape.kind == ShapeKind::cylinder;
  const Vec3<>& a = shape.size;
  const double reach = round ? std::max(shape.radius, shape.length / 2) : std::max({a.x, a.y, a.z});
  const double factor = std::min(1.0, most / reach);
  shape.size = factor * shape.size;
  shape.radius *= factor;
  shape.length *= factor;
}

/// Whether a body is a rod along the line through its centre of mass and a point.
bool is_rod(const Inertia<>& M, const Vec3<>& point) {
  const Vec3<> to_com = center_of_mass(M) - point, e = (1 / norm(to_com)) * to_com;
  const Sym3<> Theta = inertia_about_com(M);
  const double along = dot(e, Theta * e);
  return along < 0.3 * (Theta.xx + Theta.yy + Theta.zz - along) / 2;
}

/// The kind of joint of the tree as which a loop joint is drawn. Empty for a rolling contact, for a belt, and
/// for a fixed, prismatic or translational loop joint: where such a loop joint is on its bodies has no
/// influence on the motion.
std::optional<Subgroup> like_joint(LoopKind kind) {
  const LoopTraits& loop = traits(kind);
  if (!loop.located || loop.has("center") || loop.has("radii")) return std::nullopt;
  if (loop.has("points") || loop.free[0]) return Subgroup::spherical;
  return loop.free[3] ? Subgroup::planar : Subgroup::revolute;
}

/// Draws the bodies and joints of a model one after the other.
class Draughtsman {
 public:
  Draughtsman(const Model& model, const std::vector<bool>& seen);

  void draw_body(int i);
  void draw_joint(int i);
  void draw_loop(const Loop& loop);
  void draw_line_end(int body, const Vec3<>& point);
  void draw_ground();

  std::vector<StandIn> drawn;

 private:
  bool seen(int i) const { return seen_[i]; }
  void put(StandIn part, const Vec3<>& offset = {});
  void add_mount(const Vec3<>& middle);
  void add_rail(int i);
  JointSide side(int body, const SE3<>& pose) const;
  DrawnJoint joint_between(Subgroup kind, JointSide a, JointSide b, bool is_passive) const;
  /// How far the middle of a mount is below the point that it holds, m.
  double mount_depth() const { return 2.2 * radii_[0]; }
  /// How far a body is drawn from its points, in its frame.
  Vec3<> offset(int i) const;

  const Model& model_;
  const std::vector<bool>& seen_;
  const Points points_;
  const Vec3<> up_;
  std::optional<Levels> levels_;
  std::vector<double> radii_;   ///< of the bars of the bodies, m
  std::vector<bool> rolls_;     ///< whether a body is a wheel or a ball that rolls
  std::vector<Vec3<>> mounts_;  ///< points on the ground that need a mount
  double step_ = 0;             ///< distance between levels, m
};

Vec3<> upward(const Model& model) {
  const Vec3<> g = model.gravity();
  return norm(g) > 0 ? (-1 / norm(g)) * g : Vec3<>{0, 0, 1};
}

Draughtsman::Draughtsman(const Model& model, const std::vector<bool>& seen)
    : model_(model),
      seen_(seen),
      points_(model),
      up_(upward(model)),
      levels_(levels_of(model, 0.01 * points_.size(), up_)),
      radii_(seen.size(), thickness * points_.size()),
      rolls_(seen.size()) {
  std::vector<double> masses;
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (model.body(i).M.m > 0) masses.push_back(model.body(i).M.m);
  if (!masses.empty()) std::ranges::nth_element(masses, masses.begin() + std::ssize(masses) / 2);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const double m = model.body(i).M.m;
    const double heavy = m > 0 ? std::clamp(std::cbrt(m / masses[masses.size() / 2]), 0.6, 1.6) : 0.6;
    const double slim = model.joint(i).kind == Subgroup::prismatic ? 2.0 / 3 : 1;
    const double plate = points_.distinct(i).size() > 2 ? 0.8 : 1.6;
    radii_[i] = std::min(std::min(heavy * slim, plate) * radii_[i], points_.length(i) / 6);
  }
  step_ = 2.1 * std::ranges::max(radii_);
  for (const Loop& loop : model.loops().joints)
    if (traits(loop.kind).has("center"))
      for (const Loop::End& end : loop.ends) rolls_[end.body] = true;
}

void Draughtsman::put(StandIn part, const Vec3<>& offset) {
  part.shape.pose.r = part.shape.pose.r + offset;
  drawn.push_back(std::move(part));
}

Vec3<> Draughtsman::offset(int i) const {
  return levels_ ? (levels_->of[i] * step_) * (transpose(model_.body(i).A.R) * levels_->normal) : Vec3<>{};
}

void Draughtsman::draw_body(int i) {
  const Inertia<>& M = model_.body(i).M;
  const double size = points_.size(), radius = radii_[i];
  const std::vector<Vec3<>>& own = points_.distinct(i);
  if (own.size() > 1) {
    put(between(i, own, radius, 0.01 * size), offset(i));
  } else if (M.m > 0) {
    const bool has_arm = !own.empty() && norm(center_of_mass(M) - own[0]) > 0.01 * size;
    if (has_arm && is_rod(M, own[0])) {
      put({i, capsule(own[0], 2.0 * center_of_mass(M) - own[0], radius)}, offset(i));
      return;
    }
    if (has_arm) put({i, capsule(own[0], center_of_mass(M), radius)}, offset(i));
    if (std::optional<ShapeDescription> body = solid(M)) {
      if (size > 0 && !rolls_[i]) shrink(*body, 0.125 * size);
      put({i, *body}, offset(i));
    }
  }
}

JointSide Draughtsman::side(int body, const SE3<>& pose) const {
  JointSide side{.body = body, .pose = pose, .drawn = !seen(body)};
  if (levels_) {
    const Vec3<> axis = body == 0 ? pose.R.z : model_.body(body).A.R * pose.R.z;
    side.height = levels_->of[body] * step_ * (dot(axis, levels_->normal) < 0 ? -1 : 1);
  }
  if (body == 0) {
    side.radius = thickness * points_.size();
    return side;
  }
  side.radius = radii_[body];
  const std::vector<Vec3<>>& own = points_.distinct(body);
  const Inertia<>& M = model_.body(body).M;
  side.drawn = side.drawn && (own.size() > 1 || M.m > 0);
  Vec3<> middle = own.size() < 2 && M.m > 0 ? center_of_mass(M) : pose.r;
  for (const Vec3<>& point : own)
    if (own.size() > 1) middle = middle + 1.0 / static_cast<double>(own.size()) * (point - pose.r);
  const Vec3<> rest = transpose(pose.R) * (middle - pose.r);
  if (norm(rest) > 0.01 * points_.size()) side.towards = (1 / norm(rest)) * rest;
  return side;
}

DrawnJoint Draughtsman::joint_between(Subgroup kind, JointSide a, JointSide b, bool is_passive) const {
  const double length = std::max(points_.length(a.body), points_.length(b.body));
  return {.kind = kind,
          .radius = std::min(thickness * points_.size(), length / 8),
          .color = is_passive ? passive : driven,
          .sides = {std::move(a), std::move(b)}};
}

void Draughtsman::draw_joint(int i) {
  const Body& body = model_.body(i);
  const Joint& joint = model_.joint(i);
  if (points_.size() == 0 || joint.kind == Subgroup::free) return;
  if (joint.kind == Subgroup::prismatic && !seen(i) && !points_.joint(i)) add_rail(i);
  const bool shown = seen(i) && (seen(body.predecessor) || body.predecessor == 0);
  if (shown || !points_.joint(i)) return;
  DrawnJoint drawn_joint =
      joint_between(joint.kind, side(body.predecessor, body.S_prev), side(i, body.S_self), joint.passive);
  drawn_joint.pitch = joint.pitch;
  for (StandIn& part : parts_of(drawn_joint)) put(std::move(part));
  if (body.predecessor == 0) mounts_.push_back(body.S_prev.r);
}

void Draughtsman::draw_loop(const Loop& loop) {
  const std::optional<Subgroup> kind = like_joint(loop.kind);
  if (!kind || points_.size() == 0) return;
  const auto side_of = [&](const Loop::End& end) {
    return side(end.body, model_.body(end.body).S_self * end.F);
  };
  JointSide a = side_of(loop.ends[0]), b = side_of(loop.ends[1]);
  for (const bool second : {false, true}) {
    const JointSide &own = second ? b : a, &other = second ? a : b;
    if (own.body == 0 && !seen(other.body)) mounts_.push_back(own.pose.r);
  }
  if (loop.kind == LoopKind::rod) {  // a ball at either end
    for (const JointSide& end : {a, b}) {
      if (end.body == 0 || seen(end.body)) continue;
      JointSide rod = end;
      rod.drawn = false;
      for (StandIn& part : parts_of(joint_between(*kind, rod, end, true))) put(std::move(part));
    }
    return;
  }
  if (b.body == 0) std::swap(a, b);
  if (seen(a.body) && seen(b.body)) return;
  for (StandIn& part : parts_of(joint_between(*kind, a, b, true))) put(std::move(part));
}

/// Draws the rail on which body i slides, as a part of its predecessor, through the centre of mass of body i,
/// with the parts that hold the rail. The rail ends at the limits of the joint. Without limits it extends to
/// both sides by the length of the mechanism or, on a moving predecessor, by half the length of the
/// predecessor.
void Draughtsman::add_rail(int i) {
  const Body& body = model_.body(i);
  if (body.predecessor != 0 && seen(body.predecessor)) return;
  const double size = body.predecessor == 0 ? points_.size() : 0.5 * points_.length(body.predecessor);
  if (size == 0) return;
  const Vec3<> center = body.M.m > 0 ? center_of_mass(body.M) : body.S_self.r, at = body.B * center,
               e = body.S_prev.R.z;
  const Dof& dof = model_.joint(i).dof[0];
  const double lower = std::isfinite(dof.lower) ? std::max(dof.lower, -3 * size) : -size,
               upper = std::isfinite(dof.upper) ? std::min(dof.upper, 3 * size) : size;
  if (upper - lower < 0.01 * size) return;
  const double thickest = 0.02 * points_.size();
  const std::array ends{at + lower * e, at + upper * e};
  put({body.predecessor, capsule(ends[0], ends[1], thickest)});
  if (seen(body.predecessor)) return;
  if (body.predecessor == 0) {
    const bool upright = std::abs(dot(up_, e)) > 0.9;
    const Vec3<> lowest = dot(up_, ends[0]) < dot(up_, ends[1]) ? ends[0] : ends[1];
    for (const Vec3<>& end : ends) {
      if (upright && norm(end - lowest) > 0) continue;
      put({0, capsule(end, end - mount_depth() * up_, thickest)});
      mounts_.push_back(end);
    }
    return;
  }
  const auto is_on_rail = [&](const Vec3<>& p) {
    return norm(p - ends[0] - std::clamp(dot(e, p - ends[0]), 0.0, upper - lower) * e) <= 2 * thickest;
  };
  const std::vector<Vec3<>>& own = points_.distinct(body.predecessor);
  const Inertia<>& M = model_.body(body.predecessor).M;
  if (std::ranges::any_of(own, is_on_rail) || M.m == 0) return;
  const Vec3<> com = center_of_mass(M), middle = 0.5 * (ends[0] + ends[1]);
  if (!is_on_rail(com)) put({body.predecessor, capsule(middle, com, thickest)});
}

/// What holds the end of a spring or a drive: a pin that reaches from the body to the plane of the points.
void Draughtsman::draw_line_end(int body, const Vec3<>& point) {
  if (body == 0) mounts_.push_back(point);
  const double reach = norm(offset(body));
  if (seen(body) || reach == 0) return;
  const Vec3<> e = (1 / reach) * offset(body);
  ShapeDescription pin{.kind = ShapeKind::cylinder,
                       .pose = {rotation_to(e), point + 0.5 * (reach + radii_[body]) * e},
                       .color = passive};
  pin.length = reach + 2 * radii_[body];
  pin.radius = 0.4 * radii_[0];
  put({body, std::move(pin)});
}

/// The bodies that are fixed to the ground, and mounts under what is on none of them.
void Draughtsman::draw_ground() {
  if (seen(0) || points_.size() == 0) return;
  const double close = 0.01 * points_.size(), r = radii_[0], lowest = points_.lowest(up_);
  std::vector<Vec3<>> held;  // points on fixed bodies that are drawn, and points that have a mount
  for (const auto& [name, all] : points_.fixed()) {
    const std::vector<Vec3<>> own = points_.distinct(all);
    if (own.size() < 2) continue;
    put(between(0, own, r, close));
    held.insert(held.end(), all.begin(), all.end());
    const Vec3<> foot = *std::ranges::min_element(own, {}, [&](const Vec3<>& p) { return dot(up_, p); });
    if (dot(up_, foot) <= lowest + close) add_mount(foot - r * up_);
  }
  std::vector<Vec3<>> feet;
  for (const Vec3<>& point : mounts_) {
    if (std::ranges::any_of(held, [&](const Vec3<>& p) { return norm(p - point) <= close; })) continue;
    held.push_back(point);
    feet.push_back(point - mount_depth() * up_);
    add_mount(feet.back());
  }
  // Mounts at the same height are on one plate or bar.
  const auto is_level = [&](const Vec3<>& p) { return std::abs(dot(up_, p - feet[0])) <= close; };
  if (feet.size() > 1 && std::ranges::all_of(feet, is_level)) put(between(0, feet, 0.8 * r, close));
}

/// A mount is a block with its middle at a point.
void Draughtsman::add_mount(const Vec3<>& middle) {
  const double r = radii_[0];
  ShapeDescription mount{.pose = {rotation_to(up_), middle}};
  mount.size = {7 * r, 7 * r, 1.6 * r};
  put({0, std::move(mount)});
}

/// For each body, whether it needs no placeholder. This is so if it has shapes, and for the massless body
/// inside a cylindrical joint between two bodies with shapes, because the point of such a joint may be
/// anywhere on its axis, far from both bodies.
std::vector<bool> complete(const Model& model, const std::vector<bool>& seen) {
  std::vector<bool> out = seen;
  std::vector<int> successors(seen.size());
  for (int i = 1; i <= model.n_bodies(); ++i)
    ++successors[static_cast<std::size_t>(model.body(i).predecessor)];
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const int between = model.body(i).predecessor;
    if (!seen[i] || model.joint(i).kind != Subgroup::prismatic || between == 0 || successors[between] > 1)
      continue;
    const int before = model.body(between).predecessor;
    const bool is_inside = model.body(between).M.m == 0 && model.joint(between).kind == Subgroup::revolute;
    if (is_inside && (before == 0 || seen[before])) out[between] = true;
  }
  return out;
}

}  // namespace

std::vector<StandIn> stand_ins(const Model& model, const std::vector<bool>& with_shapes) {
  const std::vector<bool> seen = complete(model, with_shapes);
  Draughtsman draughtsman(model, seen);
  for (int i = 1; i <= model.n_bodies(); ++i) {
    if (!seen[i]) draughtsman.draw_body(i);
    draughtsman.draw_joint(i);
  }
  for (const Loop& loop : model.loops().joints) draughtsman.draw_loop(loop);
  Points::for_line_ends(model,
                        [&](int body, const Vec3<>& point) { draughtsman.draw_line_end(body, point); });
  draughtsman.draw_ground();
  return std::move(draughtsman.drawn);
}

}  // namespace axode::view
