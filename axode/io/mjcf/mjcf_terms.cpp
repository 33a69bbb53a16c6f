#include "axode/io/mjcf/mjcf_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/io/xml_text.hpp"
#include "axode/lie/quaternion.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "axode/model/loops.hpp"

namespace axode::io::mjcf {
namespace {

using xml::text;

constexpr auto joints = std::to_array<JointInMjcf>({
    {JointKind::fixed, {}},
    {JointKind::revolute, {{{"hinge", "", 2, 0}}}},
    {JointKind::prismatic, {{{"slide", "", 2, 0}}}},
    {JointKind::spherical, {{{"ball", "", 2, 0}}}},
    {JointKind::planar, {{{"slide", ".x", 0, 1}, {"slide", ".y", 1, 2}, {"hinge", ".angle", 2, 0}}}, 1},
    {JointKind::free, {{{"free", "", 2, 0}}}},
});

/// Whether MuJoCo can open a mesh file: the name must be a path, not a URL, and end in .stl, .obj or .msh.
bool opens(const std::string& file) {
  if (file.find("://") != std::string::npos) return false;
  const std::size_t dot = file.rfind('.');
  std::string ending = dot == std::string::npos ? "" : file.substr(dot);
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return ending == ".stl" || ending == ".obj" || ending == ".msh";
}

}  // namespace

const JointInMjcf* in_mjcf(JointKind kind) {
  const auto found = std::ranges::find(joints, kind, &JointInMjcf::kind);
  return found == joints.end() ? nullptr : &*found;
}

bool in_mjcf(LoopKind kind) {
  return kind == LoopKind::fixed || kind == LoopKind::spherical || kind == LoopKind::revolute;
}

std::vector<Dof> said(const JointDescription& joint) {
  const JointInMjcf& in = *in_mjcf(joint.kind);
  std::vector<Dof> all = joint.dof;
  all.resize(static_cast<std::size_t>(traits(joint.kind).dof));
  const std::size_t first = std::min(in.first_shared, all.size());
  const Dof like = first < all.size() ? all[first] : Dof{};
  const bool alike =
      std::all_of(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(), [&](const Dof& dof) {
        return dof.damping == like.damping && dof.friction == like.friction &&
               dof.armature == like.armature && (!in.is_ball() || dof.stiffness == like.stiffness);
      });
  for (std::size_t k = 0; k < all.size(); ++k) {
    Dof& dof = all[k];
    dof.stop_stiffness = dof.stop_damping = dof.restitution = 0;
    dof.hard_stops = false;
    dof.velocity = std::numeric_limits<double>::infinity();
    if (!(dof.effort > 0) || (all.size() > 1 && !in.has_several_parts())) dof.effort = dof.velocity;
    if (all.size() == 1) continue;
    if (!in.has_several_parts()) {
      dof.lower = -dof.velocity;
      dof.upper = dof.velocity;
    }
    if (!alike && k >= first) dof.damping = dof.friction = dof.armature = 0;
    if (!in.is_ball() || !alike) dof.stiffness = 0;
    dof.rest = 0;
  }
  return all;
}

void joint_unsaid(const JointDescription& joint, const std::string& element, const Source& source,
                  Unsaid& unsaid) {
  const std::vector<Dof> written = said(joint);
  const auto check = [&](double Dof::*value, const std::string& what) {
    for (std::size_t k = 0; k < joint.dof.size(); ++k)
      if (joint.dof[k].*value != written[k].*value) return unsaid.leave_out(element, what, source);
  };
  const std::string several = joint.dof.size() > 1 ? " in degrees of freedom that differ" : "";
  check(&Dof::stop_stiffness, "has elastic stops");
  if (std::ranges::any_of(joint.dof, &Dof::hard_stops)) unsaid.leave_out(element, "has hard stops", source);
  check(&Dof::velocity, "has a largest velocity");
  check(&Dof::effort, "has a largest force that is 0 or of several degrees of freedom");
  check(&Dof::lower, "has a lower limit and several degrees of freedom");
  check(&Dof::upper, "has an upper limit and several degrees of freedom");
  check(&Dof::damping, "has damping" + several);
  check(&Dof::friction, "has friction" + several);
  check(&Dof::armature, "has armatures" + several);
  if (std::ranges::any_of(joint.dof, has_gear_losses))
    unsaid.leave_out(element, "has a gear with losses", source);
  check(&Dof::stiffness, in_mjcf(joint.kind)->is_ball()
                             ? "has springs" + several
                             : "is " + std::string(to_string(joint.kind)) + " and has a spring");
}

void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner, bool on_ground,
                   const Source& source, Unsaid& unsaid) {
  for (const ShapeDescription& shape : shapes) {
    if (shape.contact.restitution != 0)
      unsaid.leave_out(owner, "has a shape with the restitution " + to_text(shape.contact.restitution),
                       source);
    if (shape.contact.stiffness)
      unsaid.leave_out(owner, "has a shape with the stiffness " + to_text(*shape.contact.stiffness), source);
    if (has_words_for(shape, on_ground)) continue;
    if (shape.kind == ShapeKind::plane)
      unsaid.leave_out(owner, "has a plane, which MuJoCo knows on the world alone", source);
    else
      unsaid.leave_out(owner, "has a mesh of " + shape.file + ", which MuJoCo does not open", source);
  }
}

