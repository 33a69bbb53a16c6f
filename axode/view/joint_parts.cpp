#include "axode/view/joint_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace axode::view {
namespace {

/// A cylinder about the axis of a joint, with its middle at a height above the point of the joint.
StandIn disc(const JointSide& side, double height, double radius, double length) {
  ShapeDescription shape{.kind = ShapeKind::cylinder,
                         .pose = {side.pose.R, side.pose * Vec3<>{0, 0, height}}};
  shape.radius = radius;
  shape.length = length;
  return {side.body, std::move(shape)};
}

StandIn block(const JointSide& side, double height, const Vec3<>& size) {
  ShapeDescription shape{.pose = {side.pose.R, side.pose * Vec3<>{0, 0, height}}};
  shape.size = size;
  return {side.body, std::move(shape)};
}

StandIn colored(StandIn part, const DrawnJoint& joint) {
  part.shape.color = joint.color;
  return part;
}

/// The radius of the eyes of a hinge, such that they can be seen beside the bars.
double eye(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  return std::max({1.4 * joint.radius, 1.2 * a.radius, 1.2 * b.radius});
}

/// Eyes of both bodies, one above the other, and a pin through both.
std::vector<StandIn> stacked_hinge(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  const double R = eye(joint), beyond = 0.5 * joint.radius;
  const double low = std::min(a.height - a.radius, b.height - b.radius);
  const double high = std::max(a.height + a.radius, b.height + b.radius);
  std::vector<StandIn> parts;
  for (const JointSide& side : joint.sides)
    if (side.drawn) parts.push_back(disc(side, side.height, R, 2.04 * side.radius));
  parts.push_back(colored(disc(b, (low + high) / 2, 0.6 * R, high - low + 2 * beyond), joint));
  return parts;
}

/// Makes a hinge that looks like a fork: the body has a tongue between two cheeks of the predecessor, and a
/// pin goes through all three. If the body continues along the axis on one side, the cheek on this side is
/// left out.
std::vector<StandIn> forked_hinge(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  const double r = joint.radius, R = eye(joint);
  std::vector<StandIn> parts;
  if (b.drawn) parts.push_back(disc(b, 0, R, 1.5 * r));
  for (const double side : {-1.0, 1.0})
    if (a.drawn && side * b.towards.z < 0.8) parts.push_back(disc(a, 1.15 * side * r, R, 0.6 * r));
  const bool cross = !a.drawn || !b.drawn;          // one body is a point in which the pins of a cross meet
  const bool collar = std::abs(b.towards.z) > 0.8;  // the pin would be inside the body
  if (cross) {
    parts.push_back(colored(disc(b, 0, 0.5 * r, 3.2 * r), joint));
  } else if (collar) {
    parts.push_back(colored(disc(b, 0, 1.1 * R, 0.5 * r), joint));
  } else {
    parts.push_back(colored(disc(b, 0, 0.6 * R, 3.4 * r), joint));
  }
  return parts;
}

std::vector<StandIn> thread(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  const double r = joint.radius;
  StandIn screw = colored(disc(b, 0, 0.9 * r, 6 * r), joint);
  screw.form = StandIn::Form::thread;
  const double lead = 2 * std::numbers::pi * joint.pitch;
  screw.lead = std::copysign(std::clamp(std::abs(lead), 0.9 * r, 4 * r), lead);  // so that it can be seen
  std::vector<StandIn> parts{std::move(screw)};
  if (a.drawn) parts.push_back(block(a, 0, {2.8 * r, 2.8 * r, 1.8 * r}));
  return parts;
}

std::vector<StandIn> ball(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  StandIn ball = colored({b.body, {.kind = ShapeKind::sphere, .pose = b.pose}}, joint);
  ball.shape.radius = 1.35 * joint.radius;
  std::vector<StandIn> parts{std::move(ball)};
  if (!a.drawn) return parts;
  const Vec3<> open = norm(b.towards) > 0 ? b.towards : Vec3<>{0, 0, 1};
  StandIn socket{a.body, {.kind = ShapeKind::sphere, .pose = a.pose * SE3<>{rotation_to(-open), {}}}};
  socket.form = StandIn::Form::socket;
  socket.shape.radius = 1.7 * joint.radius;
  parts.push_back(std::move(socket));
  return parts;
}

}  // namespace

std::vector<StandIn> parts_of(const DrawnJoint& joint) {
  const auto& [a, b] = joint.sides;
  const double r = joint.radius;
  switch (joint.kind) {
    case Subgroup::revolute: return a.height == b.height ? forked_hinge(joint) : stacked_hinge(joint);
    case Subgroup::helical: return thread(joint);
    case Subgroup::spherical: return ball(joint);
    case Subgroup::planar: {
      std::vector<StandIn> parts{colored(block(b, 0, {6 * r, 6 * r, r}), joint)};
      if (a.drawn) parts.push_back(block(a, -0.75 * r, {10 * r, 10 * r, 0.5 * r}));
      return parts;
    }
    case Subgroup::prismatic: return {colored(block(b, 0, {3.2 * r, 3.2 * r, 7 * r}), joint)};
    default: return {};
  }
}

}  // namespace axode::view
