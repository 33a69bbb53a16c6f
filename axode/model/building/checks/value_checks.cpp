#include "axode/model/building/checks/value_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <utility>

#include "axode/model/building/placement.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "axode/model/loops.hpp"

namespace axode {

void not_negative(const FaultySubject& at, std::initializer_list<std::pair<std::string, double>> values) {
  for (const auto& [what, value] : values)
    if (value < 0)
      at.error(Rule::negative_value, what + " is " + to_text(value) + "; it must not be negative");
}

std::optional<std::string> degrees_complaint(std::string_view subject, std::span<const double> angles) {
  constexpr double two_turns = 4 * std::numbers::pi, most = 720, round = 5, degree = std::numbers::pi / 180;
  const auto looks_like_degrees = [](double x) {
    return std::abs(x) > two_turns && std::abs(x) <= most && std::fmod(x, round) == 0;
  };
  if (std::ranges::none_of(angles, looks_like_degrees)) return std::nullopt;
  const auto list = [&](double unit) {
    std::string text;
    for (std::size_t k = 0; k < angles.size(); ++k)
      text += (k == 0 ? "" : k + 1 == angles.size() ? " and " : ", ") + to_text(angles[k] * unit);
    return text + " rad";
  };
  return std::string(subject) + " " + list(1) + ", which look like degrees; as degrees they would be " +
         list(degree);
}

namespace {

constexpr double rotation_tolerance = 1e-6;
constexpr double realisability_tolerance = 1e-9;

bool zero(const Vec3<>& axis) { return axis.x == 0 && axis.y == 0 && axis.z == 0; }
bool parallel(const Vec3<>& a, const Vec3<>& b) { return norm(cross(direction(a), direction(b))) < 1e-6; }

/// Reports limits of an angle (rad) that look like degrees.
void angle_limits(const FaultySubject& at, const Dof& dof) {
  if (const auto complaint = degrees_complaint("limits are", std::array{dof.lower, dof.upper}))
    at.report_lenient(Rule::wrong_value, *complaint);
}

void warn_of_friction(const FaultySubject& at, const std::string& what, double mu) {
  if (mu > most_friction)
    at.warning(Rule::wrong_value, what + " is " + to_text(mu) + "; contact counts more than " +
                                      to_text(most_friction) + " as " + to_text(most_friction));
}
void is_restitution(const FaultySubject& at, const std::string& what, double value) {
  if (value < 0 || value > 1)
    at.error(Rule::wrong_value, what + " is " + to_text(value) + "; it must be between 0 and 1");
}

/// Checks the stiffness of a surface.
void compliance(const FaultySubject& at, const std::string& of_it, const ContactProperties& contact) {
  if (!contact.stiffness) {
    if (contact.damping != 0)
      at.error(Rule::wrong_value, "the damping" + of_it + " is " + to_text(contact.damping) +
                                      " s/m, and it has no stiffness; only a compliant surface has damping");
    return;
  }
  if (!(*contact.stiffness > 0))
    at.error(Rule::wrong_value, "the stiffness" + of_it + " is " + to_text(*contact.stiffness) +
                                    "; it must be positive, and is left out for a rigid surface");
  if (!(contact.exponent >= 1 && contact.exponent <= 10))
    at.error(Rule::wrong_value, "the exponent" + of_it + " is " + to_text(contact.exponent) +
                                    "; that of the force k d^n must be between 1 and 10");
  not_negative(at, {{"the damping" + of_it, contact.damping}});
  if (contact.restitution != 0)
    at.error(Rule::wrong_value, "the restitution" + of_it + " is " + to_text(contact.restitution) +
                                    ", and it has a stiffness; a compliant surface bounces by its damping");
}

/// Reports springs and stops that a degree of freedom `dof` cannot have. Stops must not be both hard and
/// elastic, and need limits. A joint of several velocities cannot have stops, nor springs with a rest
/// position other than 0.
void springs(const FaultySubject& at, const JointDescription& joint, const Dof& dof) {
  const bool elastic = dof.stop_stiffness != 0 || dof.stop_damping != 0;
  const bool stops = elastic || dof.hard_stops;
  if (elastic && dof.hard_stops)
    at.error(Rule::wrong_value, "has stops that are hard and elastic; choose one of both");
  if (dof.restitution != 0 && !dof.hard_stops)
    at.error(Rule::wrong_value,
             "has a restitution of " + to_text(dof.restitution) + " but no hard stops; only these have one");
  is_restitution(at, "restitution of the stops", dof.restitution);
  const int velocities = with_subgroup(traits(joint.kind).subgroup, 0.0, [](const auto& s) { return s.nv; });
  const std::string a_kind =
      "a " + std::string(to_string(joint.kind)) + " joint has several velocities that move together";
  if (velocities > 1 && dof.rest != 0)
    at.error(Rule::wrong_value, "a spring is at rest at " + to_text(dof.rest) + "; " + a_kind +
                                    ", and its spring rests as drawn, at 0");
  if (velocities > 1 && stops) {
    at.error(Rule::wrong_value, "has stops; " + a_kind + " and has no limits to stop at");
  } else if (stops && !std::isfinite(dof.lower) && !std::isfinite(dof.upper)) {
    at.error(Rule::wrong_value, "has stops but no limits; they act beyond the limits");
  }
}

/// Reports gear losses that a degree of freedom `dof` cannot have. A joint of several velocities, a coupled
/// joint and a passive joint (without a drive) cannot have any, and a self-locking gear needs an armature.
void gear(const FaultySubject& at, const JointDescription& joint, const Dof& dof) {
  if (dof.gear_loss == 0 && !dof.gear_loss_back) return;
  const double back = dof.gear_loss_back.value_or(dof.gear_loss);
  const std::string has = dof.gear_loss != 0 ? "has a gear_loss of " + to_text(dof.gear_loss)
                                             : "has a gear_loss_back of " + to_text(back);
  not_negative(at, {{"gear_loss", dof.gear_loss}, {"gear_loss_back", dof.gear_loss_back.value_or(0)}});
  if (with_subgroup(traits(joint.kind).subgroup, 0.0, [](const auto& s) { return s.nv; }) > 1)
    at.error(Rule::wrong_value, has + ", and a " + std::string(to_string(joint.kind)) +
                                    " joint has several velocities that move together; a gear drives one");
  if (joint.coupling)
    at.error(Rule::wrong_value, has + " and follows joint " + quoted(joint.coupling->leader) +
                                    ", whose drive moves it; give the loss to that joint");
  if (joint.passive.value_or(false))
    at.error(Rule::wrong_value, has + " and is passive; a gear stands between a drive and its joint");
  if (back >= 1 && dof.armature == 0)
    at.error(
        Rule::wrong_value,
        "gear_loss_back is " + to_text(back) +
            " and the armature is 0; a gear that locks itself, from 1 on, needs the inertia of its drive");
}

}  // namespace

bool check_pose(const FaultySubject& at, const std::string& what, const SE3<>& C) {
  if (!finite(C)) {
    at.error(Rule::non_finite_number, what + " is not finite");
    return false;
  }
  const SO3<> G = transpose(C.R) * C.R;
  const double off = std::max({std::abs(G.x.x - 1), std::abs(G.y.y - 1), std::abs(G.z.z - 1), std::abs(G.x.y),
                               std::abs(G.x.z), std::abs(G.y.z)});
  const double handed = dot(cross(C.R.x, C.R.y), C.R.z);
  if (off <= rotation_tolerance && handed > 0) return true;
  at.error(Rule::not_a_rotation,
           handed >= 0 ? what + " is off a rotation by " + to_text(off) + "; RᵀR must be the identity to 1e-6"
                       : what + " mirrors; a rotation has determinant +1");
  return false;
}

/// Checks the numbers of a body, its joint and its shapes. Returns whether all of them are finite (limits may
/// be infinite) and the rotation matrices of all poses are orthonormal.
bool check_numbers(const BodyDescription& body, FaultCollector& faults) {
  const FaultySubject in_body{faults, "body " + quoted(body.name), body.source};
  const FaultySubject in_joint{faults, "joint " + quoted(joint_name(body)), joint_source(body)};
  bool good = true;
  const auto need = [&](bool is_finite, const FaultySubject& at, const std::string& what) {
    if (!is_finite) at.error(Rule::non_finite_number, what + " is not finite");
    good &= is_finite;
  };
  const JointDescription& joint = body.joint;
  need(finite(joint.axis), in_joint, "axis");
  need(finite(joint.second_axis), in_joint, "second axis");
  need(finite(joint.point), in_joint, "point");
  need(finite(joint.pitch), in_joint, "pitch");
  for (const Dof& dof : joint.dof) {
    need(!std::isnan(dof.lower) && !std::isnan(dof.upper), in_joint, "a limit");
    need(!std::isnan(dof.velocity) && !std::isnan(dof.effort), in_joint, "a limit");
    need(finite(dof.damping) && finite(dof.friction) && finite(dof.armature), in_joint,
         "damping, friction or armature");
    need(finite(dof.gear_loss) && finite(dof.gear_loss_back.value_or(0)), in_joint, "the loss of a gear");
    need(finite(dof.stiffness) && finite(dof.rest) && finite(dof.stop_stiffness) &&
             finite(dof.stop_damping) && finite(dof.restitution),
         in_joint, "a spring or stop");
  }
  if (joint.coupling)
    need(finite(joint.coupling->ratio) && finite(joint.coupling->offset), in_joint, "the coupling");
  if (const auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) {
    good &= check_pose(in_body, "A", drawn->A);
  } else if (const auto* frame = std::get_if<InBodyFrame>(&body.geometry)) {
    good &= check_pose(in_body, "B", frame->B);
  } else {
    const auto& frames = std::get<InJointFrames>(body.geometry);
    good &= check_pose(in_joint, "S_prev", frames.S_prev);
    good &= check_pose(in_joint, "S_self", frames.S_self);
  }
  if (body.inertia) {
    need(finite(body.inertia->mass), in_body, "mass");
    need(finite(body.inertia->com), in_body, "centre of mass");
    need(finite(body.inertia->Theta), in_body, "rotational inertia");
    good &= check_pose(in_body, "the axes of the inertia", {body.inertia->axes, {}});
  }
  for (const ShapeDescription& it : body.shapes) good &= check_shape(in_body, it);
  return good;
}

/// Checks a shape. Returns whether its numbers are finite and the rotation matrix of its pose is orthonormal.
/// Sizes that are not positive and colours outside 0 to 1 are errors only if the check is strict.
bool check_shape(const FaultySubject& at, const ShapeDescription& it) {
  const ShapeTraits& kind = traits(it.kind);
  const std::string of_it = " of a " + std::string(kind.name);
  bool good = check_pose(at, "the pose" + of_it, it.pose);
  const auto need = [&](bool is_finite, const std::string& what) {
    if (!is_finite) at.error(Rule::non_finite_number, "the " + what + of_it + " is not finite");
    good &= is_finite;
  };
  need(finite(it.size), "size");
  need(finite(it.radius) && finite(it.length), "size");
  need(finite(it.scale), "scale");
  for (const double x : it.color.value_or(std::array<double, 4>{})) need(finite(x), "color");
  const ContactProperties& contact = it.contact;
  need(finite(contact.friction.value_or(0)) && finite(contact.spin_friction) &&
           finite(contact.rolling_friction),
       "friction");
  need(finite(contact.restitution), "restitution");
  need(finite(contact.stiffness.value_or(1)) && finite(contact.exponent) && finite(contact.damping),
       "stiffness, its exponent or damping");
  if (!good) return false;
  not_negative(at, {{"the friction" + of_it, contact.friction.value_or(0)},
                    {"the friction against spinning" + of_it, contact.spin_friction},
                    {"the friction against rolling" + of_it, contact.rolling_friction}});
  for (const double mu : {contact.friction.value_or(0), contact.spin_friction, contact.rolling_friction})
    warn_of_friction(at, "a friction" + of_it, mu);
  is_restitution(at, "the restitution" + of_it, contact.restitution);
  compliance(at, of_it, contact);
  const auto positive = [&](std::string_view what, double x, bool may_be_zero = false) {
    if (x < 0 || (x == 0 && !may_be_zero))
      at.report_lenient(Rule::wrong_value,
                        "the " + std::string(what) + of_it + " is " + to_text(x) + " m; it must be positive");
  };
  if (!kind.size.empty()) positive(kind.size, std::min({it.size.x, it.size.y, it.size.z}));
  if (kind.radius) positive("radius", it.radius);
  if (kind.length) positive("length", it.length, it.kind == ShapeKind::capsule);
  if (it.color && std::ranges::any_of(*it.color, [](double x) { return x < 0 || x > 1; }))
    at.report_lenient(Rule::wrong_value, "the color" + of_it + " is not between 0 and 1");
  return true;
}

void check_joint(const BodyDescription& body, FaultCollector& faults) {
  const JointDescription& joint = body.joint;
  const std::string kind(to_string(joint.kind));
  const FaultySubject at{faults, "joint " + quoted(joint_name(body)), joint_source(body)};
  const bool second = traits(joint.kind).has("second_axis");
  if ((traits(joint.kind).has("axis") && zero(joint.axis)) || (second && zero(joint.second_axis))) {
    at.error(Rule::zero_axis, "an axis is (0, 0, 0); an axis needs a direction");
  } else if (second && parallel(joint.axis, joint.second_axis)) {
    at.error(Rule::parallel_axes,
             "its two axes are parallel; the axes of a " + kind + " joint must not be parallel");
  }
  if (joint.pitch != 0 && !traits(joint.kind).has("pitch"))
    at.error(Rule::pitch_without_helix, "has a pitch of " + to_text(joint.pitch) + " m/rad but is " + kind +
                                            "; only helical joints have a pitch");
  const int n = traits(joint.kind).dof;
  if (!joint.dof.empty() && static_cast<int>(joint.dof.size()) != n)
    at.error(Rule::degrees_of_freedom, "describes " + std::to_string(joint.dof.size()) +
                                           " degrees of freedom; a " + kind + " joint has " +
                                           std::to_string(n));
  const std::size_t angles = static_cast<std::size_t>(traits(joint.kind).angles);
  for (std::size_t k = 0; k < std::min(angles, joint.dof.size()); ++k) angle_limits(at, joint.dof[k]);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const Dof& dof : joint.dof) {
    if (dof.lower > dof.upper)
      at.error(Rule::limits_crossed,
               "lower limit " + to_text(dof.lower) + " is above upper limit " + to_text(dof.upper));
    if (dof.lower <= dof.upper && (dof.lower == infinity || dof.upper == -infinity))
      at.error(Rule::limits_crossed,
               "limits " + to_text(dof.lower) + " and " + to_text(dof.upper) +
                   " allow no position; the lower limit must be below inf and the upper one above -inf");
    not_negative(at, {{"velocity limit", dof.velocity},
                      {"effort limit", dof.effort},
                      {"damping", dof.damping},
                      {"friction", dof.friction},
                      {"armature", dof.armature},
                      {"stiffness of the spring", dof.stiffness},
                      {"stiffness of the stops", dof.stop_stiffness},
                      {"damping of the stops", dof.stop_damping}});
    springs(at, joint, dof);
    gear(at, joint, dof);
  }
}

