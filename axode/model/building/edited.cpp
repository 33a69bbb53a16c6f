#include "axode/model/building/edited.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/model/building/builder.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode {
namespace {

/// The mass properties of a body with the inertia M about the origin of its frame.
MassProperties mass_properties(const Inertia<>& M) {
  return {.mass = M.m,
          .com = M.m == 0 ? Vec3<>{} : center_of_mass(M),
          .Theta = M.Theta,
          .about = InertiaAbout::frame_origin};
}

/// Throws std::invalid_argument if a name of `other`, with the prefix before it, is a name in `one` as well.
void check_names_differ(const Description& one, const Description& other, const std::string& prefix) {
  std::unordered_set<std::string> places,
      joints;  // a name must be unique among bodies and frames, and among joints and loops
  for (const BodyDescription& body : one.bodies) {
    places.insert(body.name);
    joints.insert(joint_name(body));
  }
  for (const FrameDescription& frame : one.frames) places.insert(frame.name);
  for (std::size_t k = 0; k < one.loops.size(); ++k) joints.insert(loop_name(one.loops[k], k));
  for (std::size_t k = 0; k < one.couplings.size(); ++k) joints.insert(coupling_name(one.couplings[k], k));
  std::string both;
  const auto check = [&](const std::unordered_set<std::string>& taken, const std::string& name) {
    if (taken.contains(prefix + name)) both += (both.empty() ? "\"" : ", \"") + prefix + name + '"';
  };
  for (const BodyDescription& body : other.bodies) {
    check(places, body.name);
    check(joints, joint_name(body));
  }
  for (const FrameDescription& frame : other.frames) check(places, frame.name);
  for (std::size_t k = 0; k < other.loops.size(); ++k) check(joints, loop_name(other.loops[k], k));
  for (std::size_t k = 0; k < other.couplings.size(); ++k)
    check(joints, coupling_name(other.couplings[k], k));
  if (!both.empty())
    throw std::invalid_argument("append: both models have " + both +
                                "; give a prefix that makes them differ");
}

/// Where another mechanism is mounted: a pose on the body `carrier`, its new ground, and a prefix for names.
struct Mount {
  std::string carrier;
  SE3<> pose;
  std::string prefix;

