#include "axode/model/inspection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/model/finite.hpp"
#include "axode/model/joint_kinds.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/nearest_name.hpp"
#include "axode/model/placement.hpp"
#include "axode/model/shape_kinds.hpp"

namespace axode {
namespace {

constexpr double rotation_tolerance = 1e-6;
constexpr double realisability_tolerance = 1e-9;

std::string quoted(std::string_view name) { return '"' + std::string(name) + '"'; }

class Inspection {
 public:
  Inspection(const Description& description, Strictness strictness)
      : description_(description), strictness_(strictness) {}

  std::vector<Fault> run() {
    faults_ = description_.warnings;
    if (!finite(description_.gravity))
      error(Rule::non_finite_number, "gravity", "a component is not finite; give three numbers in m/s²",
            description_.source);
    names();
    predecessors();
    for (const BodyDescription& body : description_.bodies) {
      if (numbers(body)) {
        joint(body);
        inertia(body);
      }
    }
    for (const ShapeDescription& it : description_.shapes) shape("the ground", it, description_.source);
    for (const FrameDescription& frame : description_.frames) {
      const std::string element = "frame " + quoted(frame.name);
      if (frame.body != "ground" && !bodies_.contains(frame.body))
        error(
            Rule::unknown_frame_body, element,
            "sits on body " + quoted(frame.body) + ", which is not described" + nearest_body(frame.body, ""),
            frame.source);
      rotation(element, "pose", frame.pose, frame.source);
    }
    for (std::size_t k = 0; k < description_.springs.size(); ++k)
      spring("spring " + std::to_string(k + 1), description_.springs[k]);
    for (std::size_t k = 0; k < description_.loops.size(); ++k) {
      const LoopDescription& told = description_.loops[k];
      loop("loop " + quoted(loop_name(told, k)), told);
    }
    couplings();
    return std::move(faults_);
  }

 private:
  void note(Severity severity, Rule rule, std::string element, std::string message, const Source& source) {
    faults_.push_back({severity, rule, std::move(element), std::move(message),
                       source.file.empty() ? Source{description_.source.file, source.line} : source});
  }
  void error(Rule rule, std::string element, std::string message, const Source& source) {
    note(Severity::error, rule, std::move(element), std::move(message), source);
  }
  void report_lenient(Rule rule, std::string element, std::string message, const Source& source) {
    note(strictness_ == Strictness::strict ? Severity::error : Severity::warning, rule, std::move(element),
         std::move(message), source);
  }
  /// A suggestion for a name that nothing has.
  template <class Range, class NameOf>
  std::string nearest(std::string_view name, const Range& range, NameOf name_of) {
    return ++suggestions_ > most_suggestions ? "" : did_you_mean(name, range, name_of);
  }
  std::string nearest_body(std::string_view name, std::string_view asked_by) {
    if (suggestions_ >= most_suggestions) return "";
    std::vector<std::string_view> names{"ground"};
    for (const BodyDescription& body : description_.bodies)
      if (body.name != asked_by) names.push_back(body.name);
    return nearest(name, names, [](std::string_view n) { return n; });
  }
  std::string nearest_frame(std::string_view name) {
    if (suggestions_ >= most_suggestions) return "";
    std::vector<std::string_view> names{"ground"};
    names.insert(names.end(), taken_.begin(), taken_.end());
    std::ranges::sort(names);
    return nearest(name, names, [](std::string_view n) { return n; });
  }

