#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "axode/model/model.hpp"

/// The variables of an FMU (Functional Mock-up Unit) of a mechanism. The description that a master reads and
/// the binary that it calls have the same table: the value reference of a variable is its index.
namespace axode::fmi {

/// The choices with which an FMU is made, besides the mechanism.
struct Settings {
  bool joint_losses = false;             ///< whether damping, dry friction and gears act
  std::vector<std::string> frames = {};  ///< frames whose poses are outputs
  std::vector<std::string> loads = {};   ///< frames on which wrenches act that are inputs
};
/// The settings as TOML, and their reader. It throws std::invalid_argument for a text of another kind.
std::string to_text(const Settings& settings);
Settings read_settings(std::string_view text);

/// The meaning of a variable. Variables of one role follow each other.
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
  parameter,        ///< a number of the description
};

struct Variable {
  Role role{};
  std::size_t index = 0;  ///< number among the variables of the role
  std::string name, unit, description;
  double start = 0;  ///< value at the start, of variables that have one
  double nominal = 1;
};

/// A number of the description of a mechanism that a master may change before the start.
struct Parameter {
  std::string name, unit, description;
  std::function<double&(Description&)> in;  ///< the number in a description of the same mechanism
  /// Whether accelerations at a given state are known functions of it, at most quadratic before the inversion
  /// of the mass matrix, so that central differences of inverse dynamics have no error but rounding.
  bool has_derivative = true;
  /// The step of these differences relative to the number. It is small if the force has kinks, as that of a
  /// one-sided spring.
  double step = 0.25;
};

/// A stop whose gap is an event indicator: side × (limit - p) for the position p = ratio q + offset of a
/// joint.
struct Stop {
  std::size_t coordinate = 0;
  double ratio = 1, offset = 0, limit = 0;
  int side = 1;  ///< 1 for an upper limit, -1 for a lower one
};

/// All variables of a mechanism.
class VariableTable {
 public:
  /// Throws std::invalid_argument for a frame that does not exist.
  VariableTable(const Model& model, const Settings& settings);

  std::size_t size() const { return all_.size(); }
  const Variable& operator[](std::size_t reference) const { return all_[reference]; }
  std::span<const Variable> all() const { return all_; }
  /// The variables of a role.
  std::span<const Variable> of(Role role) const {
    return std::span(all_).subspan(first(role), count_[at(role)]);
  }
  /// The reference of the first variable of a role.
  std::size_t first(Role role) const { return first_[at(role)]; }
  std::size_t count(Role role) const { return count_[at(role)]; }

  /// The velocities on which the inputs act.
  const std::vector<std::size_t>& driven() const { return driven_; }
  const std::vector<int>& frames() const { return frames_; }
  const std::vector<int>& loads() const { return loads_; }
  const std::vector<Stop>& stops() const { return stops_; }
  std::span<const Parameter> parameters() const { return parameters_; }
  /// Whether the last indicator is the least margin of the drives.
  bool drives_have_indicator() const { return count(Role::indicator) > stops_.size(); }

 private:
  static constexpr std::size_t n_roles = static_cast<std::size_t>(Role::parameter) + 1;
  static std::size_t at(Role role) { return static_cast<std::size_t>(role); }
  void add(Role role, Variable variable);
  void add_states(const Model& model);
  void add_forces(const Model& model);
  void add_loads(const Model& model, const Settings& settings);
  void add_poses(const Model& model, const Settings& settings);
  void add_indicators(const Model& model);

  std::vector<Variable> all_;
  std::size_t first_[n_roles] = {};
  std::size_t count_[n_roles] = {};
  std::vector<std::size_t> driven_;
  std::vector<int> frames_, loads_;
  std::vector<Stop> stops_;
  std::vector<Parameter> parameters_;
};

}  // namespace axode::fmi
