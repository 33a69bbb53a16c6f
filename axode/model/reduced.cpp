#include <unordered_map>

#include "axode/model/builder.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/nearest_name.hpp"
#include "axode/model/placement.hpp"

namespace axode {
namespace {

/// C_J(q): the displacement of a joint in its joint frame.
SE3<> displacement(const Joint& joint, std::span<const double> q) {
  const double own = joint.leader ? joint.leader->ratio * q[joint.iq] + joint.leader->offset : 0;
  const double* q_i = joint.leader ? &own : &q[joint.iq];
  return with_subgroup(joint.kind, joint.pitch, [&](const auto& s) { return s.pose(SE3<>{}, q_i); });
}

}  // namespace

Model reduced(const Model& model, std::span<const std::string_view> locked, std::span<const double> q) {
  check_configuration(model, q);
  std::vector<bool> is_locked(model.n_bodies() + 1);
  for (const std::string_view name : locked) {
    const int i = model.joint_index(name);
    if (const auto& leader = model.joint(i).leader)
      throw std::invalid_argument("reduced: joint \"" + std::string(name) + "\" follows joint \"" +
                                  model.joint(leader->joint).name + "\"; lock that one");
    is_locked[i] = true;
  }
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (const auto& leader = model.joint(i).leader; leader && is_locked[leader->joint]) is_locked[i] = true;

  // Every body relative to its predecessor, so that nothing else depends on a joint that moves away from
  // zero; by joint frames, which are near each other where body frames may be far.
  Description description = expand(model.description());
  const std::vector<Placement> placements = place(description, depth_first_order(description));
  std::unordered_map<std::string_view, int> index;
  for (int i = 1; i <= model.n_bodies(); ++i) index.emplace(model.body(i).name, i);
  std::unordered_map<std::string_view, SE3<>> A;
  for (std::size_t d = 0; d < description.bodies.size(); ++d) {
    BodyDescription& body = description.bodies[d];
    const Placement& at = placements[d];
    A.emplace(body.name, at.A);
    if (body.inertia && body.inertia->in == GivenIn::construction_frame)
      body.inertia = seen_from(at.A, *body.inertia);
    const auto moving = index.find(body.name);
    if (moving == index.end() || is_locked[moving->second]) {
      const SE3<> C_J = moving == index.end() ? SE3<>{} : displacement(model.joint(moving->second), q);
      body.geometry = InJointFrames{at.S_prev * C_J, at.S_self};
      body.joint = {.name = body.joint.name, .kind = JointKind::fixed};
    } else {
      body.geometry = InJointFrames{at.S_prev, at.S_self};
      body.joint.axis = {0, 0, 1}, body.joint.point = {0, 0, 0};
    }
  }
  for (FrameDescription& frame : description.frames) {
    if (frame.in == GivenIn::construction_frame && frame.body != "ground")
      frame.pose = relative(A.at(frame.body), frame.pose);
    frame.in = GivenIn::body_frame;
  }
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
