#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <unordered_map>
#include <unordered_set>
#include <variant>

#include "axode/io.hpp"
#include "axode/io/pose.hpp"
#include "axode/io/urdf/urdf_kinds.hpp"
#include "axode/io/writing.hpp"
#include "axode/io/xml_text.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/shape_kinds.hpp"

namespace axode {
namespace {

using io::bounded, io::xml::text;

/// Relative tolerance of the test whether the origin of a link is on the axis of its joint, as URDF requires.
constexpr double on_axis = 1e-12;

/// The text of a limit. An infinite one is written as the largest double, because URDF has no infinity.
std::string limit_text(double x) {
  return text(std::clamp(x, -std::numeric_limits<double>::max(), std::numeric_limits<double>::max()));
}

/// The type of a joint in URDF; empty if URDF has no type for its kind.
std::string_view urdf_type(const JointDescription& joint) {
  if (joint.kind == JointKind::revolute && (joint.dof.empty() || !bounded(joint.dof[0]))) return "continuous";
  const auto found = std::ranges::find(io::urdf_kinds, joint.kind, &io::UrdfKind::kind);
  return found == io::urdf_kinds.end() ? "" : found->type;
}

/// The limits and losses that all degrees of freedom of a joint have; empty if they differ.
std::optional<Dof> shared_dof(const JointDescription& joint) {
  if (joint.dof.empty()) return Dof{};
  const Dof& first = joint.dof[0];
  const auto differs = [&](const Dof& dof) {
    return bounded(dof) || dof.velocity != first.velocity || dof.effort != first.effort ||
           dof.damping != first.damping || dof.friction != first.friction;
  };
  if (joint.dof.size() > 1 && std::ranges::any_of(joint.dof, differs)) return std::nullopt;
  return first;
}

/// Adds a fault to `unsaid` for everything in a description that URDF cannot express.
void find_unsaid(const Description& d, io::Unsaid& unsaid) {
  if (norm(d.gravity - Vec3<>{0, 0, -9.81}) > 0)
    unsaid.leave_out("gravity", "is (" + text(d.gravity) + ") m/s², and readers take (0, 0, -9.81)",
                     d.source);
  const auto shapes = [&](const std::vector<ShapeDescription>& all, const std::string& owner,
                          const Source& source) {
    for (const ShapeDescription& shape : all) {
      const std::string article = shape.kind == ShapeKind::ellipsoid ? "an " : "a ";
      if (!traits(shape.kind).in_urdf)
        unsaid.leave_out(owner, "has a shape that is " + article + std::string(to_string(shape.kind)),
                         source);
      else if (io::has_surface(shape))
        unsaid.leave_out(owner, "has a shape with friction, restitution or stiffness", source);
    }
  };
  shapes(d.shapes, "the ground", d.source);
  for (const BodyDescription& body : d.bodies) {
    const JointDescription& joint = body.joint;
    const std::string element = "joint \"" + joint.name + '"';
    shapes(body.shapes, "body \"" + body.name + '"', body.source);
    const Source& source = joint.source.line > 0 ? joint.source : body.source;
    if (urdf_type(joint).empty())
      unsaid.refuse(element, "is " + std::string(to_string(joint.kind)) + "; URDF has no such joint", source);
    const auto armed = std::ranges::find_if(joint.dof, [](const Dof& dof) { return dof.armature != 0; });
    if (armed != joint.dof.end())
      unsaid.leave_out(element, "has an armature of " + text(armed->armature), source);
    if (std::ranges::any_of(joint.dof, has_gear_losses))
      unsaid.leave_out(element, "has a gear with losses", source);
    if (std::ranges::any_of(joint.dof, [](const Dof& dof) { return dof.stiffness != 0; }))
      unsaid.leave_out(element, "has a spring", source);
    if (std::ranges::any_of(joint.dof, [](const Dof& dof) { return dof.stop_stiffness != 0; }))
      unsaid.leave_out(element, "has elastic stops", source);
    if (std::ranges::any_of(joint.dof, [](const Dof& dof) { return dof.hard_stops; }))
      unsaid.leave_out(element, "has hard stops", source);
    if (joint.kind != JointKind::free && is_passive(joint, d))
      unsaid.leave_out(element, "is passive", source);
    if (!shared_dof(joint))
      unsaid.leave_out(element, "has several degrees of freedom with limits or losses of their own", source);
  }
  for (std::size_t k = 0; k < d.springs.size(); ++k)
    unsaid.leave_out(spring_element(d.springs[k], k), io::said_of(d.springs[k]), d.springs[k].source);
  for (std::size_t k = 0; k < d.loops.size(); ++k)
    if (!io::in_urdf(d.loops[k].kind))
      unsaid.leave_out("loop \"" + loop_name(d.loops[k], k) + '"',
                       "is " + std::string(to_string(d.loops[k].kind)), d.loops[k].source);
  for (std::size_t k = 0; k < d.couplings.size(); ++k)
    unsaid.leave_out("coupling \"" + coupling_name(d.couplings[k], k) + '"',
                     "is one of the coordinates of " + std::to_string(d.couplings[k].terms.size()) +
                         " joints" + (d.couplings[k].play > 0 ? " with play" : ""),
                     d.couplings[k].source);
  unsaid.leave_out_motions(d);
  if (d.contact)
    unsaid.leave_out("contact", "has friction, a margin, a threshold and ignored pairs of bodies",
                     d.contact->source);
}

class UrdfWriter {
 public:
  UrdfWriter(const Description& description, std::ostream& out)
      : d_(expand(description)),
        order_(depth_first_order(d_)),
        at_(reference_placements(d_, order_)),
        out_(out) {
    for (std::size_t i = 0; i < d_.bodies.size(); ++i) bodies_.emplace(d_.bodies[i].name, i);
    one_fixed_root_ = is_one_fixed_root();
  }

