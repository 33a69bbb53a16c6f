#include "axode/model/building/inspection.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "axode/model/building/checks/drive_checks.hpp"
#include "axode/model/building/checks/spring_checks.hpp"
#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/finite.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode {
namespace {

/// The kinds of joints with one velocity, such as "revolute, prismatic and helical" for last = " and ".
std::string kinds_with_one_velocity(std::string_view last) {
  std::vector<std::string_view> names;
  for (const JointTraits& kind : joint_kinds)
    if (can_couple(kind.kind)) names.push_back(kind.name);
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k)
    text.append(k == 0 ? "" : k + 1 < names.size() ? ", " : last).append(names[k]);
  return text;
}

class Inspection {
 public:
  Inspection(const Description& description, Strictness strictness)
      : description_(description), faults_{description, strictness} {}

  std::vector<Fault> run() {
    if (!finite(description_.gravity))
      error(Rule::non_finite_number, "gravity", "a component is not finite; give three numbers in m/s²",
            description_.source);
    names();
    predecessors();
    for (const BodyDescription& body : description_.bodies) {
      if (check_numbers(body, faults_)) {
        check_joint(body, faults_);
        check_inertia(body, faults_);
      }
    }
    for (const ShapeDescription& it : description_.shapes)
      check_shape({faults_, "the ground", description_.source}, it);
    for (const FrameDescription& frame : description_.frames) {
      const FaultySubject at{faults_, "frame " + quoted(frame.name), frame.source};
      if (frame.body != "ground" && !bodies_.contains(frame.body))
        at.error(Rule::unknown_frame_body, "sits on body " + quoted(frame.body) + ", which is not described" +
                                               nearest_body(frame.body, ""));
      check_pose(at, "pose", frame.pose);
    }
    springs();
    for (std::size_t k = 0; k < description_.loops.size(); ++k) {
      const LoopDescription& it = description_.loops[k];
      loop({faults_, "loop " + quoted(loop_name(it, k)), it.source}, it);
    }
    couplings();
    if (!description_.motions.empty()) motions();
    if (!description_.drives.empty()) drives();
    if (description_.state) state(*description_.state);
    if (description_.contact) contact(*description_.contact);
    return std::move(faults_.all);
  }

 private:
  void error(Rule rule, std::string element, std::string message, const Source& source) {
    faults_.note(Severity::error, rule, std::move(element), std::move(message), source);
  }
  /// A text `; did you mean ...?` with the name in `range` nearest to an unknown name, or an empty text.
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