void check_inertia(const BodyDescription& body, FaultCollector& faults) {
  if (!body.inertia) return;
  const MassProperties& given = *body.inertia;
  const FaultySubject at{faults, "body " + quoted(body.name), body.source};
  if (given.mass < 0) {
    at.error(Rule::mass_not_positive, "mass is " + to_text(given.mass) + " kg; a mass must be positive");
  } else if (given.mass == 0) {
    at.report_lenient(Rule::mass_not_positive,
                      "mass is 0; a mass must be positive, and a massless body needs no mass at all");
  } else {
    // The test whether a density can produce an inertia gives the same result in all axes and frames.
    const double worst = realisability(inertia_in({}, given));
    if (worst < -realisability_tolerance)
      at.report_lenient(Rule::inertia_not_realisable,
                        "no density can produce its inertia: a principal moment about the centre of mass "
                        "exceeds the sum "
                        "of the other two by " +
                            to_text(std::round(-2e4 * worst) / 100) + " % of the largest, or is negative");
  }
}

bool are_finite(const FaultySubject& at, std::initializer_list<std::pair<const char*, double>> values) {
  const auto bad = std::ranges::find_if_not(values, [](const auto& value) { return finite(value.second); });
  if (bad == values.end()) return true;
  at.error(Rule::non_finite_number,
           std::string(bad->first) + " is " + to_text(bad->second) + "; it must be finite");
  return false;
}
bool are_finite(const FaultySubject& at, std::initializer_list<std::pair<const char*, Vec3<>>> values) {
  const auto bad = std::ranges::find_if_not(values, [](const auto& value) { return finite(value.second); });
  if (bad == values.end()) return true;
  const auto& [key, x] = *bad;
  at.error(Rule::non_finite_number, std::string(key) + " is (" + to_text(x.x) + ", " + to_text(x.y) + ", " +
                                        to_text(x.z) + "); it must be finite");
  return false;
}
bool are_finite(const FaultySubject& at, const std::string& key, std::span<const double> values) {
  for (std::size_t k = 0; k < values.size(); ++k)
    if (!finite(values[k])) {
      at.error(Rule::non_finite_number,
               key + "[" + std::to_string(k) + "] is " + to_text(values[k]) + "; it must be finite");
      return false;
    }
  return true;
}

