#include "axode/model/building/placement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "axode/model/kinds/joint_kinds.hpp"

namespace axode {
namespace {

/// Splits a joint that is a chain in two. Returns a new massless body, whose joint makes the first motion;
/// the joint of `body` makes the second motion.
BodyDescription split_off(BodyDescription& body, const JointChain& chain) {
  const std::string name = joint_name(body) + ".";
  BodyDescription between{.name = name + std::string(chain.carrier),
                          .predecessor = body.predecessor,
                          .joint = body.joint,
                          .geometry = body.geometry,
                          .source = body.source};
  between.joint.name = name + std::string(chain.first_name);
  between.joint.kind = chain.first;
  body.predecessor = between.name;
  if (traits(body.joint.kind).has("second_axis")) body.joint.axis = body.joint.second_axis;
  body.joint.name = name + std::string(chain.second_name);
  body.joint.kind = chain.second;
  if (body.joint.dof.size() == 2) {
    between.joint.dof = {body.joint.dof[0]};
    body.joint.dof = {body.joint.dof[1]};
  }
  if (std::holds_alternative<InBodyFrame>(body.geometry)) body.geometry = InBodyFrame{};
  if (auto* joint_frames = std::get_if<InJointFrames>(&body.geometry))
    joint_frames->S_prev = joint_frames->S_self;
  return between;
}

/// Corrects a rotation matrix that is orthonormal to 1e-6, so that it is orthonormal to working precision.
SO3<> orthonormal(const SO3<>& R) {
  const SO3<> G = transpose(R) * R;
  const double off = abs(G.x.x - 1) + abs(G.y.y - 1) + abs(G.z.z - 1) + abs(G.x.y) + abs(G.x.z) + abs(G.y.z);
  return off > 1e-14 ? rotation(quaternion(R)) : R;
}
/// The pose of the joint frame in the frame in which axis and point of the joint are given.
SE3<> joint_frame(const JointDescription& joint) {
  if (!traits(joint.kind).has("axis")) return {{}, joint.point};
  return {orthonormal(rotation_to(direction(joint.axis))), joint.point};
}

/// The centre of mass (m) and the radius of gyration (m) of a body that is described in the construction
/// frame, which is the inertial frame at q = 0. The centre of mass is in this frame.
struct DrawnMass {
  Vec3<> center;
  double radius_of_gyration = 0;
};
std::optional<DrawnMass> drawn_mass(const BodyDescription& body) {
  if (!is_drawn(body) || !body.inertia || !(body.inertia->mass > 0)) return std::nullopt;
  const MassProperties& given = *body.inertia;
  const SE3<> A = given.in == GivenIn::construction_frame
                      ? SE3<>{}
                      : orthonormal(std::get<InConstructionFrame>(body.geometry).A);
  const double about_origin = given.about == InertiaAbout::frame_origin ? dot(given.com, given.com) : 0;
  return DrawnMass{A * given.com,
                   std::sqrt(std::max(0.0, trace(given.Theta) / (2 * given.mass) - about_origin))};
}
/// For each body the centre of mass and radius of gyration of this body or, if it has no mass, of its first
/// descendant with mass. A body that is not described in the construction frame, the inertial frame at q = 0,
/// counts as a body without mass.
std::vector<std::optional<DrawnMass>> first_masses(const Description& expanded,
                                                   const DepthFirstOrder& order) {
  std::vector<std::optional<DrawnMass>> first(expanded.bodies.size());
  for (auto i = order.order.rbegin(); i != order.order.rend(); ++i) {
    if (const std::optional<DrawnMass> own = drawn_mass(expanded.bodies[*i])) first[*i] = own;
    if (const int p = order.predecessor[*i]; p >= 0 && first[*i]) first[p] = first[*i];
  }
  return first;
}
/// The largest distance of the frame of a prismatic joint from the centre of mass of its body, in radii of
/// gyration. If it is larger, the frame is moved to the centre of mass, because rounding errors of the
/// inertia grow with the square of the distance.
constexpr double most_radii = 16;

/// Computes the poses of a body and its joint frame at q = 0 from those of its predecessor (null for the
/// ground). `mass` has the centre of mass and radius of gyration of the body or, if it has no mass, of its
/// first descendant with mass. If the body is described in the construction frame (the inertial frame at q =
/// 0), the frame of a prismatic joint has its origin at this centre of mass instead of the described point,
/// if the two are further apart than `most_radii` times the radius of gyration.
Placement reference_placement(const BodyDescription& body, const Placement* predecessor,
                              const std::optional<DrawnMass>& mass) {
  const SE3<> A_predecessor = predecessor == nullptr ? SE3<>{} : predecessor->A;
  SE3<> J = joint_frame(body.joint);
  if (body.joint.kind == JointKind::prismatic && is_drawn(body) && mass &&
      norm(mass->center - J.r) > most_radii * mass->radius_of_gyration)
    J.r = mass->center;
  const bool fixed = body.joint.kind == JointKind::fixed, at_body = is_at_body_frame(body.joint.kind);
  Placement at;
  if (const auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) {
    at.A = orthonormal(drawn->A);
    at.B = relative(A_predecessor, at.A);
    const bool of_predecessor = fixed && predecessor != nullptr, own = at_body && !of_predecessor;
    at.J = own ? at.A : of_predecessor ? predecessor->J : J;
    at.S_prev = relative(A_predecessor, at.J);
    at.S_self = own ? SE3<>{} : relative(at.A, at.J);
    return at;
  }
  if (const auto* in_body = std::get_if<InBodyFrame>(&body.geometry)) {
    at.B = orthonormal(in_body->B);
    at.S_self = at_body ? SE3<>{} : J;
    at.S_prev = at.B * at.S_self;
  } else {
    const auto& frames = std::get<InJointFrames>(body.geometry);
    const SE3<> S_prev = orthonormal(frames.S_prev), S_self = orthonormal(frames.S_self);
    at.B = S_prev * inverse(S_self);
    at.S_prev = fixed ? S_prev : at_body ? at.B : S_prev * J;
    at.S_self = fixed ? S_self : at_body ? SE3<>{} : S_self * J;
  }
  at.A = A_predecessor * at.B;
  at.J = at.A * at.S_self;
  return at;
}

}  // namespace

SE3<> orthonormal(const SE3<>& C) { return {orthonormal(C.R), C.r}; }

SE3<> relative(const SE3<>& A, const SE3<>& B) {
  const SO3<> Rt = transpose(A.R);
  return {Rt * B.R, Rt * (B.r - A.r)};
}

std::string joint_name(const BodyDescription& body) {
  return body.joint.name.empty() ? body.name + "_joint" : body.joint.name;
}

bool is_drawn(const BodyDescription& body) {
  return std::holds_alternative<InConstructionFrame>(body.geometry);
}

Vec3<> direction(const Vec3<>& axis) {
  const double largest =
      std::max({abs(axis.x), abs(axis.y), abs(axis.z)});  // so that no square leaves the range
  const Vec3<> a{axis.x / largest, axis.y / largest, axis.z / largest};
  return (1 / norm(a)) * a;
}

Description expand(const Description& description) {
  Description expanded = description;
  expanded.bodies.clear();
  for (BodyDescription body : description.bodies) {
    if (const auto& chain = traits(body.joint.kind).chain) expanded.bodies.push_back(split_off(body, *chain));
    body.joint.name = joint_name(body);
    expanded.bodies.push_back(std::move(body));
  }
  return expanded;
}

DepthFirstOrder depth_first_order(const Description& description) {
  const int n = static_cast<int>(description.bodies.size());
  std::unordered_map<std::string, int> index;
  for (int i = 0; i < n; ++i) index.emplace(description.bodies[i].name, i);

  DepthFirstOrder result;
  result.predecessor.assign(n, -1);
  std::vector<std::vector<int>> children(n + 1);  // the last entry is the ground
  for (int i = 0; i < n; ++i) {
    const std::string& predecessor = description.bodies[i].predecessor;
    if (predecessor == "ground") {
      children[n].push_back(i);
    } else if (const auto found = index.find(predecessor); found != index.end()) {
      result.predecessor[i] = found->second;
      children[found->second].push_back(i);
    }
  }
  std::vector<int> open(children[n].rbegin(), children[n].rend());
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    result.order.push_back(i);
    open.insert(open.end(), children[i].rbegin(), children[i].rend());
  }
  return result;
}

