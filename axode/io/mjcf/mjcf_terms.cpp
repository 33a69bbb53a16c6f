#include "axode/io/mjcf/mjcf_terms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "axode/io/xml_text.hpp"
#include "axode/lie/quaternion.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/joint_kinds.hpp"
#include "axode/model/loops.hpp"

namespace axode::io::mjcf {
namespace {

using xml::text;

/// Whether MuJoCo can open a mesh file: it must be a path, not a URL, and have an ending that MuJoCo knows.
bool opens(const std::string& file) {
  if (file.find("://") != std::string::npos) return false;
  const std::size_t dot = file.rfind('.');
  std::string ending = dot == std::string::npos ? "" : file.substr(dot);
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return ending == ".stl" || ending == ".obj" || ending == ".msh";
}

}  // namespace

bool in_mjcf(LoopKind kind) {
  return kind == LoopKind::fixed || kind == LoopKind::spherical || kind == LoopKind::revolute;
}

std::vector<Dof> said(const JointDescription& joint) {
  const bool ball = joint.kind == JointKind::spherical, planar = joint.kind == JointKind::planar;
  std::vector<Dof> all = joint.dof;
  all.resize(static_cast<std::size_t>(traits(joint.kind).dof));
  const std::size_t first = planar ? 1 : 0;  // first of those that share numbers
  const Dof like = all.empty() ? Dof{} : all[std::min(first, all.size() - 1)];
  const bool alike = std::all_of(
      all.begin() + static_cast<std::ptrdiff_t>(std::min(first, all.size())), all.end(), [&](const Dof& dof) {
        return dof.damping == like.damping && dof.friction == like.friction &&
               dof.armature == like.armature && (!ball || dof.stiffness == like.stiffness);
      });
  for (std::size_t k = 0; k < all.size(); ++k) {
    Dof& dof = all[k];
    dof.stop_stiffness = dof.stop_damping = 0;
    dof.velocity = std::numeric_limits<double>::infinity();
    if (!(dof.effort > 0) || (all.size() > 1 && !planar)) dof.effort = dof.velocity;
    if (all.size() == 1) continue;
    if (!planar) {
      dof.lower = -dof.velocity;
      dof.upper = dof.velocity;
    }
    if (!alike && k >= first) dof.damping = dof.friction = dof.armature = 0;
    if (!ball || !alike) dof.stiffness = 0;
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
  check(&Dof::velocity, "has a largest velocity");
  check(&Dof::effort, "has a largest force that is 0 or of several degrees of freedom");
  check(&Dof::lower, "has a lower limit and several degrees of freedom");
  check(&Dof::upper, "has an upper limit and several degrees of freedom");
  check(&Dof::damping, "has damping" + several);
  check(&Dof::friction, "has friction" + several);
  check(&Dof::armature, "has armatures" + several);
  check(&Dof::stiffness, joint.kind == JointKind::spherical
                             ? "has springs" + several
                             : "is " + std::string(to_string(joint.kind)) + " and has a spring");
}

void shapes_unsaid(const std::vector<ShapeDescription>& shapes, const std::string& owner,
                   const Source& source, Unsaid& unsaid) {
  for (const ShapeDescription& shape : shapes)
    if (!has_words_for(shape))
      unsaid.leave_out(owner, "has a mesh of " + shape.file + ", which MuJoCo does not open", source);
}

bool has_words_for(const ShapeDescription& shape) {
  return shape.kind != ShapeKind::mesh || opens(shape.file);
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
