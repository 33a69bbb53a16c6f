#include "axode/model/building/checks/drive_checks.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/drive_states.hpp"
#include "axode/model/finite.hpp"

namespace axode {
namespace {

std::string names_of(const std::vector<DriveState>& states) {
  std::string list;
  for (const DriveState& state : states) list += (list.empty() ? "" : ", ") + state.name;
  return list;
}

std::string with_unit(double x, std::string_view unit) {
  std::string text = to_text(x);
  if (!unit.empty()) text.append(" ").append(unit);
  return text;
}

const double* given(const DriveDescription& drive, std::string_view name) {
  for (const auto& [key, value] : drive.parameters)
    if (key == name) return &value;
  return nullptr;
}

void check_parameter(const FaultySubject& at, const DriveParameter& parameter, double x) {
  using Bound = DriveParameter::Bound;
  const std::string says = std::string(parameter.name) + " is " + with_unit(x, parameter.unit);
  if (std::isnan(x) || (std::isinf(x) && (x < 0 || !std::isinf(parameter.standard))))
    return at.error(Rule::non_finite_number, says + ", which is not finite");
  if (parameter.bound == Bound::positive && !(x > 0))
    at.error(Rule::wrong_value, says + "; it must be positive");
  if (parameter.bound == Bound::not_negative && x < 0)
    at.error(Rule::negative_value, says + "; it must not be negative");
  if (parameter.bound == Bound::not_zero && x == 0) at.error(Rule::wrong_value, says + "; it must not be 0");
}

bool has_heat_capacity(const DriveDescription& drive) {
  const double* C = given(drive, "heat_capacity");
  return C != nullptr && !std::isinf(*C);
}

void check_parameters(const FaultySubject& at, const DriveDescription& drive) {
  const DriveTraits& kind = traits(drive.kind);
  for (const DriveParameter& parameter : kind.parameters) {
    if (const double* x = given(drive, parameter.name))
      check_parameter(at, parameter, *x);
    else if (std::isnan(parameter.standard))
      at.error(Rule::missing_element,
               "has no " + std::string(parameter.name) +
                   (parameter.unit.empty() ? "" : "; give it in " + std::string(parameter.unit)));
  }
  for (const auto& [name, x] : drive.parameters)
    if (std::ranges::find(kind.parameters, name, &DriveParameter::name) == kind.parameters.end())
      at.error(Rule::unknown_element,
               "has " + quoted(name) + ", which a " + std::string(kind.name) + " does not have" +
                   did_you_mean(name, kind.parameters, [](const DriveParameter& p) { return p.name; }));
  const double *F_c = given(drive, "coulomb"), *F_s = given(drive, "stiction");
  if (drive.kind == DriveKind::lugre && F_c && F_s && *F_s < *F_c)
    at.error(Rule::wrong_value, "stiction is " + to_text(*F_s) + " and coulomb " + to_text(*F_c) +
                                    "; stiction must not be less than coulomb");
  if (given(drive, "thermal_resistance") && !has_heat_capacity(drive))
    at.error(Rule::missing_element,
             "has a thermal_resistance and no heat_capacity, without which a motor has no temperature");
  if (drive.conditional && drive.kind != DriveKind::pid)
    at.error(Rule::wrong_value,
             "is a " + std::string(kind.name) + "; only a pid has conditional anti-windup");
}

void check_initial(const FaultySubject& at, const DriveDescription& drive) {
  const std::vector<DriveState> states = states_of(drive.kind);
  for (const auto& [name, x] : drive.initial) {
    const std::string says = "initial " + name + " is " + to_text(x);
    if (std::ranges::find(states, name, &DriveState::name) == states.end()) {
      at.error(Rule::unknown_element, says + ", and a " + std::string(to_string(drive.kind)) +
                                          " has the states " + names_of(states));
    } else if (!finite(x)) {
      at.error(Rule::non_finite_number, says + ", which is not finite");
    } else if (name == "temperature" && !has_heat_capacity(drive)) {
      at.error(Rule::wrong_value, says + "; a motor has a temperature if it has a heat_capacity");
    } else if (const double* limit = given(drive, "current_limit");
               name == "current" && limit != nullptr && std::abs(x) > *limit) {
      at.error(Rule::wrong_value,
               says + " A and current_limit " + to_text(*limit) + " A; a motion must start within the limit");
    }
  }
}

void check_input(const FaultySubject& at, const DriveDescription& drive) {
  const DriveInput& input = drive.input;
  const DriveTraits& kind = traits(drive.kind);
  const int ways = (input.from.empty() ? 0 : 1) + (input.function ? 1 : 0) + (input.values.empty() ? 0 : 1);
  if (!kind.has_input && ways > 0)
    return at.error(Rule::wrong_value, "has an input, and a " + std::string(kind.name) + " has none");
  if (kind.has_input && ways == 0)
    return at.error(Rule::missing_element,
                    "has no input; give a number, a function of time or the name of a drive");
  if (ways > 1)
    return at.error(Rule::wrong_value,
                    "has several inputs; give a number, a function of time or the name of a drive");
  if (input.function) check_motion(at, *input.function);
  const auto all_finite = [](const std::vector<double>& all) {
    return std::ranges::all_of(all, [](double x) { return finite(x); });
  };
  if (!all_finite(input.times) || !all_finite(input.values))
    return at.error(Rule::non_finite_number, "its input has a number that is not finite");
  const bool is_constant = input.values.size() == 1 && input.times.empty();
  if (!is_constant && input.times.size() != input.values.size())
    return at.error(Rule::wrong_value, "its input has " + std::to_string(input.times.size()) + " times and " +
                                           std::to_string(input.values.size()) +
                                           " values; each step has both");
  for (std::size_t k = 1; k < input.times.size(); ++k)
    if (!(input.times[k] > input.times[k - 1]))
      return at.error(Rule::wrong_value, "its input has the time " + to_text(input.times[k]) + " s after " +
                                             to_text(input.times[k - 1]) + " s; times must increase");
}

void check_port(const FaultySubject& at, const DriveDescription& drive) {
  if (drive.line && !drive.joints.empty())
    at.error(Rule::wrong_value, "has joints and two points; a drive acts on joints or along a line");
  if (!drive.line && drive.joints.empty())
    at.error(Rule::missing_element,
             "acts on nothing; name its joint, or give the points between which it acts");
  std::unordered_set<std::string_view> named;
  for (const auto& [joint, factor] : drive.joints) {
    const std::string says = "the factor of joint " + quoted(joint) + " is " + to_text(factor);
    if (!named.insert(joint).second)
      at.error(Rule::duplicate_element, "names joint " + quoted(joint) + " twice");
    if (!finite(factor)) at.error(Rule::non_finite_number, says + ", which is not finite");
    if (factor == 0) at.error(Rule::wrong_value, says + "; leave the joint out, or give another factor");
  }
  if (drive.line)
    are_finite(at, {{"points[0]", drive.line->points[0]}, {"points[1]", drive.line->points[1]}});
}

/// For each drive the index of the drive whose output is its input; the number of drives if there is none.
std::vector<std::size_t> feeders(const std::vector<DriveDescription>& drives,
                                 const std::vector<std::string>& names) {
  std::unordered_map<std::string_view, std::size_t> index;
  for (std::size_t k = 0; k < names.size(); ++k) index.try_emplace(names[k], k);
  std::vector<std::size_t> feeder(drives.size(), drives.size());
  for (std::size_t k = 0; k < drives.size(); ++k)
    if (const auto from = index.find(drives[k].input.from);
        !drives[k].input.from.empty() && from != index.end())
      feeder[k] = from->second;
  return feeder;
}

/// Marks the drives whose input depends on their own output. feeder[k] is the drive whose output is the input
/// of drive k. The feeders of each drive are followed until a drive is met that has been seen before; this
/// takes linear time.
std::vector<char> drives_on_cycles(const std::vector<std::size_t>& feeder) {
  const std::size_t n = feeder.size();
  std::vector<char> on_cycle(n);
  std::vector<std::size_t> met_from(n, n);
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t last = k;
    for (; last < n && met_from[last] == n; last = feeder[last]) met_from[last] = k;
    if (last == n || met_from[last] != k) continue;
    for (; on_cycle[last] == 0; last = feeder[last]) on_cycle[last] = 1;
  }
  return on_cycle;
}

}  // namespace

