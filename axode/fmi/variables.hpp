#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/model.hpp"

/// The table of variables of an FMU (Functional Mock-up Unit) of a mechanism: the value reference of a
/// variable is its index.
namespace axode::fmi {

/// The settings of an FMU that are stored in its resources in addition to the mechanism.
struct Settings {
  bool joint_losses = false;             ///< whether damping, dry friction and gears act
  std::vector<std::string> frames = {};  ///< names of frames whose poses are outputs
  std::vector<std::string> loads = {};   ///< names of frames on which wrenches act as inputs
};
/// to_text() writes settings as TOML. read_settings() throws std::invalid_argument for other texts.
std::string to_text(const Settings& settings);
Settings read_settings(std::string_view text);

/// The roles of variables. The variables of one role have consecutive value references.
enum class Role {
  time,
  coordinate,       ///< q: a state and an output
  velocity,         ///< v: a state and an output
  drive_state,      ///< x: a state of a drive
  coordinate_rate,  ///< q'
  acceleration,     ///< v'
  drive_rate,       ///< x'
  force,            ///< tau: an input
  load,             ///< a component of a wrench on a frame, an input
  pose,             ///< an entry of the pose of a frame, an output
  indicator,        ///< an event indicator
  parameter,        ///< a number of the mechanism's description, such as a mass
};

struct Variable {
  Role role{};
  std::size_t index = 0;  ///< index among the variables of the same role
  std::string name, unit, description;
  double start = 0;  ///< value at the start; used for states, parameters and inputs
  double nominal = 1;
};

/// A parameter of an FMU: a number of the mechanism that can be changed before the simulation starts.
struct Parameter {
  std::string name, unit, description;
  std::function<double&(Description&)> in;  ///< function that returns a reference to the number in a
                                            ///< description of the same mechanism
  /// Whether the FMU provides derivatives of the accelerations a by this parameter. They are -∂a/∂τ times the
  /// derivatives, at constant a, of the joint forces of inverse dynamics minus those of springs. These are
  /// difference quotients, which are exact to rounding if the forces are at most quadratic in the parameter.
  bool has_derivative = true;
  /// The step of the parameter in the difference quotients of joint forces by the parameter. It is relative
  /// to the magnitude of the parameter or, if the parameter is 0, in the unit of the parameter. It is small
  /// for springs that act in one direction only, because their forces are not differentiable where they begin
  /// to act.
  double step = 0.25;
};

/// An elastic stop of a joint. Its gap, side × (limit - p), is an event indicator of the FMU, with side = 1
/// for an upper limit and -1 for a lower one. p = ratio q + offset is the position of the joint, where q is
/// the coordinate with the index `coordinate`.
struct Stop {
  std::size_t coordinate = 0;
  double ratio = 1, offset = 0, limit = 0;
  int side = 1;  ///< 1 for an upper limit, -1 for a lower one
};

/// The table of all variables of the FMU of a mechanism.
class VariableTable {
 public:
  /// Makes the table. Throws std::invalid_argument for frames that do not exist or are named twice.
  VariableTable(const Model& model, const Settings& settings);

  std::size_t size() const { return all_.size(); }
  const Variable& operator[](std::size_t reference) const { return all_[reference]; }
  std::span<const Variable> all() const { return all_; }
  /// The variables of a role.
  std::span<const Variable> of(Role role) const {
    return std::span(all_).subspan(first(role), count_[at(role)]);
  }
  /// The value reference of the first variable of a role.
  std::size_t first(Role role) const { return first_[at(role)]; }
  std::size_t count(Role role) const { return count_[at(role)]; }

  /// Indices of the velocities on which the drive forces, which are inputs, act.
  const std::vector<std::size_t>& driven() const { return driven_; }
  const std::vector<int>& frames() const { return frames_; }
  const std::vector<int>& loads() const { return loads_; }
  const std::vector<Stop>& stops() const { return stops_; }
  /// The number of Rates::reserves, event indicators that follow those of elastic stops.
  std::size_t n_statuses() const { return n_statuses_; }
  std::span<const Parameter> parameters() const { return parameters_; }
  /// Whether the last event indicator is the least margin of the drives.
  bool drives_have_indicator() const { return count(Role::indicator) > stops_.size() + n_statuses_; }

 private:
  static constexpr std::size_t n_roles = static_cast<std::size_t>(Role::parameter) + 1;
  static std::size_t at(Role role) { return static_cast<std::size_t>(role); }
  void add(Role role, Variable variable);
  void add_states(const Model& model);
  void add_forces(const Model& model);
  void add_loads(const Model& model, const Settings& settings);
  void add_poses(const Model& model, const Settings& settings);
  void add_indicators(const Model& model, const Settings& settings);

  std::vector<Variable> all_;
  std::size_t first_[n_roles] = {};
  std::size_t count_[n_roles] = {};
  std::vector<std::size_t> driven_;
  std::vector<int> frames_, loads_;
  std::vector<Stop> stops_;
  std::size_t n_statuses_ = 0;
  std::vector<Parameter> parameters_;
};

}  // namespace axode::fmi