  void names() {
    std::unordered_set<std::string> joints;
    const auto joint_is_named = [&](const std::string& name, const Source& source) {
      if (!joints.insert(name).second)
        error(Rule::duplicate_name, "joint " + quoted(name), "the name is taken; names of joints must differ",
              source);
    };
    const auto body_name = [&](const std::string& name, const std::string& element, const Source& source) {
      if (name.empty()) {
        error(Rule::missing_name, element, "has no name; every body and frame needs one", source);
      } else if (name == "ground") {
        error(Rule::duplicate_name, element, "\"ground\" names the inertial frame; choose another name",
              source);
      } else if (!taken_.insert(name).second) {
        error(Rule::duplicate_name, element, "the name is taken; names of bodies and frames must differ",
              source);
      }
    };
    for (const BodyDescription& body : description_.bodies) {
      const auto [same, is_new] = bodies_.emplace(body.name, &body);
      if (!is_new && !body.name.empty() && same->second->predecessor != body.predecessor) {
        error(Rule::two_predecessors, "body " + quoted(body.name),
              "has two predecessors, " + quoted(same->second->predecessor) + " and " +
                  quoted(body.predecessor) + "; in a tree every body has one",
              body.source);
      } else {
        body_name(body.name, "body " + quoted(body.name), body.source);
      }
      if (body.joint.name.empty() && (body.name.empty() || !is_new)) continue;
      joint_is_named(joint_name(body), joint_source(body));
      const std::vector<BodyDescription> parts = expand({.bodies = {body}}).bodies;
      if (parts.size() == 1) continue;
      body_name(parts[0].name, "body " + quoted(parts[0].name) + " of joint " + quoted(joint_name(body)),
                joint_source(body));
      for (const BodyDescription& part : parts) joint_is_named(part.joint.name, joint_source(body));
    }
    for (const FrameDescription& frame : description_.frames)
      body_name(frame.name, "frame " + quoted(frame.name), frame.source);
    const auto loop_is_named = [&](const char* what, const std::string& name, const Source& source) {
      if (!joints.insert(name).second)
        error(Rule::duplicate_name, what + quoted(name),
              "the name is taken; names of joints, loops and couplings must differ", source);
    };
    for (std::size_t k = 0; k < description_.loops.size(); ++k)
      loop_is_named("loop ", loop_name(description_.loops[k], k), description_.loops[k].source);
    for (std::size_t k = 0; k < description_.couplings.size(); ++k)
      loop_is_named("coupling ", coupling_name(description_.couplings[k], k),
                    description_.couplings[k].source);
  }

  void predecessors() {
    for (const BodyDescription& body : description_.bodies)
      if (body.predecessor != "ground" && !bodies_.contains(body.predecessor))
        error(Rule::unknown_predecessor, "body " + quoted(body.name),
              "hangs on body " + quoted(body.predecessor) + ", which is not described" +
                  nearest_body(body.predecessor, body.name),
              body.source);
    cycles();
  }

  /// Follows predecessors from every body; a body met again on the same walk closes a cycle.
  void cycles() {
    std::unordered_map<std::string_view, const BodyDescription*> seen;  // body -> where its walk started
    for (const BodyDescription& start : description_.bodies) {
      const BodyDescription* at = &start;
      while (at != nullptr && !seen.contains(at->name)) {
        seen.emplace(at->name, &start);
        const auto next = at->predecessor == "ground" ? bodies_.end() : bodies_.find(at->predecessor);
        at = next == bodies_.end() ? nullptr : next->second;
      }
      if (at == nullptr || seen.at(at->name) != &start) continue;
      std::string chain = quoted(at->name);
      const BodyDescription* member = at;
      constexpr int most_shown = 8;
      int count = 0;
      do {
        member = bodies_.at(member->predecessor);
        if (++count < most_shown || member == at)
          chain += (count > most_shown ? " on ... on " : " on ") + quoted(member->name);
      } while (member != at);
      error(Rule::cycle, "body " + quoted(at->name),
            "closes a cycle: " + chain + "; every body must hang on the ground in the end", at->source);
    }
  }

