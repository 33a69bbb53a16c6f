#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/configuration.hpp"

namespace axode {
namespace {

/// The position of a joint of one velocity at q, of a coupled joint from its leader.
double coordinate(const Joint& joint, std::span<const double> q) {
  return joint.leader ? joint.leader->ratio * q[joint.iq] + joint.leader->offset : q[joint.iq];
}

/// The displacement of a joint: the pose at q of its joint frame relative to that at the coordinate 0.
SE3<> displacement(const Joint& joint, std::span<const double> q) {
  const double own = joint.leader ? coordinate(joint, q) : 0;
  const double* q_i = joint.leader ? &own : &q[joint.iq];
  return with_subgroup(joint.kind, joint.pitch, [&](const auto& s) { return s.pose(SE3<>{}, q_i); });
}

/// Removes the loops between bodies that no longer move relative to each other; others keep their names.
void drop_still_loops(Description& description) {
  std::unordered_map<std::string_view, std::string_view> carrier{{"ground", "ground"}};
  for (const int d : depth_first_order(description).order) {
    const BodyDescription& body = description.bodies[d];
    const bool fixed = body.joint.kind == JointKind::fixed;
    carrier.emplace(body.name, fixed ? carrier.at(body.predecessor) : body.name);
  }
  for (const FrameDescription& frame : description.frames)
    carrier.emplace(frame.name, carrier.at(frame.body));
  for (std::size_t k = 0; k < description.loops.size(); ++k)
    description.loops[k].name = loop_name(description.loops[k], k);
  std::erase_if(description.loops, [&](const LoopDescription& loop) {
    return carrier.at(loop.between[0]) == carrier.at(loop.between[1]);
  });
}

/// Moves the terms of locked joints into the offsets of couplings; removes couplings on locked joints alone.
void lock_terms(Description& description, const Model& model, const std::vector<bool>& is_locked,
                std::span<const double> q) {
  for (std::size_t k = 0; k < description.couplings.size(); ++k) {
    CouplingDescription& coupling = description.couplings[k];
    coupling.name = coupling_name(coupling, k);
    std::erase_if(coupling.terms, [&](const auto& term) {
      const int i = model.joint_index(term.first);
      if (is_locked[i]) coupling.offset -= term.second * coordinate(model.joint(i), q);
      return is_locked[i];
    });
  }
  std::erase_if(description.couplings, [](const CouplingDescription& c) { return c.terms.empty(); });
}

/// Replaces a negative length of rest, which descriptions must not have, by 0 and a curve of the same force.
void rest_at_zero(SpringDescription& spring) {
  const double rest = std::exchange(spring.rest, 0.0);
  ForceCurve curve = spring.curve.value_or(LinearCurve{spring.stiffness});
  if (const auto* line = std::get_if<LinearCurve>(&curve)) curve = PolynomialCurve{{0, line->stiffness}};
  if (auto* table = std::get_if<TableCurve>(&curve)) {
    for (double& x : table->deflections) x += rest;
  } else if (auto* polynomial = std::get_if<PolynomialCurve>(&curve)) {
    std::vector<double>& c = polynomial->coefficients;
    for (std::size_t n = 0; n < c.size(); ++n)  // by Horner's rule, again for each derivative
      for (std::size_t k = c.size() - 1; k-- > n;) c[k] -= rest * c[k + 1];
  }
  spring.curve = std::move(curve);
  // With the rest 0 the deflection is the length, which is never negative, so that a spring that acts in
  // tension always acts. The side only matters for damping, which must not reverse the force.
  if (spring.damping == 0) spring.acts = Acts::both_ways;
}

/// Adapts springs if joints are locked. The locked mechanism has another configuration at q = 0; therefore a
/// preload is replaced by the length or angle of rest that gives it. In springs on sums of joint coordinates,
/// the terms of locked joints become a part of the rest. Springs on locked joints alone are removed.
void lock_springs(Description& description, const Model& model, const std::vector<bool>& is_locked,
                  std::span<const double> q) {
  for (std::size_t k = 0; k < description.springs.size(); ++k) {
    SpringDescription& spring = description.springs[k];
    spring.name = spring_name(spring, k);
    if (spring.preload) {
      spring.rest = model.springs().elements[k].law.rest;
      spring.preload.reset();
      if (spring.rest < 0 && !model.springs().elements[k].on_joints() && spring.kind != SpringKind::torsion)
        rest_at_zero(spring);
    }
    std::erase_if(spring.terms, [&](const auto& term) {
      const int i = model.joint_index(term.first);
      if (is_locked[i]) spring.rest -= term.second * coordinate(model.joint(i), q);
      return is_locked[i];
    });
  }
  std::erase_if(description.springs, [](const SpringDescription& spring) {
    return spring.kind == SpringKind::joints && spring.terms.empty();
  });
}

/// Removes from a description the parts that belong to joints and loops without motion: the initial state of
/// locked joints, and the prescribed motions of locked joints and of rods (loop joints that keep two points
/// at a fixed distance) that drop_still_loops() removed. is_locked[i] says whether joint i is locked. Throws
/// std::invalid_argument if a drive acts on a locked joint.
void drop_still_motions(Description& description, const Model& model, const std::vector<bool>& is_locked) {
  const auto locked = [&](const auto& entry) { return is_locked[model.joint_index(entry.first)]; };
  if (description.state) {
    std::erase_if(description.state->q, locked);
    std::erase_if(description.state->v, locked);
  }
  for (std::size_t k = 0; k < description.drives.size(); ++k)
    for (const auto& [joint, factor] : description.drives[k].joints)
      if (is_locked[model.joint_index(joint)])
        throw std::invalid_argument("reduced: joint \"" + joint + "\" cannot be locked: the drive \"" +
                                    drive_name(description.drives[k], k) +
                                    "\" acts on it; remove the drive first");
  if (description.motions.empty()) return;
  std::unordered_set<std::string_view> moving;
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (!is_locked[i]) moving.insert(model.joint(i).name);
  for (const LoopDescription& loop : description.loops) moving.insert(loop.name);
  std::erase_if(description.motions,
                [&](const MotionDescription& motion) { return !moving.contains(motion.of); });
}

}  // namespace

Model reduced(const Model& model, std::span<const std::string_view> locked, std::span<const double> q) {
  check_configuration(model, q);
  std::vector<bool> is_locked(model.n_bodies() + 1);
  for (const std::string_view name : locked) {
    const int i = model.joint_index(name);
    if (const auto& leader = model.joint(i).leader) {
      const std::string& of = model.joint(leader->joint).name;
      throw std::invalid_argument("reduced: joint \"" + std::string(name) + "\" follows joint \"" + of +
                                  "\"; lock \"" + of + '"');
    }
    is_locked[i] = true;
  }
  for (int i = 1; i <= model.n_bodies(); ++i)
    if (const auto& leader = model.joint(i).leader; leader && is_locked[leader->joint]) is_locked[i] = true;

  // Every body is described relative to its predecessor, so that no other body depends on a locked joint. It
  // is described by joint frames, because these are close to each other even if body frames are far away.
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
  drop_still_loops(description);
  lock_terms(description, model, is_locked, q);
  lock_springs(description, model, is_locked, q);
  drop_still_motions(description, model, is_locked);
  return ModelBuilder(std::move(description)).build();
}

}  // namespace axode