void contact_unsaid(const std::optional<ContactDescription>& contact, Unsaid& unsaid) {
  if (!contact) return;
  unsaid.leave_out("contact", "has a margin and a threshold", contact->source);
  for (const auto& [one, other] : contact->ignored)
    unsaid.leave_out("contact", "ignores bodies \"" + one + "\" and \"" + other + '"', contact->source);
}

bool has_words_for(const SpringDescription& spring) {
  const bool path = spring.kind == SpringKind::line || spring.kind == SpringKind::tendon;
  return path && !spring.curve && !spring.preload && spring.acts == Acts::both_ways;
}

void springs_and_couplings_unsaid(const Description& d, Unsaid& unsaid) {
  for (std::size_t k = 0; k < d.springs.size(); ++k) {
    const SpringDescription& it = d.springs[k];
    if (has_words_for(it)) continue;
    unsaid.leave_out(spring_element(it, k),
                     said_of(it) + (it.curve ? " with a law that is not linear" : "") +
                         (it.preload ? " with a preload" : "") +
                         (it.acts != Acts::both_ways ? ", one-sided" : ""),
                     it.source);
  }
  for (std::size_t k = 0; k < d.couplings.size(); ++k)
    if (d.couplings[k].play > 0)
      unsaid.leave_out("coupling \"" + coupling_name(d.couplings[k], k) + '"',
                       "has a play of " + to_text(d.couplings[k].play), d.couplings[k].source);
}

bool has_words_for(const ShapeDescription& shape, bool on_ground) {
  if (shape.kind == ShapeKind::plane) return on_ground;
  return shape.kind != ShapeKind::mesh || opens(shape.file);
}

std::string size_text(const ShapeDescription& shape) {
  const bool ball =
      shape.kind == ShapeKind::sphere || (shape.kind == ShapeKind::capsule && shape.length == 0);
  const auto with = [](std::string_view type, const std::string& size) {
    return attribute("type", std::string(type)) + attribute("size", size);
  };
  if (ball) return with("sphere", text(shape.radius));
  if (shape.kind == ShapeKind::box) return with("box", text(0.5 * shape.size));
  if (shape.kind == ShapeKind::ellipsoid) return with("ellipsoid", text(shape.size));
  if (shape.kind == ShapeKind::plane) return with("plane", "0 0 1");  // without bounds, and a grid of 1 m
  return with(to_string(shape.kind), text(shape.radius) + " " + text(0.5 * shape.length));
}

std::string friction_text(const ShapeDescription& shape, const std::optional<ContactDescription>& contact) {
  const ContactProperties& it = shape.contact;
  const bool rolling = it.rolling_friction != 0, spinning = it.spin_friction != 0;
  if (shape.role == ShapeDescription::Role::visual) return "";
  const double sliding = it.friction.value_or(contact.value_or(ContactDescription{}).friction);
  const std::string rows = rolling ? attribute("condim", "6") : spinning ? attribute("condim", "4") : "";
  return attribute("friction",
                   text(sliding) + " " + text(it.spin_friction) + " " + text(it.rolling_friction)) +
         rows;
}

std::string attribute(const char* name, const std::string& value) {
  return " " + std::string(name) + "=\"" + value + "\"";
}

std::string unless_zero(const char* name, double x) { return x == 0 ? "" : attribute(name, text(x)); }

std::string pose_text(const SE3<>& pose) {
  const Quaternion<> a = quaternion(pose.R);
  const bool turned = norm(Vec3<>{a.x, a.y, a.z}) > 0;
  return (norm(pose.r) > 0 ? attribute("pos", text(pose.r)) : "") +
         (turned ? attribute("quat", text(a.w) + " " + text(a.x) + " " + text(a.y) + " " + text(a.z)) : "");
}

std::string inertial_element(const MassProperties& given, const SE3<>& A) {
  const MassProperties in_body = expressed_in(given.in == GivenIn::body_frame ? SE3<>{} : A, given);
  Sym3<> Theta = rotate(in_body.axes, in_body.Theta);
  if (given.about == InertiaAbout::frame_origin && given.mass > 0)
    Theta = inertia_about_com(Inertia<>{in_body.mass, in_body.mass * in_body.com, Theta});
  // MuJoCo refuses principal moments below 1e-14, and a principal moment that exceeds the sum of the other
  // two by rounding.
  const EigenvalueRange moments = eigenvalue_range(Theta);
  const double least = 2e-14 + 1e-12 * moments.largest;
  const double more = std::max({0.0, least - moments.smallest, least - (trace(Theta) - 2 * moments.largest)});
  Theta.xx += more;
  Theta.yy += more;
  Theta.zz += more;
  std::string element =
      "<inertial" + attribute("pos", text(in_body.com)) + attribute("mass", text(in_body.mass));
  if (Theta.xy == 0 && Theta.xz == 0 && Theta.yz == 0) {
    element += attribute("diaginertia", text(Vec3<>{Theta.xx, Theta.yy, Theta.zz}));
  } else {
    element += attribute("fullinertia", text(Vec3<>{Theta.xx, Theta.yy, Theta.zz}) + " " +
                                            text(Vec3<>{Theta.xy, Theta.xz, Theta.yz}));
  }
  return element + "/>\n";
}

}  // namespace axode::io::mjcf
