#pragma once
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axode/model/building/builder.hpp"
#include "axode/model/description.hpp"

/// Checks of the values of single elements of a description: numbers, rotations, axes, limits and inertias.
namespace axode {

inline std::string quoted(std::string_view name) { return '"' + std::string(name) + '"'; }
/// The place in a file that describes a joint; if the joint has none of its own, that of its body.
inline const Source& joint_source(const BodyDescription& body) {
  return body.joint.source.line > 0 ? body.joint.source : body.source;
}

/// Collects the faults of a description, beginning with the warnings of its reader.
struct FaultCollector {
  const Description& description;
  Strictness strictness;
  std::vector<Fault> all = description.warnings;

  void note(Severity severity, Rule rule, std::string element, std::string message, const Source& source) {
    all.push_back({severity, rule, std::move(element), std::move(message),
                   source.file.empty() ? Source{description.source.file, source.line} : source});
  }
};

/// An element of a description whose faults are reported: its name in messages, and its place in a file.
struct FaultySubject {
  FaultCollector& faults;
  std::string element;
  const Source& source;

  void error(Rule rule, std::string message) const {
    faults.note(Severity::error, rule, element, std::move(message), source);
  }
  void warning(Rule rule, std::string message) const {
    faults.note(Severity::warning, rule, element, std::move(message), source);
  }
  /// Reports a fault that is an error if the check is strict, and a warning if it is lenient.
  void report_lenient(Rule rule, std::string message) const {
    const bool strict = faults.strictness == Strictness::strict;
    faults.note(strict ? Severity::error : Severity::warning, rule, element, std::move(message), source);
  }
};

/// Reports an error for each value that is negative. A value is given with its name for the message.
void not_negative(const FaultySubject& at, std::initializer_list<std::pair<std::string, double>> values);
/// Reports the first of the values that is not finite, by its key, and returns whether all are finite.
bool are_finite(const FaultySubject& at, std::initializer_list<std::pair<const char*, double>> values);
bool are_finite(const FaultySubject& at, std::initializer_list<std::pair<const char*, Vec3<>>> values);
bool are_finite(const FaultySubject& at, const std::string& key, std::span<const double> values);

/// The complaint about angles in rad if one of them looks like degrees, such as `limits are 0 and 90 rad,
/// which look like degrees; ...`; empty if none does. An angle looks like degrees if its absolute value is a
/// multiple of 5, larger than 4π (two turns in rad) and at most 720 (two turns in degrees).
std::optional<std::string> degrees_complaint(std::string_view subject, std::span<const double> angles);

/// Checks that return whether all numbers are finite and all rotation matrices orthonormal.
bool check_pose(const FaultySubject& at, const std::string& what, const SE3<>& C);
bool check_shape(const FaultySubject& at, const ShapeDescription& shape);
bool check_numbers(const BodyDescription& body, FaultCollector& faults);
/// Checks that report the faults of an element. check_joint() and check_inertia() need a body whose numbers
/// are finite; the others accept any numbers, including infinity and NaN.
void check_joint(const BodyDescription& body, FaultCollector& faults);
void check_inertia(const BodyDescription& body, FaultCollector& faults);
void check_loop(const FaultySubject& at, const LoopDescription& loop);
void check_play(const FaultySubject& at, const CouplingDescription& coupling);
void check_motion(const FaultySubject& at, const MotionDescription& motion);
/// Checks the coordinates (if `positions`) or velocities of a joint in an initial state; `what` is q or v.
void check_joint_state(const FaultySubject& at, const char* what, const JointDescription& joint,
                       std::span<const double> numbers, bool positions);
void check_contact(const FaultySubject& at, const ContactDescription& contact);

}  // namespace axode