std::vector<Placement> reference_placements(const Description& expanded, const DepthFirstOrder& order) {
  std::vector<Placement> placements(expanded.bodies.size());
  const std::vector<std::optional<DrawnMass>> masses = first_masses(expanded, order);
  for (const int i : order.order) {
    const int p = order.predecessor[i];
    placements[i] = reference_placement(expanded.bodies[i], p < 0 ? nullptr : &placements[p], masses[i]);
  }
  return placements;
}

DrawnLoop drawn_loop(const LoopDescription& loop) {
  const auto frame = [](const Vec3<>& axis, const Vec3<>& point) {
    return SE3<>{orthonormal(rotation_to(direction(axis))), point};
  };
  const LoopTraits& kind = traits(loop.kind);
  if (kind.has("radii")) return {{frame(loop.axis, loop.points[0]), frame(loop.axis, loop.points[1])}};
  if (kind.has("points"))
    return {{SE3<>{{}, loop.points[0]}, SE3<>{{}, loop.points[1]}},
            loop.length.value_or(norm(loop.points[1] - loop.points[0]))};
  if (kind.has("second_axis")) {
    const double cosine = dot(direction(loop.axis), direction(loop.second_axis));
    return {{frame(loop.axis, loop.point), frame(loop.second_axis, loop.point)},
            loop.angle ? std::cos(*loop.angle) : cosine};
  }
  if (kind.has("center")) {
    const Vec3<> n = direction(loop.axis), up = loop.center - loop.point;
    const double height = dot(n, up);
    const Vec3<> k = direction(loop.wheel_axis.value_or(Vec3<>{0, 0, 1}));
    const double sine = loop.wheel_axis ? norm(cross(n, k)) : 1;
    return {{frame(height < 0 ? -n : n, loop.point), frame(k, loop.center)},
            loop.radius.value_or(std::abs(height) / sine)};
  }
  const SE3<> C = kind.has("axis") ? frame(loop.axis, loop.point) : SE3<>{{}, loop.point};
  return {{C, C}};
}