  std::vector<Fault> write(Strictness strictness) {
    io::Unsaid unsaid("URDF", strictness);
    find_unsaid(d_, unsaid);
    unsaid.throw_errors(d_.name);
    for (const BodyDescription& body : d_.bodies) {
      links_.insert(body.name);
      joints_.insert(body.joint.name);
    }
    for (const FrameDescription& frame : d_.frames) links_.insert(frame.name);
    out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<robot name=\"" << text(d_.name) << "\">\n";
    if (!one_fixed_root_) {
      const BodyDescription ground{.shapes = d_.shapes};
      write_link("ground", &ground);
    }
    for (const int i : order_.order) write_body(i);
    for (const FrameDescription& frame : d_.frames) write_frame(frame);
    const std::vector<LoopDescription> loops = d_.loops.empty() ? d_.loops : in_joint_frames(d_).loops;
    for (std::size_t k = 0; k < loops.size(); ++k)
      if (io::in_urdf(loops[k].kind)) write_loop(loops[k], loop_name(loops[k], k));
    out_ << "</robot>\n";
    return std::move(unsaid).warnings();
  }

 private:
  bool is_ground(int i) const { return order_.predecessor[i] < 0; }
  bool is_one_fixed_root() const {
    int roots = 0;
    for (const int i : order_.order) roots += is_ground(i);
    if (roots != 1 || !d_.shapes.empty()) return false;
    const int root = order_.order[0];
    const SE3<>& A = at_[root].A;
    return d_.bodies[root].joint.kind == JointKind::fixed && norm(A.r) == 0 && same(A.R, {});
  }
  static bool same(const SO3<>& a, const SO3<>& b) {
    return norm(a.x - b.x) <= on_axis && norm(a.y - b.y) <= on_axis && norm(a.z - b.z) <= on_axis;
  }

  /// Whether the frame of body i can be that of its link, which in URDF is also the frame of its joint.
  bool can_be_link(int i) const {
    const SE3<>& S = at_[i].S_self;
    const double scale = 1 + norm(at_[i].A.r);
    switch (d_.bodies[i].joint.kind) {
      case JointKind::revolute: return norm(cross(S.R.z, S.r)) <= on_axis * scale;
      case JointKind::planar: return norm(S.r) <= on_axis * scale && same(S.R, rotation_to(S.R.z));
      default: return true;
    }
  }

