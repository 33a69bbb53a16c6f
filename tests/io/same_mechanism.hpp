#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "axode/io.hpp"

/// The difference between two models.
namespace axode::test {

inline double disparity(const Vec3<>& a, const Vec3<>& b) { return norm(a - b) / std::max(1.0, norm(a)); }
inline double disparity(const SE3<>& a, const SE3<>& b) {
  return std::max(
      {disparity(a.R.x, b.R.x), disparity(a.R.y, b.R.y), disparity(a.R.z, b.R.z), disparity(a.r, b.r)});
}
inline double disparity(const Screw<>& a, const Screw<>& b) {
  return std::max(disparity(a.w, b.w), disparity(a.v, b.v));
}
inline double disparity(const Inertia<>& a, const Inertia<>& b) {
  const Sym3<> d = a.Theta - b.Theta;
  const double scale = std::max({1.0, a.m, trace(a.Theta)});
  return std::max({std::abs(a.m - b.m), norm(a.h - b.h), norm(Vec3<>{d.xx, d.yy, d.zz}),
                   norm(Vec3<>{d.xy, d.xz, d.yz})}) /
         scale;
}

inline bool same(const Dof& a, const Dof& b) {
  return a.lower == b.lower && a.upper == b.upper && a.velocity == b.velocity && a.effort == b.effort &&
         a.damping == b.damping && a.friction == b.friction && a.armature == b.armature &&
         a.stiffness == b.stiffness && a.rest == b.rest && a.stop_stiffness == b.stop_stiffness &&
         a.stop_damping == b.stop_damping && a.gear_loss == b.gear_loss &&
         a.gear_loss_back == b.gear_loss_back;
}

/// The pose of every frame in the inertial frame at q = 0, by the name of the frame.
inline std::map<std::string, SE3<>> frames_at_zero(const Model& model) {
  std::map<std::string, SE3<>> poses;
  for (const Frame& frame : model.frames()) poses[frame.name] = model.body(frame.body).A * frame.pose;
  return poses;
}

/// The difference of two lists of loops: of the frames of loop joints at q = 0, and of their numbers.
inline double disparity(const Loops& one, const Loops& other, const Model& a, const Model& b) {
  const double infinity = std::numeric_limits<double>::infinity();
  if (one.joints.size() != other.joints.size() || one.couplings.size() != other.couplings.size() ||
      one.driven != other.driven)
    return infinity;
  double largest = 0;
  for (std::size_t k = 0; k < one.joints.size(); ++k) {
    const Loop &x = one.joints[k], &y = other.joints[k];
    if (x.name != y.name || x.kind != y.kind || x.pitch != y.pitch || x.wheel != y.wheel ||
        x.first_row != y.first_row)
      return infinity;
    largest = std::max(largest, std::abs(x.size - y.size));
    for (std::size_t e = 0; e < 2; ++e) largest = std::max(largest, std::abs(x.radii[e] - y.radii[e]));
    for (std::size_t e = 0; e < 2; ++e) {
      const auto &end = x.ends[e], &its = y.ends[e];
      if (end.body != its.body) return infinity;
      const Body &body = a.body(end.body), &same_body = b.body(its.body);
      largest =
          std::max(largest, disparity(body.A * body.S_self * end.F, same_body.A * same_body.S_self * its.F));
    }
  }
  if (one.backlashes.size() != other.backlashes.size()) return infinity;
  for (std::size_t k = 0; k < one.backlashes.size(); ++k) {
    const Backlash &x = one.backlashes[k], &y = other.backlashes[k];
    if (x.name != y.name || x.play != y.play || x.restitution != y.restitution ||
        x.terms.size() != y.terms.size())
      return infinity;
    largest = std::max(largest, std::abs(x.offset - y.offset));
  }
  for (std::size_t k = 0; k < one.couplings.size(); ++k) {
    const LoopCoupling &x = one.couplings[k], &y = other.couplings[k];
    if (x.name != y.name || x.first_row != y.first_row || x.terms.size() != y.terms.size()) return infinity;
    largest = std::max(largest, std::abs(x.offset - y.offset));
    std::vector<double> factors(a.nv());  // one for each velocity, because the terms may have another order
    for (const LoopCoupling::Term& term : x.terms) factors[term.velocity] += term.factor;
    for (const LoopCoupling::Term& term : y.terms) factors[term.velocity] -= term.factor;
    for (const double left : factors) largest = std::max(largest, std::abs(left));
  }
  return largest;
}

/// The difference of two springs: of their points, poses and rests,
/// which may come from a preload, and infinite if anything else differs.
inline double disparity(const Spring& one, const Spring& other, const Model& a, const Model& b) {
  const double infinity = std::numeric_limits<double>::infinity();
  const ForceLaw &law = one.law, &its_law = other.law;
  if (one.name != other.name || one.geometry.index() != other.geometry.index() ||
      law.curve.index() != its_law.curve.index() || law.damping != its_law.damping ||
      law.acts != its_law.acts || law.slopes != its_law.slopes)
    return infinity;
  for (const double x : {-1.1, 0.3}) {
    const double f = curve_value(law, x).f, its_f = curve_value(its_law, x).f;
    if (f != its_f && !(std::isnan(f) && std::isnan(its_f)))
      return infinity;  // a gas may have no volume there
  }
  double largest = std::abs(law.rest - its_law.rest);
  const auto on = [&](int f, int g) { return a.frame(f).name == b.frame(g).name; };
  if (const auto* path = std::get_if<Spring::Path>(&one.geometry)) {
    const auto& its = std::get<Spring::Path>(other.geometry).points;
    if (path->points.size() != its.size()) return infinity;
    for (std::size_t k = 0; k < its.size(); ++k) {
      if (!on(path->points[k].frame, its[k].frame)) return infinity;
      largest = std::max(largest, disparity(path->points[k].point, its[k].point));
    }
    return largest;
  }
  if (const auto* joints = std::get_if<Spring::JointSum>(&one.geometry)) {
    const auto& its = std::get<Spring::JointSum>(other.geometry);
    std::vector<double> factors(a.nv());  // one for each velocity, because the terms may have another order
    for (const Spring::JointSum::Term& term : joints->terms) factors[term.velocity] += term.factor;
    for (const Spring::JointSum::Term& term : its.terms) factors[term.velocity] -= term.factor;
    for (const double left : factors) largest = std::max(largest, std::abs(left));
    return std::max(largest, std::abs(joints->offset - its.offset));
  }
  const auto ends = [&](const std::array<Spring::End, 2>& x, const std::array<Spring::End, 2>& y) {
    double most = 0;
    for (std::size_t e = 0; e < 2; ++e)
      most = std::max(most, on(x[e].frame, y[e].frame) ? disparity(x[e].pose, y[e].pose) : infinity);
    return most;
  };
  if (const auto* torsion = std::get_if<Spring::Torsion>(&one.geometry)) {
    const auto &x = torsion->ends, &y = std::get<Spring::Torsion>(other.geometry).ends;
    return std::max(largest, ends(x, y));
  }
  const auto &x = std::get<Spring::Bushing>(one.geometry), &y = std::get<Spring::Bushing>(other.geometry);
  if (x.K != y.K || x.C != y.C) return infinity;
  return std::max(ends(x.ends, y.ends), disparity(x.rest, y.rest));
}

enum class Compare {
  everything,
  named_frames,  ///< bodies may have other names and frames; every frame name of the first model exists in
                 ///< the second one
};

/// The largest difference of reference poses, joint screws, inertias, frames and gravity, relative for
/// numbers larger than 1. It is infinite if names, kinds, limits, couplings or the order differ.
inline double disparity(const Model& a, const Model& b, Compare compare = Compare::everything) {
  const double infinity = std::numeric_limits<double>::infinity();
  if (a.n_bodies() != b.n_bodies() || a.nq() != b.nq() || a.nv() != b.nv()) return infinity;
  double largest = disparity(a.gravity(), b.gravity());
  const auto note = [&](double d) { largest = std::max(largest, std::isnan(d) ? infinity : d); };
  const bool all = compare == Compare::everything;
  if (a.name() != b.name()) return infinity;
  for (int i = 0; i <= a.n_bodies(); ++i) {
    const Body &x = a.body(i), &y = b.body(i);
    if (x.predecessor != y.predecessor) return infinity;
    if (all && x.name != y.name) return infinity;
    const SE3<> to_zero_x = x.A, to_zero_y = y.A;
    if (all) note(disparity(x.A, y.A));
    if (all) note(disparity(x.M, y.M));
    note(disparity(transform(to_zero_x, x.M), transform(to_zero_y, y.M)));
    if (i == 0) continue;
    const Joint &j = a.joint(i), &k = b.joint(i);
    if (j.name != k.name || j.kind != k.kind || j.passive != k.passive || j.iq != k.iq || j.iv != k.iv ||
        j.dof.size() != k.dof.size())
      return infinity;
    for (std::size_t d = 0; d < j.dof.size(); ++d)
      if (!same(j.dof[d], k.dof[d])) return infinity;
    if (j.leader.has_value() != k.leader.has_value()) return infinity;
    if (j.leader && (j.leader->joint != k.leader->joint || j.leader->ratio != k.leader->ratio ||
                     j.leader->offset != k.leader->offset))
      return infinity;
    note(std::abs(j.pitch - k.pitch));
    for (std::size_t c = 0; c < x.X.size(); ++c) note(disparity(Ad(x.A, x.X[c]), Ad(y.A, y.X[c])));
  }
  if (a.springs().elements.size() != b.springs().elements.size()) return infinity;
  for (std::size_t k = 0; k < a.springs().elements.size(); ++k)
    note(disparity(a.springs().elements[k], b.springs().elements[k], a, b));
  note(disparity(a.loops(), b.loops(), a, b));
  const auto mine = frames_at_zero(a), theirs = frames_at_zero(b);
  if (all && mine.size() != theirs.size()) return infinity;
  for (const auto& [name, pose] : mine) {
    const auto found = theirs.find(name);
    if (found == theirs.end()) return infinity;
    note(disparity(pose, found->second));
  }
  return largest;
}

inline std::string drawing_of(const Model& model) {
  std::ostringstream text;
  write_drawing(model, text);
  return text.str();
}
inline std::string urdf_of(const Model& model) {
  std::ostringstream text;
  write_urdf(model, text);
  return text.str();
}

}  // namespace axode::test
