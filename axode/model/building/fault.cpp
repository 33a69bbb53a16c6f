#include "axode/model/building/fault.hpp"

#include <algorithm>

namespace axode {

std::string_view to_string(Rule rule) {
  switch (rule) {
    case Rule::missing_name: return "missing_name";
    case Rule::duplicate_name: return "duplicate_name";
    case Rule::unknown_predecessor: return "unknown_predecessor";
    case Rule::two_predecessors: return "two_predecessors";
    case Rule::cycle: return "cycle";
    case Rule::non_finite_number: return "non_finite_number";
    case Rule::zero_axis: return "zero_axis";
    case Rule::parallel_axes: return "parallel_axes";
    case Rule::pitch_without_helix: return "pitch_without_helix";
    case Rule::not_a_rotation: return "not_a_rotation";
    case Rule::mass_not_positive: return "mass_not_positive";
    case Rule::moves_no_mass: return "moves_no_mass";
    case Rule::inertia_not_realisable: return "inertia_not_realisable";
    case Rule::limits_crossed: return "limits_crossed";
    case Rule::negative_value: return "negative_value";
    case Rule::degrees_of_freedom: return "degrees_of_freedom";
    case Rule::coupling_unknown_joint: return "coupling_unknown_joint";
    case Rule::coupling_loop: return "coupling_loop";
    case Rule::coupling_kind: return "coupling_kind";
    case Rule::unknown_frame_body: return "unknown_frame_body";
    case Rule::unknown_spring_frame: return "unknown_spring_frame";
    case Rule::unknown_loop_frame: return "unknown_loop_frame";
    case Rule::loop_within_body: return "loop_within_body";
    case Rule::unknown_state_joint: return "unknown_state_joint";
    case Rule::unknown_motion_target: return "unknown_motion_target";
    case Rule::unknown_drive_target: return "unknown_drive_target";
    case Rule::no_base: return "no_base";
    case Rule::unreadable_file: return "unreadable_file";
    case Rule::syntax: return "syntax";
    case Rule::unknown_element: return "unknown_element";
    case Rule::missing_element: return "missing_element";
    case Rule::duplicate_element: return "duplicate_element";
    case Rule::wrong_value: return "wrong_value";
  }
  return "unknown";
}

std::string to_string(const Fault& fault) {
  std::string text;
  if (!fault.source.file.empty()) {
    text += fault.source.file + ":";
    if (fault.source.line > 0) text += std::to_string(fault.source.line) + ":";
    text += " ";
  }
  text += fault.severity == Severity::error ? "error: " : "warning: ";
  if (!fault.element.empty()) text += fault.element + ": ";
  return text + fault.message;
}

namespace {

std::string summary(std::string_view model, const std::vector<Fault>& faults) {
  const auto is_error = [](const Fault& f) { return f.severity == Severity::error; };
  const auto errors = std::count_if(faults.begin(), faults.end(), is_error);
  std::string text;
  if (errors != 1) text = "model \"" + std::string(model) + "\" has " + std::to_string(errors) + " faults:";
  for (const Fault& fault : faults)
    if (is_error(fault)) text += (errors == 1 ? "" : "\n  ") + to_string(fault);
  return text;
}

}  // namespace

ModelError::ModelError(std::string_view model, std::vector<Fault> faults)
    : std::runtime_error(summary(model, faults)), faults_(std::move(faults)) {}

}  // namespace axode