  bool rotation(const std::string& element, const char* what, const SE3<>& C, const Source& source) {
    if (!finite(C)) {
      error(Rule::non_finite_number, element, std::string(what) + " is not finite", source);
      return false;
    }
    const SO3<> G = transpose(C.R) * C.R;
    const double off = std::max({std::abs(G.x.x - 1), std::abs(G.y.y - 1), std::abs(G.z.z - 1),
                                 std::abs(G.x.y), std::abs(G.x.z), std::abs(G.y.z)});
    const double handed = dot(cross(C.R.x, C.R.y), C.R.z);
    if (off <= rotation_tolerance && handed > 0) return true;
    error(Rule::not_a_rotation, element,
          handed >= 0 ? std::string(what) + " is off a rotation by " + to_text(off) +
                            "; RᵀR must be the identity to 1e-6"
                      : std::string(what) + " mirrors; a rotation has determinant +1",
          source);
    return false;
  }

  /// Whether every number of the body is finite and every pose one.
  bool numbers(const BodyDescription& body) {
    const std::string element = "body " + quoted(body.name), joint = "joint " + quoted(joint_name(body));
    bool good = true;
    const auto need = [&](bool is_finite, const std::string& where, const char* what) {
      if (is_finite) return;
      error(Rule::non_finite_number, where, std::string(what) + " is not finite",
            where == joint ? joint_source(body) : body.source);
      good = false;
    };
    need(finite(body.joint.axis), joint, "axis");
    need(finite(body.joint.second_axis), joint, "second axis");
    need(finite(body.joint.point), joint, "point");
    need(finite(body.joint.pitch), joint, "pitch");
    for (const Dof& dof : body.joint.dof) {
      need(!std::isnan(dof.lower) && !std::isnan(dof.upper), joint, "a limit");
      need(!std::isnan(dof.velocity) && !std::isnan(dof.effort), joint, "a limit");
      need(finite(dof.damping) && finite(dof.friction) && finite(dof.armature), joint,
           "damping, friction or armature");
      need(
          finite(dof.stiffness) && finite(dof.rest) && finite(dof.stop_stiffness) && finite(dof.stop_damping),
          joint, "a spring or stop");
    }
    if (body.joint.coupling)
      need(finite(body.joint.coupling->ratio) && finite(body.joint.coupling->offset), joint, "the coupling");
    if (const auto* drawn = std::get_if<InConstructionFrame>(&body.geometry)) {
      good &= rotation(element, "A", drawn->A, body.source);
    } else if (const auto* in_body = std::get_if<InBodyFrame>(&body.geometry)) {
      good &= rotation(element, "B", in_body->B, body.source);
    } else {
      const auto& frames = std::get<InJointFrames>(body.geometry);
      good &= rotation(joint, "S_prev", frames.S_prev, joint_source(body));
      good &= rotation(joint, "S_self", frames.S_self, joint_source(body));
    }
    if (body.inertia) {
      need(finite(body.inertia->mass), element, "mass");
      need(finite(body.inertia->com), element, "centre of mass");
      need(finite(body.inertia->Theta), element, "rotational inertia");
      good &= rotation(element, "the axes of the inertia", {body.inertia->axes, {}}, body.source);
    }
    for (const ShapeDescription& it : body.shapes) good &= shape(element, it, body.source);
    return good;
  }

  /// Whether every number of a shape is finite and its pose one. Sizes that nothing has are only doubtful.
  bool shape(const std::string& owner, const ShapeDescription& it, const Source& source) {
    const ShapeTraits& kind = traits(it.kind);
    const std::string of_it = " of a " + std::string(kind.name);
    bool good = rotation(owner, ("the pose" + of_it).c_str(), it.pose, source);
    const auto need = [&](bool is_finite, std::string what) {
      if (!is_finite) error(Rule::non_finite_number, owner, "the " + what + of_it + " is not finite", source);
      good &= is_finite;
    };
    need(finite(it.size), "size");
    need(finite(it.radius) && finite(it.length), "size");
    need(finite(it.scale), "scale");
    for (const double x : it.color.value_or(std::array<double, 4>{})) need(finite(x), "color");
    if (!good) return false;
    const auto positive = [&](std::string_view what, double x, bool may_be_zero = false) {
      if (x < 0 || (x == 0 && !may_be_zero))
        report_lenient(Rule::wrong_value, owner,
                       "the " + std::string(what) + of_it + " is " + to_text(x) + " m; it must be positive",
                       source);
    };
    if (!kind.size.empty()) positive(kind.size, std::min({it.size.x, it.size.y, it.size.z}));
    if (kind.radius) positive("radius", it.radius);
    if (kind.length) positive("length", it.length, it.kind == ShapeKind::capsule);
    if (it.color && std::ranges::any_of(*it.color, [](double x) { return x < 0 || x > 1; }))
      report_lenient(Rule::wrong_value, owner, "the color" + of_it + " is not between 0 and 1", source);
    return true;
  }