  std::string renamed(const std::string& name) const { return prefix + name; }
  std::string new_name(const std::string& name) const { return name == "ground" ? carrier : renamed(name); }
  /// The pose of the mounted mechanism's `name` in what it becomes: `pose` for the ground, else the identity.
  SE3<> from(const std::string& name) const { return name == "ground" ? pose : SE3<>{}; }
};

// mount() renames an element of the mounted mechanism and puts it on the carrier if it was on the ground. All
// poses must be relative to bodies and frames, see in_joint_frames().
void mount(BodyDescription& body, const Mount& at) {
  body.joint.name = at.renamed(joint_name(body));
  body.name = at.renamed(body.name);
  if (body.joint.coupling) body.joint.coupling->leader = at.renamed(body.joint.coupling->leader);
  SE3<>& S_prev = std::get<InJointFrames>(body.geometry).S_prev;
  S_prev = at.from(body.predecessor) * S_prev;
  body.predecessor = at.new_name(body.predecessor);
}
void mount(FrameDescription& frame, const Mount& at) {
  frame.name = at.renamed(frame.name);
  frame.pose = at.from(frame.body) * frame.pose;
  frame.body = at.new_name(frame.body);
}
void mount(SpringDescription& spring, const Mount& at) {
  if (!spring.name.empty()) spring.name = at.renamed(spring.name);
  if (traits(spring.kind).has("between"))
    for (std::size_t k = 0; k < 2; ++k) {
      const SE3<> from = at.from(spring.between[k]);
      spring.points[k] = from * spring.points[k];
      spring.frames[k] = from * spring.frames[k];
      spring.between[k] = at.new_name(spring.between[k]);
    }
  for (SpringDescription::Point& it : spring.path) {
    it.point = at.from(it.on) * it.point;
    it.on = at.new_name(it.on);
  }
  for (auto& [joint, factor] : spring.terms) joint = at.renamed(joint);
}
void mount(LoopDescription& loop, const Mount& at) {
  for (std::size_t k = 0; k < 2; ++k) {
    (*loop.frames)[k] = at.from(loop.between[k]) * (*loop.frames)[k];
    loop.between[k] = at.new_name(loop.between[k]);
  }
}
void mount(ContactDescription& contact, const Mount& at) {
  for (auto& pair : contact.ignored)
    for (std::string& body : pair) body = at.new_name(body);
}
void mount(CouplingDescription& coupling, const Mount& at) {
  for (auto& [joint, factor] : coupling.terms) joint = at.renamed(joint);
}
void mount(MotionDescription& motion, const Mount& at) {
  if (!motion.name.empty()) motion.name = at.renamed(motion.name);
  motion.of = at.renamed(motion.of);
}
void mount(DriveDescription& drive, const Mount& at) {
  drive.name = at.renamed(drive.name);
  for (auto& [joint, factor] : drive.joints) joint = at.renamed(joint);
  if (drive.line)
    for (std::size_t k = 0; k < 2; ++k) {
      drive.line->points[k] = at.from(drive.line->between[k]) * drive.line->points[k];
      drive.line->between[k] = at.new_name(drive.line->between[k]);
    }
  if (!drive.input.from.empty()) drive.input.from = at.renamed(drive.input.from);
}
/// Adds the initial state of the mounted mechanism to `into`, the initial state of the other one.
void mount(const InitialStateDescription& state, const Mount& at,
           std::optional<InitialStateDescription>& into) {
  if (!into) into.emplace().source = state.source;
  for (const auto& [joint, numbers] : state.q) into->q.emplace_back(at.renamed(joint), numbers);
  for (const auto& [joint, numbers] : state.v) into->v.emplace_back(at.renamed(joint), numbers);
}
template <class Part> void mount_all(std::vector<Part>& parts, const Mount& at, std::vector<Part>& into) {
  for (Part& part : parts) {
    mount(part, at);
    into.push_back(std::move(part));
  }
}

/// Adds the contact settings of a mounted mechanism to the settings `into` of the mechanism on which it is
/// mounted. If both have settings, the lists of pairs of bodies without contacts are joined, and the numbers
/// of `into` are kept: its friction coefficient, margin and threshold.
void mount_contact(std::optional<ContactDescription>& contact, const Mount& at,
                   std::optional<ContactDescription>& into) {
  if (!contact) return;
  mount(*contact, at);
  if (into)
    into->ignored.insert(into->ignored.end(), contact->ignored.begin(), contact->ignored.end());
  else
    into = std::move(contact);
}

/// Puts the prefix before the names of all loops and couplings, default names such as `loop 1` included.
void name_loops(Description& description, const std::string& prefix) {
  for (std::size_t k = 0; k < description.loops.size(); ++k)
    description.loops[k].name = prefix + loop_name(description.loops[k], k);
  for (std::size_t k = 0; k < description.couplings.size(); ++k)
    description.couplings[k].name = prefix + coupling_name(description.couplings[k], k);
}

Model built(Description description) { return ModelBuilder(std::move(description)).build(); }

}  // namespace

Model with_parameters(const Model& model, std::span<const double> pi) {
  check_size("pi", pi.size(), 10 * static_cast<std::size_t>(model.n_bodies()), "10 * n_bodies");
  std::unordered_map<std::string_view, const Frame*> frames;
  for (const Frame& frame : model.frames()) frames.emplace(frame.name, &frame);
  Description description = expand(model.description());
  for (BodyDescription& body : description.bodies) {
    const int i = frames.at(body.name)->body;
    if (i == 0) continue;
    body.inertia.reset();
    if (model.body(i).name != body.name) continue;
    const auto own = pi.subspan(10 * static_cast<std::size_t>(i - 1)).first<10>();
    const Inertia<> M = inertia_of(own);
    if (M.m == 0 && (M.h.x != 0 || M.h.y != 0 || M.h.z != 0))
      throw std::invalid_argument("pi: body \"" + body.name +
                                  "\" has a first moment of mass but the mass 0; give it a mass");
    if (inertial_parameters(M) != inertial_parameters(Inertia<>{})) body.inertia = mass_properties(M);
  }
  return built(std::move(description));
}

