#include "tests/paper/systems.hpp"

#include "tests/support/random_tree.hpp"

namespace axode::test::paper {
namespace {

struct Plan {
  std::vector<int> predecessors;  ///< bodies are counted from 1, 0 is the ground
  std::vector<JointKind> kinds;   ///< the kinds of the joints; each seed begins at another place of this list
};

Plan plan(Topology topology) {
  using enum JointKind;
  switch (topology) {
    case Topology::chain:
      return {{0, 1, 2, 3, 4}, {revolute, prismatic, helical, revolute, helical, revolute}};
    case Topology::tree:
      return {{0, 1, 1, 2, 2, 3, 0, 7, 0},
              {revolute, helical, prismatic, revolute, revolute, helical, revolute}};
    case Topology::many_dof_joints: break;
  }
  return {{0, 1, 1, 2, 2, 3, 0, 7}, {free, spherical, revolute, planar, helical, spherical, free, prismatic}};
}

/// A body as the user drew it, at q = 0; points and poses are in the construction frame.
struct Draft {
  DrawnBody body;
  std::vector<PointMass> points;
  SO3<> inertia_axes, com_axes;
};

Draft draw(Random<double>& random, int number, int predecessor, JointKind kind) {
  Draft draft{.body = {.name = "body " + std::to_string(number), .joint = "joint " + std::to_string(number)},
              .points = {}};
  DrawnBody& body = draft.body;
  body.predecessor = predecessor - 1, body.kind = kind;
  body.A = random.pose(), body.J = kind == JointKind::free ? body.A : random.pose();
  if (kind == JointKind::helical) body.pitch = random.number(0.1, 0.4);
  const Vec3<> place = body.A * random.vector(0.5);
  for (int k = 0; k < 6; ++k) draft.points.push_back({random.number(0.2, 1), place + random.vector(0.4)});
  draft.inertia_axes = random.rotation(), draft.com_axes = random.rotation();
  return draft;
}

/// The mass, centre of mass and second moments of point masses, summed up and expressed in the frame F, the
/// pose of which is in the construction frame.
MassProperties sum(const std::vector<PointMass>& points, const SE3<>& F, GivenIn in, InertiaAbout about,
                   const SO3<>& axes) {
  MassProperties sums{.in = in, .about = about, .axes = axes};
  Vec3<> h;
  for (const PointMass& point : points) sums.mass += point.m, h += point.m * (inverse(F) * point.p);
  sums.com = (1 / sums.mass) * h;
  const SE3<> about_which{axes, about == InertiaAbout::center_of_mass ? sums.com : Vec3<>{}};
  for (const PointMass& point : points) {
    const Vec3<> p = inverse(about_which) * (inverse(F) * point.p);
    sums.Theta = sums.Theta + point.m * Sym3<>{p.y * p.y + p.z * p.z,
                                               p.x * p.x + p.z * p.z,
                                               p.x * p.x + p.y * p.y,
                                               -p.x * p.y,
                                               -p.x * p.z,
                                               -p.y * p.z};
  }
  return sums;
}

/// The description of the body for the library, with geometry and inertia in one of the possible ways.
BodyDescription tell(const Mechanism& mechanism, const Draft& draft, Way way, Random<double>& random) {
  BodyDescription description = described(mechanism, draft.body, way, random);
  const bool in_body = way != Way::body_frame, about_com = way != Way::joint_frames;
  description.inertia =
      sum(draft.points, in_body ? draft.body.A : SE3<>{},
          in_body ? GivenIn::body_frame : GivenIn::construction_frame,
          about_com ? InertiaAbout::center_of_mass : InertiaAbout::frame_origin, draft.inertia_axes);
  return description;
}

FrameDescription com_frame(const Draft& draft) {
  const Vec3<> com = sum(draft.points, {}, GivenIn::construction_frame, InertiaAbout::center_of_mass, {}).com;
  return {.name = draft.body.name + ".com",
          .body = draft.body.name,
          .pose = {draft.com_axes, com},
          .in = GivenIn::construction_frame};
}

/// The screw (e; p × e + h e), or (0; e) for a prismatic joint.
Screw<> joint_screw(JointKind kind, const Vec3<>& e, const Vec3<>& p, double h) {
  return kind == JointKind::prismatic ? Screw<>{{}, e} : screw(e, p, h);
}

Drawn drawn(const Draft& draft, const BodyDescription& description) {
  const DrawnBody& body = draft.body;
  Drawn drawn{
      .Y = joint_screw(body.kind, body.J.R.z, body.J.r, body.pitch), .joint_frames = {}, .points = {}};
  if (const auto* frames = std::get_if<InJointFrames>(&description.geometry)) {
    const JointDescription& joint = description.joint;
    const Vec3<> e = (1 / norm(joint.axis)) * joint.axis;
    drawn.joint_frames = {frames->S_prev, frames->S_self,
                          joint_screw(joint.kind, e, joint.point, joint.pitch)};
  }
  for (const PointMass& point : draft.points) drawn.points.push_back({point.m, inverse(body.A) * point.p});
  return drawn;
}

}  // namespace

std::string_view to_string(Topology topology) {
  switch (topology) {
    case Topology::chain: return "chain";
    case Topology::tree: return "tree";
    case Topology::many_dof_joints: break;
  }
  return "tree with many-DOF joints";
}

System make_system(Topology topology, std::uint64_t seed, BodyFrames frames) {
  const Plan plan = paper::plan(topology);
  Random<double> random(1 + seed), telling(1000 + seed);
  Mechanism mechanism{.gravity = random.vector(9.81), .bodies = {}};
  ModelBuilder builder(std::string(to_string(topology)) + ", seed " + std::to_string(seed));
  builder.gravity(mechanism.gravity);
  std::vector<Drawn> drawings;
  for (std::size_t b = 0; b < plan.predecessors.size(); ++b) {
    Draft draft = draw(random, static_cast<int>(b) + 1, plan.predecessors[b],
                       plan.kinds[(b + seed) % plan.kinds.size()]);
    Way way = static_cast<Way>((b + seed) % 3);
    if (frames == BodyFrames::at_the_construction_frame) draft.body.A = {}, way = Way::construction_frame;
    mechanism.bodies.push_back(draft.body);
    const BodyDescription description = tell(mechanism, draft, way, telling);
    builder.add(description).add(com_frame(draft));
    drawings.push_back(drawn(draft, description));
  }

  System system{topology, builder.build(), {}, {}};
  system.drawn.resize(drawings.size() + 1);
  for (std::size_t b = 0; b < drawings.size(); ++b) {
    const std::string& name = mechanism.bodies[b].name;
    system.drawn[system.model.body_index(name)] = std::move(drawings[b]);
    const Vec3<> f = random.vector(10), m = random.vector(10);
    system.loads.emplace_back(system.model.frame_index(name + ".com"), static_cast<Representation>(b % 4), m,
                              f);
  }
  return system;
}

}  // namespace axode::test::paper