  void contact(const ContactDescription& it) {
    const FaultySubject at{faults_, "contact", it.source};
    check_contact(at, it);
    for (const auto& pair : it.ignored) {
      for (const std::string& name : pair)
        if (name != "ground" && !bodies_.contains(name))
          at.error(Rule::unknown_frame_body,
                   "ignores body " + quoted(name) + ", which is not described" + nearest_body(name, ""));
      if (pair[0] == pair[1])
        at.error(Rule::wrong_value,
                 "ignores " + quoted(pair[0]) + " and itself; shapes on one body do not touch anyway");
    }
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

  /// Reports cycles of predecessors, the bodies that are met twice on a walk from predecessor to predecessor.
  void cycles() {
    std::unordered_map<std::string_view, const BodyDescription*> seen;  // for each body that was met:
                                                                        // the start of the first such walk
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

  void springs() {
    std::unordered_set<std::string> names;
    const bool on_joints = std::ranges::any_of(
        description_.springs, [](const SpringDescription& it) { return traits(it.kind).has("terms"); });
    const Description expanded = on_joints ? expand(description_) : Description{};
    std::unordered_map<std::string, JointKind> joints;
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, body.joint.kind);
    for (std::size_t k = 0; k < description_.springs.size(); ++k) {
      const SpringDescription& it = description_.springs[k];
      const std::string name = spring_name(it, k);
      const FaultySubject at{faults_, spring_element(it, k), it.source};
      if (!names.insert(name).second)
        at.error(Rule::duplicate_name, "the name is taken; names of springs must differ");
      spring(at, it, joints, expanded);
    }
  }

  void spring(const FaultySubject& at, const SpringDescription& spring,
              const std::unordered_map<std::string, JointKind>& joints, const Description& expanded) {
    const auto ends_on = [&](const std::string& name) {
      if (name != "ground" && !taken_.contains(name))
        at.error(Rule::unknown_spring_frame,
                 "ends on " + quoted(name) + ", which is neither a body nor a frame" + nearest_frame(name));
    };
    const SpringTraits& kind = traits(spring.kind);
    if (kind.has("between"))
      for (const std::string& name : spring.between) ends_on(name);
    if (kind.has("path"))
      for (const SpringDescription::Point& point : spring.path) ends_on(point.on);
    if (kind.has("terms")) {
      if (spring.terms.empty())
        at.error(Rule::missing_element, "has no terms; name joints and their factors");
      std::unordered_set<std::string_view> named;
      for (const auto& [name, factor] : spring.terms) {
        const std::string says = "has a term of joint " + quoted(name);
        if (!named.insert(name).second) at.error(Rule::duplicate_element, says + " twice");
        if (factor == 0)
          at.error(Rule::wrong_value, says + " with the factor 0; it must be a number other than 0");
        if (const auto found = joints.find(name); found == joints.end())
          at.error(Rule::coupling_unknown_joint,
                   says + ", which is not described" + nearest_joint(name, expanded));
        else if (!can_couple(found->second))
          at.error(Rule::coupling_kind, says + ", which is " + std::string(to_string(found->second)) +
                                            "; a spring acts on " + kinds_with_one_velocity(" and ") +
                                            " joints");
      }
    }
    check_spring(at, spring);
  }

  void loop(const FaultySubject& at, const LoopDescription& loop) {
    for (const std::string& name : loop.between) {
      if (name != "ground" && !taken_.contains(name))
        at.error(Rule::unknown_loop_frame, "is between " + quoted(loop.between[0]) + " and " +
                                               quoted(loop.between[1]) + "; " + quoted(name) +
                                               " is neither a body nor a frame" + nearest_frame(name));
    }
    check_loop(at, loop);
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
        const auto [known, is_new] = ends_in_loop.emplace(at, true);  // true while the walk goes on
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
    const auto named_joint = [&](const FaultySubject& at, const std::string& says, const std::string& name,
                                 std::string_view role) -> const BodyDescription* {
      const auto found = joints.find(name);
      if (found == joints.end()) {
        at.error(Rule::coupling_unknown_joint, says + " joint " + quoted(name) + ", which is not described" +
                                                   nearest_joint(name, expanded));
        return nullptr;
      }
      const JointKind kind = found->second->joint.kind;
      if (can_couple(kind)) return found->second;
      at.error(Rule::coupling_kind,
               says + " joint " + quoted(name) + ", which is " + std::string(to_string(kind)) + "; only " +
                   kinds_with_one_velocity(" and ") + " joints can " + std::string(role));
      return nullptr;
    };
    for (const BodyDescription& body : description_.bodies) {
      if (!body.joint.coupling) continue;
      const FaultySubject at{faults_, "joint " + quoted(joint_name(body)), joint_source(body)};
      const std::string& leader = body.joint.coupling->leader;
      if (!can_couple(body.joint.kind)) {
        at.error(Rule::coupling_kind, "is " + std::string(to_string(body.joint.kind)) +
                                          " and coupled; only " + kinds_with_one_velocity(" and ") +
                                          " joints can follow another joint");
        continue;
      }
      const BodyDescription* leads = named_joint(at, "follows", leader, "lead");
      if (leads != nullptr && follows_a_loop(leads))
        at.error(Rule::coupling_loop, "follows joint " + quoted(leader) +
                                          " in a loop; one joint must have a coordinate of its own");
    }
    for (std::size_t k = 0; k < description_.couplings.size(); ++k) {
      const CouplingDescription& coupling = description_.couplings[k];
      const FaultySubject at{faults_, "coupling " + quoted(coupling_name(coupling, k)), coupling.source};
      if (coupling.terms.empty())
        at.error(Rule::missing_element, "has no terms; name joints and their factors");
      if (!finite(coupling.offset)) at.error(Rule::non_finite_number, "its offset is not finite");
      check_play(at, coupling);
      std::unordered_set<std::string_view> named;
      for (const auto& [name, factor] : coupling.terms) {
        if (!named.insert(name).second)
          at.error(Rule::duplicate_element,
                   "has two terms of joint " + quoted(name) + "; add up their factors");
        if (!finite(factor) || factor == 0)
          at.error(finite(factor) ? Rule::wrong_value : Rule::non_finite_number,
                   "the factor of joint " + quoted(name) + " is " + to_text(factor) +
                       "; it must be a number other than 0");
        named_joint(at, "has a term of", name, "be coupled");
      }
    }
  }

  void state(const InitialStateDescription& state) {
    const FaultySubject at{faults_, "state", state.source};
    const Description expanded = expand(description_);
    std::unordered_map<std::string, const JointDescription*> joints, chains;
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, &body.joint);
    for (const BodyDescription& body : description_.bodies) chains.emplace(joint_name(body), &body.joint);
    const auto check = [&](const char* what, const auto& entries, bool positions) {
      std::unordered_set<std::string_view> named;
      for (const auto& [name, numbers] : entries) {
        const std::string says = std::string(what) + " names joint " + quoted(name);
        if (!named.insert(name).second) at.error(Rule::duplicate_element, says + " twice");
        if (const auto found = joints.find(name); found != joints.end()) {
          check_joint_state(at, what, *found->second, numbers, positions);
        } else if (const auto chain = chains.find(name); chain != chains.end()) {
          at.error(Rule::unknown_state_joint,
                   says + ", which is " + std::string(to_string(chain->second->kind)) +
                       " and becomes two joints; name one of these" + nearest_joint(name, expanded));
        } else {
          at.error(Rule::unknown_state_joint,
                   says + ", which is not described" + nearest_joint(name, expanded));
        }
      }
    };
    check("q", state.q, true);
    check("v", state.v, false);
  }
  void motions() {
    const Description expanded = expand(description_);
    std::unordered_map<std::string, JointKind> joints;
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, body.joint.kind);
    std::unordered_map<std::string, LoopKind> loops;
    for (std::size_t k = 0; k < description_.loops.size(); ++k)
      loops.emplace(loop_name(description_.loops[k], k), description_.loops[k].kind);
    std::unordered_set<std::string_view> moved;
    std::unordered_set<std::string> names;
    for (const auto& [name, kind] : joints) names.insert(name);
    for (const auto& [name, kind] : loops) names.insert(name);
    for (std::size_t k = 0; k < description_.couplings.size(); ++k)
      names.insert(coupling_name(description_.couplings[k], k));
    for (const MotionDescription& motion : description_.motions) {
      const FaultySubject at{faults_, quoted(motion_name(motion)), motion.source};
      const std::string says = "moves " + quoted(motion.of);
      if (!names.insert(motion_name(motion)).second)
        at.error(Rule::duplicate_name,
                 "the name is taken; names of motions must differ, also from those of joints, loops and "
                 "couplings");
      if (const auto joint = joints.find(motion.of); joint != joints.end()) {
        if (!can_couple(joint->second))
          at.error(Rule::degrees_of_freedom,
                   says + ", which is " + std::string(to_string(joint->second)) + "; a motion prescribes a " +
                       kinds_with_one_velocity(" or ") + " joint, or the length of a rod");
      } else if (const auto loop = loops.find(motion.of); loop != loops.end()) {
        if (!traits(loop->second).has("length"))
          at.error(Rule::degrees_of_freedom, says + ", a loop that is " +
                                                 std::string(to_string(loop->second)) +
                                                 "; a motion prescribes a joint or the length of a rod");
      } else {
        at.error(Rule::unknown_motion_target,
                 says + ", which is neither a joint nor a rod" + nearest_joint(motion.of, expanded));
      }
      if (!moved.insert(motion.of).second)
        at.error(Rule::duplicate_element, says + ", which another motion moves; it can follow one");
      check_motion(at, motion);
    }
  }
  void drives() {
    const Description expanded = expand(description_);
    std::unordered_map<std::string, JointKind> joints;
    for (const BodyDescription& body : expanded.bodies) joints.emplace(body.joint.name, body.joint.kind);
    std::unordered_set<std::string> names;
    for (std::size_t k = 0; k < description_.drives.size(); ++k) {
      const DriveDescription& drive = description_.drives[k];
      const std::string name = drive_name(drive, k);
      const FaultySubject at{faults_, "drive " + quoted(name), drive.source};
      if (!names.insert(name).second)
        at.error(Rule::duplicate_name, "the name is taken; names of drives must differ");
      for (const auto& [of, factor] : drive.joints) {
        const auto joint = joints.find(of);
        if (joint == joints.end())
          at.error(Rule::unknown_drive_target,
                   "acts on joint " + quoted(of) + ", which is not described" + nearest_joint(of, expanded));
        else if (!can_couple(joint->second))
          at.error(Rule::degrees_of_freedom,
                   "acts on joint " + quoted(of) + ", which is " + std::string(to_string(joint->second)) +
                       "; a drive acts on " + kinds_with_one_velocity(" or ") + " joints");
      }
      if (drive.line)
        for (const std::string& frame : drive.line->between)
          if (frame != "ground" && !taken_.contains(frame))
            at.error(
                Rule::unknown_drive_target,
                "ends on " + quoted(frame) + ", which is neither a body nor a frame" + nearest_frame(frame));
      check_drive(at, drive);
    }
    check_feeding(faults_, description_);
  }
  std::string nearest_joint(std::string_view name, const Description& expanded) {
    return nearest(name, expanded.bodies, [](const BodyDescription& b) { return b.joint.name; });
  }

  const Description& description_;
  FaultCollector faults_;
  int suggestions_ = 0;
  std::unordered_map<std::string, const BodyDescription*> bodies_;
  std::unordered_set<std::string> taken_;
};

}  // namespace

std::vector<Fault> inspect(const Description& description, Strictness strictness) {
  return Inspection(description, strictness).run();
}

}  // namespace axode