Model with_gravity(const Model& model, const Vec3<>& g) { return ModelBuilder(model).gravity(g).build(); }

Model with_payload(const Model& model, std::string_view frame, const Inertia<>& M, std::string_view name) {
  const Frame& at = model.frame(model.frame_index(frame));
  const BodyDescription payload{.name = std::string(name),
                                .predecessor = model.body(at.body).name,
                                .geometry = InBodyFrame{at.pose},
                                .inertia = mass_properties(M)};
  BodyDescription alone = payload;
  alone.predecessor = "ground";
  ModelBuilder("payload").add(std::move(alone)).build();
  Description description = expand(model.description());
  description.bodies.push_back(payload);
  return built(std::move(description));
}

Model append(const Model& model, std::string_view frame, const Model& other, std::string_view prefix,
             const JointDescription& joint) {
  const Frame& on = model.frame(model.frame_index(frame));
  Mount at{model.body(on.body).name, on.pose, std::string(prefix)};
  Description description = expand(model.description());
  if (joint.kind != JointKind::fixed) {
    BodyDescription base{
        .name = {}, .predecessor = at.carrier, .joint = joint, .geometry = InBodyFrame{at.pose}};
    if (joint.name.empty()) base.joint.name = at.prefix + "mount";
    base.name = base.joint.name + ".base";
    at.carrier = base.name;
    at.pose = {};
    description.bodies.push_back(std::move(base));
  }
  Description mounted = in_joint_frames(other.description());
  check_names_differ(description, mounted, at.prefix);
  name_loops(mounted, at.prefix);
  for (std::size_t k = 0; k < mounted.drives.size(); ++k)
    mounted.drives[k].name = drive_name(mounted.drives[k], k);
  const auto carrier = std::ranges::find(description.bodies, at.carrier, &BodyDescription::name);
  std::vector<ShapeDescription>& shapes =
      carrier == description.bodies.end() ? description.shapes : carrier->shapes;
  for (ShapeDescription& shape : mounted.shapes) {
    shape.pose = at.pose * shape.pose;
    shapes.push_back(std::move(shape));
  }
  mount_all(mounted.bodies, at, description.bodies);
  mount_all(mounted.frames, at, description.frames);
  mount_all(mounted.springs, at, description.springs);
  mount_all(mounted.loops, at, description.loops);
  mount_all(mounted.couplings, at, description.couplings);
  mount_all(mounted.motions, at, description.motions);
  mount_all(mounted.drives, at, description.drives);
  if (mounted.state) mount(*mounted.state, at, description.state);
  mount_contact(mounted.contact, at, description.contact);
  description.warnings.insert(description.warnings.end(), mounted.warnings.begin(), mounted.warnings.end());
  return built(std::move(description));
}