double size_of(const LoopDescription& loop) {
  const LoopTraits& kind = traits(loop.kind);
  if (kind.has("length")) return loop.length.value_or(0);
  if (kind.has("radius")) return loop.radius.value_or(0);
  return kind.has("angle") ? std::cos(loop.angle.value_or(std::numbers::pi / 2)) : 0;
}

std::string loop_name(const LoopDescription& loop, std::size_t k) {
  return loop.name.empty() ? "loop " + std::to_string(k + 1) : loop.name;
}
std::string spring_name(const SpringDescription& spring, std::size_t k) {
  return spring.name.empty() ? "spring " + std::to_string(k + 1) : spring.name;
}
std::string spring_element(const SpringDescription& spring, std::size_t k) {
  return spring.name.empty() ? spring_name(spring, k) : "spring \"" + spring.name + '"';
}
std::string motion_name(const MotionDescription& motion) {
  return motion.name.empty() ? "motion of " + motion.of : motion.name;
}
std::string drive_name(const DriveDescription& drive, std::size_t k) {
  return drive.name.empty() ? "drive " + std::to_string(k + 1) : drive.name;
}
std::string coupling_name(const CouplingDescription& coupling, std::size_t k) {
  return coupling.name.empty() ? "coupling " + std::to_string(k + 1) : coupling.name;
}

Inertia<> inertia_in(const SE3<>& F, const MassProperties& given) {
  const SO3<> axes = orthonormal(given.axes), Rt = transpose(F.R);
  return given.about == InertiaAbout::center_of_mass
             ? inertia_from_com(given.mass, Rt * (given.com - F.r), given.Theta, Rt * axes)
             : transform(inverse(F),
                         Inertia<>{given.mass, given.mass * given.com, rotate(axes, given.Theta)});
}

Inertia<> inertia_in(const SE3<>& J, const SE3<>& A, const MassProperties& given) {
  if (given.about == InertiaAbout::frame_origin) return inertia_in(relative(A, J), given);
  const SO3<> axes = orthonormal(given.axes), Rt = transpose(J.R);
  return inertia_from_com(given.mass, Rt * ((A.r - J.r) + A.R * given.com), given.Theta, Rt * A.R * axes);
}

