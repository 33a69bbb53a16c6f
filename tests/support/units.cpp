#include "tests/support/units.hpp"

#include <cctype>
#include <cmath>
#include <map>
#include <stdexcept>

#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::test {
namespace {

using namespace dimension;

Dimension power(const Dimension& base, int n) { return {n * base.length, n * base.mass, n * base.time}; }

/// Whether velocity k of a joint of a kind has the unit of a length per time.
bool is_length(JointKind kind, std::size_t k) {
  if (const auto& chain = traits(kind).chain) return is_length(k == 0 ? chain->first : chain->second, 0);
  return with_subgroup(traits(kind).subgroup, 1.0,
                       [&](const auto& joint) { return norm(joint.column(static_cast<int>(k)).w) == 0; });
}
Dimension direction_of(JointKind kind, std::size_t k) { return is_length(kind, k) ? length : one; }

/// The dimension of the coordinate of each joint that has one velocity, by the name of the joint; cylindrical
/// and universal joints appear as their two parts.
std::map<std::string, Dimension> coordinates_by_name(const Description& description) {
  std::map<std::string, Dimension> all;
  for (const BodyDescription& body : expand(description).bodies)
    all[joint_name(body)] = direction_of(body.joint.kind, 0);
  return all;
}

/// Changes the units of all numbers of a degree of freedom whose coordinate has this dimension: limits,
/// armature and the coefficients of springs, stops and losses.
void scale(const Units& units, const Dimension& coordinate, Dof& dof) {
  const Dimension effort = energy / coordinate;
  dof.lower *= units(coordinate), dof.upper *= units(coordinate), dof.rest *= units(coordinate);
  dof.velocity *= units(coordinate * rate), dof.effort *= units(effort), dof.friction *= units(effort);
  dof.stiffness *= units(effort / coordinate), dof.stop_stiffness *= units(effort / coordinate);
  dof.damping *= units(effort / (coordinate * rate)), dof.stop_damping *= units(time / coordinate);
  dof.armature *= units(effort / (coordinate * rate * rate));
}

SE3<> scaled(double by, SE3<> C) {
  C.r = by * C.r;
  return C;
}

/// Changes the units of a curve of a spring whose coordinate has this dimension.
void scale(const Units& units, const Dimension& coordinate, ForceCurve& curve) {
  const Dimension effort = energy / coordinate;
  if (auto* polynomial = std::get_if<PolynomialCurve>(&curve)) {
    Dimension each = effort;
    for (double& x : polynomial->coefficients) x *= units(each), each = each / coordinate;
  } else if (auto* table = std::get_if<TableCurve>(&curve)) {
    for (double& x : table->deflections) x *= units(coordinate);
    for (double& x : table->forces) x *= units(effort);
  } else if (auto* gas = std::get_if<GasCurve>(&curve)) {
    gas->area *= units(length * length), gas->volume *= units(length * length * length);
    gas->pressure *= units(force / (length * length)), gas->ambient *= units(force / (length * length));
  }
}

/// Changes the units of a spring. The coordinate of a spring on joints is a pure number.
void scale(const Units& units, const std::map<std::string, Dimension>& coordinates,
           SpringDescription& spring) {
  const double l = units(length);
  const bool is_length = spring.kind == SpringKind::line || spring.kind == SpringKind::tendon;
  const Dimension coordinate = is_length ? length : one, effort = energy / coordinate;
  for (Vec3<>& point : spring.points) point = l * point;
  for (SpringDescription::Point& it : spring.path) it.point = l * it.point;
  for (SE3<>& C : spring.frames) C = scaled(l, C);
  spring.rest_pose = scaled(l, spring.rest_pose);
  for (auto& [joint, factor] : spring.terms) factor *= units(one / coordinates.at(joint));
  spring.rest *= units(coordinate);
  spring.stiffness *= units(effort / coordinate);
  spring.damping *= units(effort / (coordinate * rate));
  if (spring.curve) scale(units, coordinate, *spring.curve);
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t m = 0; m < 6; ++m) {
      const Dimension entry = energy / ((k < 3 ? one : length) * (m < 3 ? one : length));
      spring.K[k][m] *= units(entry);
      spring.C[k][m] *= units(entry / rate);
    }
}

}  // namespace

Dimension dimension_of(std::string_view unit) {
  static const std::map<std::string_view, Dimension> units{{"1", one},    {"rad", one},        {"m", length},
                                                           {"kg", mass},  {"s", time},         {"N", force},
                                                           {"J", energy}, {"W", energy * rate}};
  Dimension product;
  int sign = 1;
  bool in_parentheses = false;
  for (std::size_t k = 0; k < unit.size();) {
    const char c = unit[k];
    if (c == ' ' || c == '(' || c == ')' || c == '/') {
      if (c == '/') sign = -1;
      if (c == '(') in_parentheses = true;
      if (c == ')') in_parentheses = false, sign = 1;
      ++k;
      continue;
    }
    std::size_t end = k;
    while (end < unit.size() && std::isalnum(static_cast<unsigned char>(unit[end]))) ++end;
    const auto found = units.find(unit.substr(k, end - k));
    if (found == units.end()) throw std::logic_error("no unit: " + std::string(unit));
    int n = 1;
    if (end + 1 < unit.size() && unit[end] == '^') n = unit[end + 1] - '0', end += 2;
    product = product * power(found->second, sign * n);
    if (!in_parentheses) sign = 1;
    k = end;
  }
  return product;
}