namespace {

/// Checks a joint that is to be reversed. Throws std::invalid_argument if it has several velocities and
/// limits, losses, springs or armatures, because these act along axes of the body that the joint moves.
/// Springs, damping and armatures of a spherical joint are allowed if they are equal about all axes and the
/// joint is not on the ground (`base`).
void check_may_be_reversed(const JointDescription& joint, bool base) {
  const auto of_own_axes = [](const Dof& dof) {
    return dof.armature != 0 || dof.damping != 0 || dof.friction != 0 || dof.stiffness != 0;
  };
  const auto bounded = [](const Dof& dof) {
    return std::isfinite(dof.lower) || std::isfinite(dof.upper) || std::isfinite(dof.velocity) ||
           std::isfinite(dof.effort);
  };
  const auto differs = [&](const Dof& dof) {
    const Dof& first = joint.dof[0];
    return dof.armature != first.armature || dof.damping != first.damping || dof.friction != 0 ||
           dof.stiffness != first.stiffness;
  };
  if (joint.dof.size() <= 1) return;
  const bool isotropic =
      joint.kind == JointKind::spherical && !base && std::ranges::none_of(joint.dof, differs);
  if (std::ranges::any_of(joint.dof, bounded) || (!isotropic && std::ranges::any_of(joint.dof, of_own_axes)))
    throw std::invalid_argument(
        "rerooted: joint \"" + joint.name + "\" is " + std::string(to_string(joint.kind)) +
        " and has limits, losses, springs or armatures, which would be along the axes of another body; "
        "remove them first");
}

/// Leaves out, with a warning, the initial state of joints whose coordinates change when another body becomes
/// the root body, which is joined to the ground. These are the joints with several velocities on the path
/// from the new root body to the old one, and the joint `held` of the old root body if it is free.
void drop_reversed_state(Description& description, const std::vector<std::size_t>& path,
                         const JointDescription& held) {
  std::unordered_set<std::string> reversed;
  if (held.kind == JointKind::free) reversed.insert(held.name);
  for (const std::size_t d : path)
    if (const JointDescription& joint = description.bodies[d].joint; traits(joint.kind).dof > 1)
      reversed.insert(joint.name);
  leave_out_state(description, reversed, "is left out, because the joint has another predecessor now");
}

}  // namespace

Model rerooted(const Model& model, std::string_view body) {
  const Description expanded = expand(model.description());
  Description description = in_joint_frames(model.description());
  const DepthFirstOrder order = depth_first_order(expanded);
  const std::vector<Placement> placements = reference_placements(expanded, order);
  const auto named = std::ranges::find(description.bodies, body, &BodyDescription::name);
  if (named == description.bodies.end())
    throw std::invalid_argument(
        "body \"" + std::string(body) + "\" is not described" +
        did_you_mean(body, description.bodies, [](const BodyDescription& it) { return it.name; }));
  std::vector<std::size_t> path;  // from the body to its root body
  for (int d = static_cast<int>(named - description.bodies.begin()); d >= 0; d = order.predecessor[d])
    path.push_back(static_cast<std::size_t>(d));
  const JointDescription held = description.bodies[path.back()].joint;
  if (held.kind != JointKind::fixed && held.kind != JointKind::free)
    throw std::invalid_argument("rerooted: body \"" + description.bodies[path.back()].name +
                                "\" hangs on the ground by the joint \"" + held.name + "\", which is " +
                                std::string(to_string(held.kind)) +
                                "; only a root that is fixed or free can change places with another body");
  if (path.size() > 1) {
    check_may_be_reversed(held, true);
    drop_reversed_state(description, path, held);
  }
  // A joint with the displacement C between its joint frames is reversed by the displacement C⁻¹. For a joint
  // of one velocity this is the displacement about the axis -z with the same coordinate.
  for (std::size_t k = path.size() - 1; k > 0; --k) {
    BodyDescription& behind = description.bodies[path[k]];
    const BodyDescription& ahead = description.bodies[path[k - 1]];
    check_may_be_reversed(ahead.joint, false);
    const auto& frames = std::get<InJointFrames>(ahead.geometry);
    behind.joint = ahead.joint;
    if (traits(ahead.joint.kind).dof == 1) behind.joint.axis = {0, 0, -1};
    behind.geometry = InJointFrames{frames.S_self, frames.S_prev};
    behind.predecessor = ahead.name;
  }
  BodyDescription& root = description.bodies[path.front()];
  root.joint = held;
  root.geometry = InBodyFrame{placements[path.front()].A};
  root.predecessor = "ground";
  return built(std::move(description));
}

}  // namespace axode
