#include "axode/io/drawing/construction_frame.hpp"

#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>

#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::io {
namespace {

constexpr double noise = 1e-15;

/// Returns `a` with 0 instead of components that are rounding noise of numbers of the magnitude `scale`.
Vec3<> clean(const Vec3<>& a, double scale) {
  const auto each = [&](double x) { return std::abs(x) < noise * scale ? 0.0 : x; };
  return {each(a.x), each(a.y), each(a.z)};
}
Sym3<> clean(const Sym3<>& A) {
  const double scale = std::abs(trace(A));
  const Vec3<> diagonal = clean(Vec3<>{A.xx, A.yy, A.zz}, scale),
               products = clean(Vec3<>{A.xy, A.xz, A.yz}, scale);
  return {diagonal.x, diagonal.y, diagonal.z, products.x, products.y, products.z};
}
Vec3<> clean_direction(const Vec3<>& a) {
  const auto each = [&](double x) { return 1 - std::abs(x) < noise ? std::copysign(1.0, x) : x; };
  const Vec3<> b = clean(a, 1);
  return {each(b.x), each(b.y), each(b.z)};
}
SE3<> clean(const SE3<>& C) {
  return {{clean_direction(C.R.x), clean_direction(C.R.y), clean_direction(C.R.z)}, clean(C.r, norm(C.r))};
}

bool same(const SO3<>& a, const SO3<>& b) {
  return norm(a.x - b.x) <= 10 * noise && norm(a.y - b.y) <= 10 * noise && norm(a.z - b.z) <= 10 * noise;
}

/// The pose, in the body frame, of the frame in which axis and point of the body's joint are given, for a
/// body that is not described in the construction frame (the inertial frame at q = 0). If `geometry` gives
/// the joint frames of this joint, it is the joint frame on the body; otherwise it is the body frame.
SE3<> given_frame(const Geometry& geometry) {
  const auto* frames = std::get_if<InJointFrames>(&geometry);
  return frames == nullptr ? SE3<>{} : frames->S_self;
}

/// Expresses the axis and the point of a joint in the inertial frame at q = 0. They imply the axes of the
/// joint frame: those of the inertial frame, turned the shortest way until z is the axis of the joint, if it
/// has one. If it matters where these axes point and the joint frame has other axes at q = 0, the joint is
/// expressed by joint frames instead. `at` has the poses of the body and its joint frame at q = 0.
void move_joint(BodyDescription& body, const Placement& at) {
  JointDescription& joint = body.joint;
  if (is_at_body_frame(joint.kind)) {
    joint.axis = {0, 0, 1};
    joint.point = {};
    body.geometry = InConstructionFrame{clean(at.A)};
    return;
  }
  const SE3<> given = at.A * given_frame(body.geometry);
  const Vec3<> point = given * joint.point;
  const Vec3<> axis = given.R * joint.axis;
  if (has_oriented_frame(joint.kind)) {
    const SO3<> by_rule = traits(joint.kind).has("axis") ? rotation_to((1 / norm(axis)) * axis) : SO3<>{};
    if (!same(at.A.R * at.S_self.R, by_rule)) {
      if (std::holds_alternative<InJointFrames>(body.geometry)) return;
      body.geometry = InJointFrames{clean(at.B * at.S_self), clean(at.S_self)};
      joint.axis = {0, 0, 1};
      joint.point = {};
      return;
    }
  }
  joint.point = clean(point, norm(joint.point) + norm(given.r));
  joint.axis = norm(axis) * clean_direction((1 / norm(axis)) * axis);
  joint.second_axis = clean(given.R * joint.second_axis, norm(joint.second_axis));
  body.geometry = InConstructionFrame{clean(at.A)};
}

/// Expresses the centre of mass of a body, and its inertia about this point, in the inertial frame at q = 0,
/// where the body frame has the pose A.
void move_inertia(MassProperties& given, const SE3<>& A) {
  if (given.in == GivenIn::construction_frame) return;
  given.in = GivenIn::construction_frame;
  if (given.about == InertiaAbout::frame_origin && given.mass > 0) {
    const Inertia<> M{given.mass, given.mass * given.com, rotate(given.axes, given.Theta)};
    given.Theta = inertia_about_com(M);
    given.axes = {};
  }
  given.about = InertiaAbout::center_of_mass;
  given.Theta = clean(rotate(A.R * given.axes, given.Theta));
  given.axes = {};
  given.com = clean(A * given.com, norm(given.com) + norm(A.r));
}

}  // namespace

Description in_construction_frame(const Description& description) {
  const auto placements = [](const Description& d) {
    const Description expanded = expand(d);
    const std::vector<Placement> all = reference_placements(expanded, depth_first_order(expanded));
    std::unordered_map<std::string, Placement> by_name;
    for (std::size_t k = 0; k < all.size(); ++k) by_name.emplace(expanded.bodies[k].name, all[k]);
    return by_name;
  };
  Description result = description;
  const auto given = placements(description);
  for (BodyDescription& body : result.bodies) {
    const Placement& at = given.at(body.name);
    if (auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) {
      drawn->A = clean(drawn->A);
    } else {
      move_joint(body, at);
    }
    const bool drawn = std::holds_alternative<InConstructionFrame>(body.geometry);
    if (body.inertia && drawn) move_inertia(*body.inertia, at.A);
  }
  for (FrameDescription& frame : result.frames) {
    const bool drawn = frame.in == GivenIn::construction_frame || frame.body == "ground";
    frame.in = GivenIn::construction_frame;
    frame.pose = clean(drawn ? frame.pose : given.at(frame.body).A * frame.pose);
  }
  const auto moved = placements(result);  // the poses as a reader will compute them, with rotations to
                                          // working precision
  for (BodyDescription& body : result.bodies)
    if (auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) drawn->A = moved.at(body.name).A;
  return result;
}

}  // namespace axode::io