  void write_body(int i) {
    const BodyDescription& body = d_.bodies[i];
    if (is_ground(i) && one_fixed_root_) {
      write_link(body.name, &body);
      return;
    }
    const std::string parent = is_ground(i) ? "ground" : body.predecessor;
    if (can_be_link(i)) {
      write_link(body.name, &body);
      write_joint(body.joint, parent, body.name, at_[i].B, at_[i].S_self.R.z);
      return;
    }
    // Otherwise the joint moves an additional link whose origin is on the axis, and the body is fixed to this
    // link.
    const SE3<>& S = at_[i].S_self;
    const SE3<> on_body{body.joint.kind == JointKind::planar ? S.R : SO3<>{}, S.r};
    const std::string carrier = free_name(links_, body.joint.name + "_frame");
    write_link(carrier, nullptr);
    write_joint(body.joint, parent, carrier, at_[i].B * on_body, transpose(on_body.R) * S.R.z);
    write_link(body.name, &body);
    write_joint({.name = free_name(joints_, carrier + "_to_" + body.name)}, carrier, body.name,
                inverse(on_body), {});
  }

  void write_frame(const FrameDescription& frame) {
    const auto found = bodies_.find(frame.body);
    const SE3<> A = found == bodies_.end() ? SE3<>{} : at_[found->second].A;
    const SE3<> pose = frame.in == GivenIn::body_frame ? frame.pose : inverse(A) * frame.pose;
    write_link(frame.name, nullptr);
    write_joint({.name = free_name(joints_, frame.name + "_joint")}, frame.body, frame.name, pose, {});
  }

  void write_loop(const LoopDescription& loop, const std::string& name) {
    out_ << "  <loop_joint name=\"" << text(name) << "\" type=\"" << to_string(loop.kind) << "\">\n";
    for (const std::size_t k : {0, 1}) {
      // If the only root is fixed to the ground at the identity, no link is called ground, and the frame of
      // the root is that of the ground.
      const bool on_root = one_fixed_root_ && loop.between[k] == "ground";
      const SE3<>& pose = (*loop.frames)[k];
      out_ << "    <link" << k + 1 << " link=\""
           << text(on_root ? d_.bodies[order_.order[0]].name : loop.between[k]) << "\" xyz=\"" << text(pose.r)
           << "\" rpy=\"" << text(io::to_roll_pitch_yaw(pose.R)) << "\"/>\n";
    }
    out_ << "  </loop_joint>\n";
  }

  static std::string free_name(std::unordered_set<std::string>& taken, std::string name) {
    while (!taken.insert(name).second) name += '_';
    return name;
  }

  void write_origin(const char* indent, const SE3<>& pose) {
    out_ << indent << "<origin xyz=\"" << text(pose.r) << "\" rpy=\"" << text(io::to_roll_pitch_yaw(pose.R))
         << "\"/>\n";
  }

  void write_link(const std::string& name, const BodyDescription* body) {
    out_ << "  <link name=\"" << text(name);
    if (body == nullptr || (!body->inertia && body->shapes.empty())) {
      out_ << "\"/>\n";
      return;
    }
    out_ << "\">\n";
    if (body->inertia) write_inertial(*body->inertia, at_[body - d_.bodies.data()].A);
    for (const ShapeDescription& shape : body->shapes)
      if (traits(shape.kind).in_urdf) write_shape(shape);
    out_ << "  </link>\n";
  }