void check_loop(const FaultySubject& at, const LoopDescription& loop) {
  if (!are_finite(at, {{"axis", loop.axis},
                       {"second_axis", loop.second_axis},
                       {"point", loop.point},
                       {"points[0]", loop.points[0]},
                       {"points[1]", loop.points[1]},
                       {"center", loop.center},
                       {"wheel_axis", loop.wheel_axis.value_or(Vec3<>{})}}) ||
      !are_finite(at, {{"pitch", loop.pitch},
                       {"length", loop.length.value_or(0)},
                       {"radius", loop.radius.value_or(0)},
                       {"angle", loop.angle.value_or(0)},
                       {"radii[0]", loop.radii[0]},
                       {"radii[1]", loop.radii[1]}}))
    return;
  const LoopTraits& kind = traits(loop.kind);
  const bool helical = kind.has("pitch");
  if (!helical && loop.pitch != 0)
    at.error(Rule::pitch_without_helix, "has a pitch of " + to_text(loop.pitch) + " m/rad but is " +
                                            std::string(to_string(loop.kind)) +
                                            "; only helical joints have a pitch");
  if (helical && loop.pitch == 0)
    at.error(Rule::wrong_value, "has the pitch 0; make it revolute, or give a pitch in m/rad");
  if (kind.has("angle") && loop.angle && std::abs(std::sin(*loop.angle)) < 1e-6)
    at.error(Rule::parallel_axes, "the angle between its axes is " + to_text(*loop.angle) +
                                      "; the axes of a universal joint must not be parallel");
  for (const auto& [what, size] : {std::pair{"length", loop.length}, std::pair{"radius", loop.radius}})
    if (size && !(*size > 0))
      at.error(Rule::wrong_value, std::string(what) + " is " + to_text(*size) + " m; it must be positive");
  if (kind.has("radii") && (loop.radii[0] == 0 || loop.radii[1] == 0))
    at.error(Rule::wrong_value, "a pulley has the radius 0; give both radii in m, with their signs");
  if (loop.frames) {
    check_pose(at, "the first frame", (*loop.frames)[0]);
    check_pose(at, "the second frame", (*loop.frames)[1]);
    if (kind.has("length") && !loop.length)
      at.error(Rule::missing_element, "has no length; a rod between frames needs one, m");
    if (kind.has("radius") && !loop.radius)
      at.error(Rule::missing_element, "has no radius; a rolling body between frames needs one, m");
    return;
  }
  const bool wheel = kind.has("wheel_axis") && loop.wheel_axis, universal = kind.has("second_axis");
  if ((kind.has("axis") && zero(loop.axis)) || (universal && zero(loop.second_axis)) ||
      (wheel && zero(*loop.wheel_axis)))
    return at.error(Rule::zero_axis, "an axis is (0, 0, 0); an axis needs a direction");
  if (universal && parallel(loop.axis, loop.second_axis))
    at.error(Rule::parallel_axes,
             "its two axes are parallel; the axes of a universal joint must not be parallel");
  if (wheel && parallel(loop.axis, *loop.wheel_axis))
    at.error(Rule::parallel_axes, "the wheel lies flat on the plane; its axis must not be the normal");
  if (kind.has("radii")) {
    const Vec3<> n = direction(loop.axis), d = loop.points[1] - loop.points[0];
    const double distance = norm(d - dot(d, n) * n), most = std::abs(loop.radii[1] - loop.radii[0]);
    if (!(distance > most))
      at.error(Rule::wrong_value, "the axes of its pulleys are " + to_text(distance) +
                                      " m apart; a belt with these radii has a span if they are more than " +
                                      to_text(most) + " m apart");
    return;
  }
  if (kind.has("points") && !(norm(loop.points[1] - loop.points[0]) > 0) && !loop.length)
    at.error(Rule::wrong_value, "its two points coincide; a rod needs a length");
  if (kind.has("center") && !(std::abs(dot(direction(loop.axis), loop.center - loop.point)) > 0))
    at.error(Rule::wrong_value, "its centre lies in the plane; a rolling contact needs a radius");
}