  static const Source& joint_source(const BodyDescription& body) {
    return body.joint.source.line > 0 ? body.joint.source : body.source;
  }

  /// Whether coordinate k of a joint is an angle with limits.
  static bool is_angle(JointKind kind, std::size_t k) {
    switch (kind) {
      case JointKind::revolute:
      case JointKind::helical:
      case JointKind::universal: return true;
      case JointKind::cylindrical:
      case JointKind::planar: return k == 0;
      default: return false;
    }
  }
  /// Doubts limits of more than two turns that are a round number of degrees.
  void angle_limits(const std::string& element, const Dof& dof, const Source& source) {
    constexpr double two_turns = 4 * std::numbers::pi, most = 720, round = 5;
    const auto looks_like_degrees = [](double x) {
      return std::abs(x) > two_turns && std::abs(x) <= most && std::fmod(x, round) == 0;
    };
    if (!looks_like_degrees(dof.lower) && !looks_like_degrees(dof.upper)) return;
    const auto in_radians = [](double x) { return to_text(x * (std::numbers::pi / 180)); };
    report_lenient(Rule::wrong_value, element,
                   "limits are " + to_text(dof.lower) + " and " + to_text(dof.upper) +
                       " rad, which look like degrees; as degrees they would be " + in_radians(dof.lower) +
                       " and " + in_radians(dof.upper) + " rad",
                   source);
  }

  void joint(const BodyDescription& body) {
    const JointDescription& joint = body.joint;
    const std::string element = "joint " + quoted(joint_name(body));
    const auto zero = [](const Vec3<>& axis) { return axis.x == 0 && axis.y == 0 && axis.z == 0; };
    if ((traits(joint.kind).axis && zero(joint.axis)) ||
        (joint.kind == JointKind::universal && zero(joint.second_axis))) {
      error(Rule::zero_axis, element, "an axis is (0, 0, 0); an axis needs a direction", joint_source(body));
    } else if (joint.kind == JointKind::universal) {
      const double sine = norm(cross(direction(joint.axis), direction(joint.second_axis)));
      if (sine < 1e-6)
        error(Rule::parallel_axes, element,
              "its two axes are parallel; those of a universal joint must not be", joint_source(body));
    }
    if (joint.pitch != 0 && joint.kind != JointKind::helical)
      error(Rule::pitch_without_helix, element,
            "has a pitch of " + to_text(joint.pitch) + " m/rad but is " + std::string(to_string(joint.kind)) +
                "; only helical joints have a pitch",
            joint_source(body));
    const int n = traits(joint.kind).dof;
    if (!joint.dof.empty() && static_cast<int>(joint.dof.size()) != n)
      error(Rule::degrees_of_freedom, element,
            "describes " + std::to_string(joint.dof.size()) + " degrees of freedom; a " +
                std::string(to_string(joint.kind)) + " joint has " + std::to_string(n),
            joint_source(body));
    for (std::size_t k = 0; k < joint.dof.size(); ++k)
      if (is_angle(joint.kind, k)) angle_limits(element, joint.dof[k], joint_source(body));
    for (const Dof& dof : joint.dof) {
      if (dof.lower > dof.upper)
        error(Rule::limits_crossed, element,
              "lower limit " + to_text(dof.lower) + " is above upper limit " + to_text(dof.upper),
              joint_source(body));
      constexpr double infinity = std::numeric_limits<double>::infinity();
      if (dof.lower <= dof.upper && (dof.lower == infinity || dof.upper == -infinity))
        error(Rule::limits_crossed, element,
              "limits " + to_text(dof.lower) + " and " + to_text(dof.upper) + " leave no place to be",
              joint_source(body));
      const std::array<std::pair<const char*, double>, 8> not_negative{
          {{"velocity limit", dof.velocity},
           {"effort limit", dof.effort},
           {"damping", dof.damping},
           {"friction", dof.friction},
           {"armature", dof.armature},
           {"stiffness of the spring", dof.stiffness},
           {"stiffness of the stops", dof.stop_stiffness},
           {"damping of the stops", dof.stop_damping}}};
      for (const auto& [what, value] : not_negative)
        if (value < 0)
          error(Rule::negative_value, element,
                std::string(what) + " is " + to_text(value) + "; it must not be negative",
                joint_source(body));
      springs(joint, dof, element, joint_source(body));
    }
  }