  void write_shape(const ShapeDescription& shape) {
    const ShapeTraits& kind = traits(shape.kind);
    out_ << "    <" << to_string(shape.role);
    if (!shape.name.empty()) out_ << " name=\"" << text(shape.name) << '"';
    out_ << ">\n";
    write_origin("      ", shape.pose);
    out_ << "      <geometry><" << kind.name;
    if (!kind.size.empty()) out_ << ' ' << kind.size << "=\"" << text(shape.size) << '"';
    if (kind.radius) out_ << " radius=\"" << text(shape.radius) << '"';
    if (kind.length) out_ << " length=\"" << text(shape.length) << '"';
    if (shape.kind == ShapeKind::mesh)
      out_ << " filename=\"" << text(shape.file) << "\" scale=\"" << text(shape.scale) << '"';
    out_ << "/></geometry>\n";
    if (const auto& c = shape.color)
      out_ << "      <material name=\"color_" << ++colors_ << "\"><color rgba=\"" << text((*c)[0]) << ' '
           << text((*c)[1]) << ' ' << text((*c)[2]) << ' ' << text((*c)[3]) << "\"/></material>\n";
    out_ << "    </" << to_string(shape.role) << ">\n";
  }

  /// Writes <inertial>, about the centre of mass and in the axes of the link; A is the body's pose at q = 0.
  void write_inertial(const MassProperties& given, const SE3<>& A) {
    const SE3<> to_body = given.in == GivenIn::body_frame ? SE3<>{} : inverse(A);
    Sym3<> Theta = rotate(given.axes, given.Theta);
    if (given.about == InertiaAbout::frame_origin && given.mass > 0)
      Theta = inertia_about_com(Inertia<>{given.mass, given.mass * given.com, Theta});
    Theta = rotate(to_body.R, Theta);
    out_ << "    <inertial>\n      <origin xyz=\"" << text(to_body * given.com) << "\" rpy=\"0 0 0\"/>\n"
         << "      <mass value=\"" << text(given.mass) << "\"/>\n      <inertia ixx=\"" << text(Theta.xx)
         << "\" ixy=\"" << text(Theta.xy) << "\" ixz=\"" << text(Theta.xz) << "\" iyy=\"" << text(Theta.yy)
         << "\" iyz=\"" << text(Theta.yz) << "\" izz=\"" << text(Theta.zz) << "\"/>\n    </inertial>\n";
  }

  void write_joint(const JointDescription& joint, const std::string& parent, const std::string& child,
                   const SE3<>& origin, const Vec3<>& axis) {
    const std::string_view type = urdf_type(joint);
    out_ << "  <joint name=\"" << text(joint.name) << "\" type=\"" << type << "\">\n    <parent link=\""
         << text(parent) << "\"/>\n    <child link=\"" << text(child) << "\"/>\n";
    write_origin("    ", origin);
    if (traits(joint.kind).has("axis")) out_ << "    <axis xyz=\"" << text(axis) << "\"/>\n";
    const Dof dof = shared_dof(joint).value_or(Dof{});
    if (type == "revolute" || type == "prismatic") {
      out_ << "    <limit lower=\"" << limit_text(dof.lower) << "\" upper=\"" << limit_text(dof.upper)
           << "\" velocity=\"" << limit_text(dof.velocity) << "\" effort=\"" << limit_text(dof.effort)
           << "\"/>\n";
    } else if (std::isfinite(dof.velocity) || std::isfinite(dof.effort)) {
      out_ << "    <limit velocity=\"" << limit_text(dof.velocity) << "\" effort=\"" << limit_text(dof.effort)
           << "\"/>\n";
    }
    if (dof.damping != 0 || dof.friction != 0)
      out_ << "    <dynamics damping=\"" << text(dof.damping) << "\" friction=\"" << text(dof.friction)
           << "\"/>\n";
    if (joint.coupling)
      out_ << "    <mimic joint=\"" << text(joint.coupling->leader) << "\" multiplier=\""
           << text(joint.coupling->ratio) << "\" offset=\"" << text(joint.coupling->offset) << "\"/>\n";
    out_ << "  </joint>\n";
  }

  Description d_;
  DepthFirstOrder order_;
  std::vector<Placement> at_;
  std::ostream& out_;
  std::unordered_map<std::string, std::size_t> bodies_;
  std::unordered_set<std::string> links_, joints_;
  bool one_fixed_root_ = false;
  int colors_ = 0;
};

}  // namespace

std::vector<Fault> write_urdf(const Model& model, std::ostream& out, Strictness strictness) {
  return UrdfWriter(model.description(), out).write(strictness);
}

}  // namespace axode