void check_play(const FaultySubject& at, const CouplingDescription& coupling) {
  if (!are_finite(at, {{"play", coupling.play}, {"restitution", coupling.restitution}})) return;
  not_negative(at, {{"its play", coupling.play}});
  is_restitution(at, "its restitution", coupling.restitution);
  if (coupling.restitution != 0 && coupling.play == 0)
    at.error(Rule::wrong_value, "has a restitution of " + to_text(coupling.restitution) +
                                    " but no play; only the ends of a play have one");
}

void check_motion(const FaultySubject& at, const MotionDescription& motion) {
  if (!are_finite(at, {{"offset", motion.offset},
                       {"amplitude", motion.amplitude},
                       {"frequency", motion.frequency},
                       {"phase", motion.phase},
                       {"from", motion.from},
                       {"to", motion.to},
                       {"start", motion.start},
                       {"end", motion.end}}) ||
      !are_finite(at, "coefficients", motion.coefficients) || !are_finite(at, "times", motion.times) ||
      !are_finite(at, "values", motion.values))
    return;
  switch (motion.kind) {
    case MotionDescription::Kind::harmonic: return;
    case MotionDescription::Kind::ramp:
      if (!(motion.end > motion.start))
        at.error(Rule::wrong_value, "its end is at " + to_text(motion.end) + " s and its start at " +
                                        to_text(motion.start) + " s; a ramp ends after it starts");
      return;
    case MotionDescription::Kind::polynomial:
      if (motion.coefficients.empty())
        at.error(Rule::missing_element, "has no coefficients; give those of 1, t, t^2, ...");
      return;
    case MotionDescription::Kind::samples: break;
  }
  if (motion.times.size() != motion.values.size() || motion.times.size() < 2)
    return at.error(Rule::wrong_value, "has " + std::to_string(motion.times.size()) + " times and " +
                                           std::to_string(motion.values.size()) +
                                           " values; it needs two samples or more, each with both");
  for (std::size_t k = 1; k < motion.times.size(); ++k)
    if (!(motion.times[k] > motion.times[k - 1]))
      return at.error(Rule::wrong_value, "has the time " + to_text(motion.times[k]) + " s after " +
                                             to_text(motion.times[k - 1]) + " s; times must increase");
}