double Units::operator()(const Dimension& d) const {
  const auto to = [](double base, int n) {
    double x = 1;
    for (int k = 0; k < std::abs(n); ++k) x *= base;
    return n < 0 ? 1 / x : x;
  };
  return to(length, d.length) * to(mass, d.mass) * to(time, d.time);
}

std::vector<Dimension> direction_dimensions(const Model& model) {
  std::vector<Dimension> all;
  for (const Joint& joint : model.joints())
    if (!joint.leader)
      for (int k = 0; k < joint.nv; ++k)
        all.push_back(
            with_subgroup<double>(joint.kind, joint.pitch, [&](const auto& j) { return j.angles; }) > k
                ? one
                : length);
  return all;
}
std::vector<Dimension> screw_dimensions(const Model& model) {
  std::vector<Dimension> all;
  for (const Joint& joint : model.joints())
    for (std::size_t k = 0; k < joint.dof.size(); ++k)
      all.push_back(with_subgroup<double>(joint.kind, joint.pitch, [&](const auto& j) { return j.angles; }) >
                            static_cast<int>(k)
                        ? one
                        : length);
  return all;
}
std::vector<Dimension> coordinate_dimensions(const Model& model) {
  std::vector<Dimension> all;
  for (const Joint& joint : model.joints()) {
    const int angles =
        with_subgroup<double>(joint.kind, joint.pitch, [&](const auto& j) { return j.angles; });
    for (int k = 0; k < joint.nq; ++k) all.push_back(k < angles + joint.nq - joint.nv ? one : length);
  }
  return all;
}

Description in_units(const Units& units, Description description) {
  const double l = units(length);
  const std::map<std::string, Dimension> coordinates = coordinates_by_name(description);
  description.gravity = units(acceleration) * description.gravity;
  for (BodyDescription& body : description.bodies) {
    JointDescription& joint = body.joint;
    if (joint.coupling) {
      const Dimension own = direction_of(joint.kind, 0);
      joint.coupling->ratio *= units(own / coordinates.at(joint.coupling->leader));
      joint.coupling->offset *= units(own);
    }
    joint.point = l * joint.point, joint.pitch *= l;
    for (std::size_t k = 0; k < joint.dof.size(); ++k)
      scale(units, direction_of(joint.kind, k), joint.dof[k]);
    if (auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) drawn->A = scaled(l, drawn->A);
    if (auto* in_body = std::get_if<InBodyFrame>(&body.geometry)) in_body->B = scaled(l, in_body->B);
    if (auto* in_joint = std::get_if<InJointFrames>(&body.geometry))
      in_joint->S_prev = scaled(l, in_joint->S_prev), in_joint->S_self = scaled(l, in_joint->S_self);
    if (body.inertia) {
      body.inertia->mass *= units(mass);
      body.inertia->com = l * body.inertia->com;
      body.inertia->Theta = units(mass * length * length) * body.inertia->Theta;
    }
  }
  for (FrameDescription& frame : description.frames) frame.pose = scaled(l, frame.pose);
  for (SpringDescription& spring : description.springs) scale(units, coordinates, spring);
  for (LoopDescription& loop : description.loops) {
    loop.point = l * loop.point, loop.center = l * loop.center, loop.pitch *= l;
    for (Vec3<>& point : loop.points) point = l * point;
    if (loop.frames)
      for (SE3<>& F : *loop.frames) F = scaled(l, F);
    if (loop.length) *loop.length *= l;
    if (loop.radius) *loop.radius *= l;
    for (double& radius : loop.radii) radius *= l;
  }
  for (CouplingDescription& coupling : description.couplings)
    for (auto& [joint, factor] : coupling.terms) factor *= units(one / coordinates.at(joint));
  return description;
}

std::vector<double> in_units(const Units& units, std::vector<double> x, const std::vector<Dimension>& each,
                             const Dimension& common) {
  for (std::size_t k = 0; k < x.size(); ++k) x[k] *= units(each[k] * common);
  return x;
}

Ask in_units(const Units& units, const Model& model, Ask ask) {
  const std::vector<Dimension> direction = direction_dimensions(model);
  std::vector<Dimension> effort;
  for (const Dimension& d : direction) effort.push_back(energy / d);
  ask.q = in_units(units, ask.q, coordinate_dimensions(model));
  ask.dq = in_units(units, ask.dq, direction);
  for (std::vector<double>* const x : {&ask.v, &ask.dv}) *x = in_units(units, *x, direction, rate);
  for (std::vector<double>* const x : {&ask.a, &ask.da}) *x = in_units(units, *x, direction, rate * rate);
  for (std::vector<double>* const x : {&ask.tau, &ask.dtau}) *x = in_units(units, *x, effort);
  ask.p = in_units(units, ask.p, effort, time);
  for (Place<>* const place : {&ask.place, &ask.base}) place->offset = scaled(units(length), place->offset);
  return ask;
}
State<double> in_units(const Units& units, const Model& model, State<double> state) {
  const Ask ask = in_units(units, model, Ask{.q = state.q, .v = state.v, .a = state.a});
  state.q = ask.q, state.v = ask.v, state.a = ask.a;
  for (AppliedWrench<>& W : state.wrenches) W.m = units(energy) * W.m, W.f = units(force) * W.f;
  return state;
}

}  // namespace axode::test
