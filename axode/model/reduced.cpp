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
  std::unordered_map<std::string_view, int> index;
  for (int i = 1; i <= model.n_bodies(); ++i) index.emplace(model.body(i).name, i);
  Description description = in_joint_frames(model.description());
  for (BodyDescription& body : description.bodies) {
    const auto moving = index.find(body.name);
    if (moving == index.end() || !is_locked[moving->second]) continue;
    InJointFrames& frames = std::get<InJointFrames>(body.geometry);
    frames.S_prev = frames.S_prev * displacement(model.joint(moving->second), q);
    body.joint = {.name = body.joint.name, .kind = JointKind::fixed};
  }
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