void check_joint_state(const FaultySubject& at, const char* what, const JointDescription& joint,
                       std::span<const double> numbers, bool positions) {
  const std::string says = std::string(what) + " of joint " + quoted(joint.name);
  if (joint.kind == JointKind::fixed)
    return at.error(Rule::wrong_value, says + " has no meaning: a fixed joint does not move");
  if (joint.coupling)
    return at.error(Rule::wrong_value, says + " has no meaning: it follows joint " +
                                           quoted(joint.coupling->leader) + "; give that one");
  const auto [nq, nv] = with_subgroup(traits(joint.kind).subgroup, joint.pitch,
                                      [](const auto& s) { return std::pair<int, int>(s.nq, s.nv); });
  const int needed = positions ? nq : nv;
  const bool has_quaternion = positions && nq > nv;
  if (std::ssize(numbers) != needed)
    return at.error(Rule::degrees_of_freedom,
                    says + " has " + std::to_string(numbers.size()) +
                        (numbers.size() == 1 ? " number" : " numbers") + "; a " +
                        std::string(to_string(joint.kind)) + " joint takes " + std::to_string(needed) +
                        (has_quaternion ? ", of which the first four are a quaternion x, y, z, w" : ""));
  for (const double x : numbers)
    if (!finite(x))
      return at.error(Rule::non_finite_number, says + " is " + to_text(x) + "; it must be finite");
  if (!has_quaternion) return;
  const double norm = std::hypot(std::hypot(numbers[0], numbers[1]), std::hypot(numbers[2], numbers[3]));
  if (!(std::abs(norm - 1) <= rotation_tolerance))
    at.error(Rule::not_a_rotation, says + " has a quaternion of norm " + to_text(norm) +
                                       "; it must be 1 to 1e-6, and its order is x, y, z, w");
}

void check_contact(const FaultySubject& at, const ContactDescription& contact) {
  if (!are_finite(
          at, {{"friction", contact.friction}, {"margin", contact.margin}, {"threshold", contact.threshold}}))
    return;
  not_negative(
      at, {{"friction", contact.friction}, {"margin", contact.margin}, {"threshold", contact.threshold}});
  warn_of_friction(at, "friction", contact.friction);
}

}  // namespace axode
