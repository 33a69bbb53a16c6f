#pragma once
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "axode/scalar/text.hpp"

namespace axode {

/// The file and the line where a mechanism or one of its elements is described. `file` is empty if the
/// mechanism is described in code.
struct Source {
  std::string file;
  int line = 0;
};

enum class Severity { warning, error };

/// The rules that descriptions are checked against. to_string() returns their names in messages and JSON.
enum class Rule {
  missing_name,
  duplicate_name,
  unknown_predecessor,
  two_predecessors,
  cycle,
  non_finite_number,
  zero_axis,
  parallel_axes,
  pitch_without_helix,
  not_a_rotation,
  mass_not_positive,
  moves_no_mass,
  inertia_not_realisable,
  limits_crossed,
  negative_value,
  degrees_of_freedom,
  coupling_unknown_joint,
  coupling_loop,
  coupling_kind,
  unknown_frame_body,
  unknown_spring_frame,
  unknown_loop_frame,
  loop_within_body,
  unknown_state_joint,
  unknown_motion_target,
  unknown_drive_target,
  no_base,
  unreadable_file,
  syntax,
  unknown_element,
  missing_element,
  duplicate_element,
  wrong_value,
};
std::string_view to_string(Rule rule);

/// An error or a warning in a description.
struct Fault {
  Severity severity = Severity::error;
  Rule rule{};
  std::string element;  ///< e.g. `body "forearm"`
  std::string message;  ///< the value and the rule, e.g. `mass is -1.2 kg; a mass must be positive`
  Source source;
};
/// The fault in one line: `arm.urdf:12: error: body "forearm": mass is -1.2 kg; a mass must be positive`.
std::string to_string(const Fault& fault);

/// Thrown by ModelBuilder::build() and the readers, with all faults of the description.
class ModelError : public std::runtime_error {
 public:
  ModelError(std::string_view model, std::vector<Fault> faults);
  /// All faults, including warnings.
  std::span<const Fault> faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

}  // namespace axode