MassProperties expressed_in(const SE3<>& S, const MassProperties& given) {
  MassProperties result = given;
  const SO3<> axes = orthonormal(given.axes), Rt = transpose(S.R);
  if (given.about == InertiaAbout::center_of_mass) {
    result.com = Rt * (given.com - S.r);
    result.axes = Rt * axes;
  } else {
    const Inertia<> M = inertia_in(S, given);
    result.com = M.m > 0 ? center_of_mass(M) : Vec3<>{};
    result.Theta = M.Theta;
    result.axes = {};
  }
  result.in = GivenIn::body_frame;
  return result;
}

Description in_joint_frames(const Description& given) {
  Description description = expand(given);
  const std::vector<Placement> placements = reference_placements(description, depth_first_order(description));
  std::unordered_map<std::string_view, SE3<>> A;
  for (std::size_t d = 0; d < description.bodies.size(); ++d) {
    BodyDescription& body = description.bodies[d];
    const Placement& at = placements[d];
    A.emplace(body.name, at.A);
    if (body.inertia && body.inertia->in == GivenIn::construction_frame)
      body.inertia = expressed_in(at.A, *body.inertia);
    body.geometry = InJointFrames{at.S_prev, at.S_self};
    if (body.joint.kind != JointKind::fixed) {
      body.joint.axis = {0, 0, 1};
      body.joint.point = {0, 0, 0};
    }
  }
  for (FrameDescription& frame : description.frames) {
    if (frame.in == GivenIn::construction_frame && frame.body != "ground")
      frame.pose = relative(A.at(frame.body), frame.pose);
    frame.in = GivenIn::body_frame;
    A.emplace(frame.name, (frame.body == "ground" ? SE3<>{} : A.at(frame.body)) * orthonormal(frame.pose));
  }
  A.emplace("ground", SE3<>{});
  for (SpringDescription& spring : description.springs) {
    if (spring.in == GivenIn::construction_frame) {
      for (SpringDescription::Point& it : spring.path) it.point = relative(A.at(it.on), {{}, it.point}).r;
      if (traits(spring.kind).has("between"))
        for (std::size_t k = 0; k < 2; ++k) {
          const SE3<>& on = A.at(spring.between[k]);
          spring.points[k] = relative(on, {{}, spring.points[k]}).r;
          spring.frames[k] = relative(on, orthonormal(spring.frames[k]));
        }
    }
    spring.in = GivenIn::body_frame;
  }
  for (DriveDescription& drive : description.drives) {
    if (!drive.line) continue;
    if (drive.line->in == GivenIn::construction_frame)
      for (std::size_t k = 0; k < 2; ++k)
        drive.line->points[k] = relative(A.at(drive.line->between[k]), {{}, drive.line->points[k]}).r;
    drive.line->in = GivenIn::body_frame;
  }
  for (LoopDescription& loop : description.loops) {
    if (loop.frames) continue;
    const auto [C, size] = drawn_loop(loop);
    loop.frames = {relative(A.at(loop.between[0]), C[0]), relative(A.at(loop.between[1]), C[1])};
    const LoopTraits& kind = traits(loop.kind);
    if (kind.has("length")) loop.length = size;
    if (kind.has("radius")) loop.radius = size;
    if (kind.has("angle")) loop.angle = std::acos(size);
  }
  return description;
}

void leave_out_state(Description& description, const std::unordered_set<std::string>& joints,
                     const char* why) {
  if (!description.state) return;
  std::set<std::string> left_out;
  const auto leave_out = [&](const std::pair<std::string, std::vector<double>>& entry) {
    if (!joints.contains(entry.first)) return false;
    left_out.insert(entry.first);
    return true;
  };
  std::erase_if(description.state->q, leave_out);
  std::erase_if(description.state->v, leave_out);
  for (const std::string& joint : left_out)
    description.warnings.push_back({Severity::warning, Rule::wrong_value, "state",
                                    "the initial state of joint \"" + joint + "\" " + why,
                                    description.state->source});
}

}  // namespace axode