  /// What a spring and stops ask of their joint.
  void springs(const JointDescription& joint, const Dof& dof, const std::string& element,
               const Source& source) {
    const bool stops = dof.stop_stiffness != 0 || dof.stop_damping != 0;
    const int velocities =
        with_subgroup(traits(joint.kind).subgroup, 0.0, [](const auto& s) { return s.nv; });
    const std::string a_kind =
        "a " + std::string(to_string(joint.kind)) + " joint has several velocities that move together";
    if (velocities > 1 && dof.rest != 0)
      error(Rule::wrong_value, element,
            "a spring is at rest at " + to_text(dof.rest) + "; " + a_kind +
                ", and its spring rests as drawn, at 0",
            source);
    if (velocities > 1 && stops) {
      error(Rule::wrong_value, element, "has stops; " + a_kind + " and has no limits to stop at", source);
    } else if (stops && !std::isfinite(dof.lower) && !std::isfinite(dof.upper)) {
      error(Rule::wrong_value, element, "has stops but no limits; they act beyond the limits", source);
    }
  }

  void spring(const std::string& element, const SpringDescription& spring) {
    for (const std::string& name : spring.between) {
      if (name != "ground" && !taken_.contains(name))
        error(Rule::unknown_spring_frame, element,
              "ends on " + quoted(name) + ", which is neither a body nor a frame" + nearest_frame(name),
              spring.source);
    }
    if (!finite(spring.points[0]) || !finite(spring.points[1]) || !finite(spring.stiffness) ||
        !finite(spring.rest) || !finite(spring.damping))
      error(Rule::non_finite_number, element, "a point, stiffness, rest or damping is not finite",
            spring.source);
    const std::array<std::pair<const char*, double>, 3> not_negative{
        {{"stiffness", spring.stiffness}, {"rest", spring.rest}, {"damping", spring.damping}}};
    for (const auto& [what, value] : not_negative)
      if (value < 0)
        error(Rule::negative_value, element,
              std::string(what) + " is " + to_text(value) + "; it must not be negative", spring.source);
  }