void check_drive(const FaultySubject& at, const DriveDescription& drive) {
  check_port(at, drive);
  check_parameters(at, drive);
  check_initial(at, drive);
  check_input(at, drive);
}

void check_feeding(FaultCollector& faults, const Description& description) {
  const std::vector<DriveDescription>& drives = description.drives;
  std::vector<std::string> names;
  for (std::size_t k = 0; k < drives.size(); ++k) names.push_back(drive_name(drives[k], k));
  const std::vector<std::size_t> feeder = feeders(drives, names);
  const std::vector<char> on_cycle = drives_on_cycles(feeder);
  for (std::size_t k = 0; k < drives.size(); ++k) {
    if (drives[k].input.from.empty()) continue;
    const FaultySubject at{faults, "drive " + quoted(names[k]), drives[k].source};
    const std::string says = "its input is the output of " + quoted(drives[k].input.from);
    const std::size_t from = feeder[k];
    if (from == drives.size()) {
      at.error(Rule::unknown_drive_target,
               says + ", which is no drive" +
                   did_you_mean(drives[k].input.from, names, [](const std::string& name) { return name; }));
      continue;
    }
    if (!traits(drives[from].kind).may_feed)
      at.error(Rule::wrong_value, says + ", which is a " + std::string(to_string(drives[from].kind)) +
                                      "; only controllers have an output for other drives");
    if (on_cycle[k] != 0)
      at.error(Rule::cycle, says + ", whose input it is in the end; a drive must not feed itself");
  }
}

}  // namespace axode
