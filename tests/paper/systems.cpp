#include "tests/paper/systems.hpp"

#include "tests/support/random_tree.hpp"

namespace axode::test::paper {
namespace {

struct Plan {
  std::vector<int> predecessors;  ///< bodies are counted from 1, 0 is the ground
  std::vector<JointKind> kinds;   ///< dealt out in turn, beginning with another one for each seed
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

/// A body at q = 0 as somebody drew it, in the construction frame.
DrawnBody draw(Random<double>& random, int number, int predecessor, JointKind kind) {
  DrawnBody body{.name = "body " + std::to_string(number), .joint = "joint " + std::to_string(number)};
  body.predecessor = predecessor - 1, body.kind = kind;
  body.A = random.pose(), body.J = kind == JointKind::free ? body.A : random.pose();
  if (kind == JointKind::helical) body.pitch = random.number(0.1, 0.4);
  return body;
}

/// Mass, centre of mass and moments of points, summed up in the frame F of the construction frame and told in it.
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
  const bool at_the_construction_frame = frames == BodyFrames::at_the_construction_frame;
  Random<double> random(1 + seed);
  Mechanism mechanism{.gravity = random.vector(9.81), .bodies = {}};
  ModelBuilder builder(std::string(to_string(topology)) + ", seed " + std::to_string(seed));
  builder.gravity(mechanism.gravity);
  std::vector<Drawn> drawn_in_order;
  for (int b = 0; b < static_cast<int>(plan.predecessors.size()); ++b) {
    const JointKind kind = plan.kinds[(b + seed) % plan.kinds.size()];
    DrawnBody body = draw(random, b + 1, plan.predecessors[b], kind);
    std::vector<PointMass> points;  // first in the construction frame
    const Vec3<> place = body.A * random.vector(0.5);
    for (int k = 0; k < 6; ++k) points.push_back({random.number(0.2, 1), place + random.vector(0.4)});
    const SO3<> axes = random.rotation(), R_c = random.rotation();
    const Way way = static_cast<Way>((b + seed) % 3);
    Random<double> telling(seed + b);
    if (at_the_construction_frame) body.A = {};
    mechanism.bodies.push_back(body);

    BodyDescription description =
        told(mechanism, body, at_the_construction_frame ? Way::construction_frame : way, telling);
    const GivenIn in = way == Way::body_frame ? GivenIn::construction_frame : GivenIn::body_frame;
    const InertiaAbout about =
        way == Way::joint_frames ? InertiaAbout::frame_origin : InertiaAbout::center_of_mass;
    description.inertia = sum(points, in == GivenIn::body_frame ? body.A : SE3<>{}, in, about, axes);
    builder.add(description);
    const Vec3<> com = sum(points, {}, GivenIn::construction_frame, about, axes).com;
    builder.add(FrameDescription{.name = body.name + ".com",
                                 .body = body.name,
                                 .pose = {R_c, com},
                                 .in = GivenIn::construction_frame});

    const bool slides = kind == JointKind::prismatic;
    Drawn drawn{.Y = slides ? Screw<>{{}, body.J.R.z} : screw(body.J.R.z, body.J.r, body.pitch),
                .points = points};
    for (PointMass& point : drawn.points) point.p = inverse(body.A) * point.p;
    drawn_in_order.push_back(std::move(drawn));
  }

  System system{topology, builder.build(), {}, {}};
  system.drawn.resize(static_cast<std::size_t>(system.model.n_bodies()) + 1);
  for (std::size_t b = 0; b < drawn_in_order.size(); ++b) {
    const int i = system.model.body_index(mechanism.bodies[b].name);
    system.drawn[i] = std::move(drawn_in_order[b]);
    system.loads.emplace_back(system.model.frame_index(mechanism.bodies[b].name + ".com"),
                              static_cast<Representation>(b % 4), random.vector(10), random.vector(10));
  }
  return system;
}

}  // namespace axode::test::paper