  void loop(const std::string& element, const LoopDescription& loop) {
    for (const std::string& name : loop.between) {
      if (name != "ground" && !taken_.contains(name))
        error(Rule::unknown_loop_frame, element,
              "is between " + quoted(loop.between[0]) + " and " + quoted(loop.between[1]) + "; " +
                  quoted(name) + " is neither a body nor a frame" + nearest_frame(name),
              loop.source);
    }
    const auto wrong = [&](Rule rule, std::string message) {
      error(rule, element, std::move(message), loop.source);
    };
    bool good = finite(loop.axis) && finite(loop.second_axis) && finite(loop.point) && finite(loop.pitch) &&
                finite(loop.points[0]) && finite(loop.points[1]) && finite(loop.center) &&
                finite(loop.wheel_axis.value_or(Vec3<>{}));
    for (const std::optional<double>& size : {loop.length, loop.radius, loop.angle})
      good = good && finite(size.value_or(0));
    if (!good) return wrong(Rule::non_finite_number, "a number is not finite");
    const LoopTraits& kind = traits(loop.kind);
    const bool helical = kind.has("pitch");
    if (!helical && loop.pitch != 0)
      wrong(Rule::pitch_without_helix, "has a pitch of " + to_text(loop.pitch) + " m/rad but is " +
                                           std::string(to_string(loop.kind)) +
                                           "; only helical joints have a pitch");
    if (helical && loop.pitch == 0)
      wrong(Rule::wrong_value, "has the pitch 0; make it revolute, or give a pitch in m/rad");
    if (kind.has("angle") && loop.angle && std::abs(std::sin(*loop.angle)) < 1e-6)
      wrong(Rule::parallel_axes, "the angle between its axes is " + to_text(*loop.angle) +
                                     "; those of a universal joint must not be parallel");
    for (const auto& [what, size] : {std::pair{"length", loop.length}, std::pair{"radius", loop.radius}})
      if (size && !(*size > 0))
        wrong(Rule::wrong_value, std::string(what) + " is " + to_text(*size) + " m; it must be positive");
    if (loop.frames) {
      rotation(element, "the first frame", (*loop.frames)[0], loop.source);
      rotation(element, "the second frame", (*loop.frames)[1], loop.source);
      if (kind.has("length") && !loop.length)
        wrong(Rule::missing_element, "has no length; a rod between frames needs one, m");
      if (kind.has("radius") && !loop.radius)
        wrong(Rule::missing_element, "has no radius; what rolls between frames needs one, m");
      return;
    }
    const auto zero = [](const Vec3<>& axis) { return axis.x == 0 && axis.y == 0 && axis.z == 0; };
    const bool wheel = kind.has("wheel_axis") && loop.wheel_axis, universal = kind.has("second_axis");
    if ((kind.has("axis") && zero(loop.axis)) || (universal && zero(loop.second_axis)) ||
        (wheel && zero(*loop.wheel_axis)))
      return wrong(Rule::zero_axis, "an axis is (0, 0, 0); an axis needs a direction");
    if (universal && norm(cross(direction(loop.axis), direction(loop.second_axis))) < 1e-6)
      wrong(Rule::parallel_axes, "its two axes are parallel; those of a universal joint must not be");
    if (wheel && norm(cross(direction(loop.axis), direction(*loop.wheel_axis))) < 1e-6)
      wrong(Rule::parallel_axes, "the wheel lies flat on the plane; its axis must not be the normal");
    if (kind.has("points") && !(norm(loop.points[1] - loop.points[0]) > 0) && !loop.length)
      wrong(Rule::wrong_value, "its points are the same; a rod needs a length");
    if (kind.has("center") && !(std::abs(dot(direction(loop.axis), loop.center - loop.point)) > 0))
      wrong(Rule::wrong_value, "its centre lies in the plane; what rolls needs a radius");
  }

  void inertia(const BodyDescription& body) {
    if (!body.inertia) return;
    const MassProperties& given = *body.inertia;
    const std::string element = "body " + quoted(body.name);
    if (given.mass < 0) {
      error(Rule::mass_not_positive, element,
            "mass is " + to_text(given.mass) + " kg; a mass must be positive", body.source);
    } else if (given.mass == 0) {
      report_lenient(Rule::mass_not_positive, element,
                     "mass is 0; a mass must be positive, and a massless body needs no mass at all",
                     body.source);
    } else {
      // The axes and the choice of frame do not matter to what a density can produce.
      const double worst = realisability(inertia_in({}, given));
      if (worst < -realisability_tolerance)
        report_lenient(
            Rule::inertia_not_realisable, element,
            "no density can produce its inertia: a principal moment about the centre of mass exceeds the sum "
            "of the other two by " +
                to_text(std::round(-2e4 * worst) / 100) + " % of the largest, or is negative",
            body.source);
    }
  }

  void couplings() {
    std::unordered_map<std::string, const BodyDescription*> joints;
    const Description expanded = expand(description_);
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, &body);
    std::unordered_map<const BodyDescription*, bool> ends_in_loop;
    const auto follows_a_loop = [&](const BodyDescription* at) {
      std::vector<const BodyDescription*> walk;
      bool loop = false;
      while (at != nullptr && at->joint.coupling) {
        const auto [known, is_new] = ends_in_loop.emplace(at, true);  // true until the walk finds its end
        if (!is_new) {
          loop = known->second;
          break;
        }
        walk.push_back(at);
        const auto next = joints.find(at->joint.coupling->leader);
        at = next == joints.end() ? nullptr : next->second;
      }
      for (const BodyDescription* body : walk) ends_in_loop[body] = loop;
      return loop;
    };
    for (const BodyDescription& body : description_.bodies) {
      if (!body.joint.coupling) continue;
      const std::string element = "joint " + quoted(joint_name(body));
      const std::string& leader = body.joint.coupling->leader;
      if (!can_couple(body.joint.kind)) {
        error(Rule::coupling_kind, element,
              "is " + std::string(to_string(body.joint.kind)) +
                  " and coupled; only revolute, prismatic and helical joints can follow another joint",
              joint_source(body));
        continue;
      }
      const auto found = joints.find(leader);
      if (found == joints.end()) {
        error(Rule::coupling_unknown_joint, element,
              "follows joint " + quoted(leader) + ", which is not described" +
                  nearest(leader, expanded.bodies, [](const BodyDescription& b) { return b.joint.name; }),
              joint_source(body));
      } else if (!can_couple(found->second->joint.kind)) {
        error(Rule::coupling_kind, element,
              "follows joint " + quoted(leader) + ", which is " +
                  std::string(to_string(found->second->joint.kind)) +
                  "; only revolute, prismatic and helical joints can lead",
              joint_source(body));
      } else if (follows_a_loop(found->second)) {
        error(Rule::coupling_loop, element,
              "follows joint " + quoted(leader) + " in a loop; one joint must have a coordinate of its own",
              joint_source(body));
      }
    }
    for (std::size_t k = 0; k < description_.couplings.size(); ++k) {
      const CouplingDescription& coupling = description_.couplings[k];
      const std::string element = "coupling " + quoted(coupling_name(coupling, k));
      if (coupling.terms.empty())
        error(Rule::missing_element, element, "has no terms; name joints and their factors", coupling.source);
      if (!finite(coupling.offset))
        error(Rule::non_finite_number, element, "its offset is not finite", coupling.source);
      std::unordered_set<std::string_view> named;
      for (const auto& [name, factor] : coupling.terms) {
        if (!named.insert(name).second)
          error(Rule::duplicate_element, element,
                "has two terms of joint " + quoted(name) + "; add up their factors", coupling.source);
        if (!finite(factor) || factor == 0)
          error(finite(factor) ? Rule::wrong_value : Rule::non_finite_number, element,
                "the factor of joint " + quoted(name) + " is " + to_text(factor) +
                    "; it must be a number other than 0",
                coupling.source);
        const auto found = joints.find(name);
        if (found == joints.end()) {
          error(Rule::coupling_unknown_joint, element,
                "has a term of joint " + quoted(name) + ", which is not described" +
                    nearest(name, expanded.bodies, [](const BodyDescription& b) { return b.joint.name; }),
                coupling.source);
        } else if (!can_couple(found->second->joint.kind)) {
          error(Rule::coupling_kind, element,
                "has a term of joint " + quoted(name) + ", which is " +
                    std::string(to_string(found->second->joint.kind)) +
                    "; only revolute, prismatic and helical joints can be coupled",
                coupling.source);
        }
      }
    }
  }

  const Description& description_;
  Strictness strictness_;
  std::vector<Fault> faults_;
  int suggestions_ = 0;
  std::unordered_map<std::string, const BodyDescription*> bodies_;
  std::unordered_set<std::string> taken_;
};

}  // namespace

std::vector<Fault> inspect(const Description& description, Strictness strictness) {
  return Inspection(description, strictness).run();
}

}  // namespace axode
