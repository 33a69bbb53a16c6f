#include "apps/quantities/components.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "axode/model/configuration.hpp"
#include "axode/model/subgroup.hpp"

namespace axode::command {
namespace {

using Names = std::vector<std::string>;
enum class Of { coordinates, velocities };

char axis_of(const Vec3<>& e) { return e.x != 0 ? 'x' : e.y != 0 ? 'y' : 'z'; }

/// The names of the coordinates or velocities of a kind of joint: first those of rotations, then those of
/// translations. They name the axes of the columns of S. The only one of a joint has no name.
Names names_of(Subgroup kind, Of of) {
  return with_subgroup(kind, 1.0, [of](const auto& joint) -> Names {
    if (joint.nv == 1) return {""};
    Names names;
    if (of == Of::coordinates) {
      names = joint.nq > joint.nv ? Names{"qx", "qy", "qz", "qw"} : Names(joint.angles, "angle");
    } else {
      for (int k = 0; k < joint.angles; ++k)
        names.push_back(joint.angles == 1 ? "w" : std::string("w") + axis_of(joint.column(k).w));
    }
    for (int k = joint.angles; k < joint.nv; ++k)
      names.push_back(std::string(of == Of::velocities ? "v" : "") + axis_of(joint.column(k).v));
    return names;
  });
}

/// Makes a Component for each coordinate, or for each velocity, of the joints that are not coupled.
/// Translations have Component::length as their kind, and rotations Component::angle or Component::quaternion,
/// for velocities too.
std::vector<Component> components(const Model& model, Of of) {
  std::vector<Component> all;
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Joint& joint = model.joint(i);
    if (joint.leader) continue;
    const Names names = names_of(joint.kind, of);
    const std::size_t lengths = with_subgroup(
        joint.kind, 1.0, [](const auto& kind) { return static_cast<std::size_t>(kind.nv - kind.angles); });
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::string& name = names[k];
      Component::Kind kind = Component::length;
      if (k + lengths < names.size()) kind = name.starts_with('q') ? Component::quaternion : Component::angle;
      all.push_back({joint.name + (name.empty() ? "" : " " + name), kind, joint.name, model.body(i).name, i});
    }
  }
  return all;
}

std::string unit_name(Component::Kind kind, const std::vector<std::string_view>& units) {
  return kind == Component::quaternion ? "quaternion" : std::string(units[kind == Component::angle ? 0 : 1]);
}

/// Splits a list of units such as "N m, N" at its commas. If the list ends with " per unit of ...", this is
/// appended to each unit. The words " for angles" and " for lengths" are removed.
std::vector<std::string> list_of(const std::string& units) {
  const std::size_t end = std::min(units.find(" per unit"), units.size());
  std::vector<std::string> all;
  for (std::size_t from = 0; from < end;) {
    const std::size_t comma = std::min(units.find(", ", from), end);
    const std::string part = units.substr(from, comma - from);
    all.push_back(part.substr(0, part.find(" for ")) + units.substr(end));
    from = comma + 2;
  }
  return all;
}

/// Whether a curve with this name, such as `tool vx`, is a component of the linear part of a twist, wrench or
/// momentum (true) or of its angular part (false); empty if it is neither.
std::optional<bool> linear_part(std::string_view name) {
  constexpr std::array<std::string_view, 8> parts{"w ", "m ", "l ", "w' ", "v ", "f ", "p ", "v' "};
  if (name.size() < 3) return std::nullopt;
  name.remove_suffix(1);  // x, y or z
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (name == parts[k] || name.ends_with(" " + std::string(parts[k]))) return k >= parts.size() / 2;
  return std::nullopt;
}

/// Removes a velocity's name, and the space behind it, from the front of a curve's name and returns the
/// velocity's index; empty if no velocity's name is there.
std::optional<std::size_t> take_velocity(std::string_view& name, const std::vector<std::string>& velocities) {
  std::optional<std::size_t> found;
  for (std::size_t k = 0; k < velocities.size(); ++k)
    if ((name == velocities[k] || name.starts_with(velocities[k] + " ")) &&
        (!found || velocities[k].size() > velocities[*found].size()))
      found = k;
  if (found) name.remove_prefix(std::min(velocities[*found].size() + 1, name.size()));
  return found;
}

}  // namespace

std::vector<Component> coordinate_components(const Model& model) {
  return components(model, Of::coordinates);
}
std::vector<Component> velocity_components(const Model& model) { return components(model, Of::velocities); }

std::map<std::string, ColumnOfMotion> columns_of_motion(const Model& model) {
  std::map<std::string, ColumnOfMotion> columns{{"t", {"t", "s"}}, {"energy", {"energy", "J"}}};
  const auto add = [&](const std::string& symbol, const std::vector<std::string>& names,
                       const std::vector<Component>& components, const std::vector<std::string_view>& units) {
    for (std::size_t k = 0; k < names.size(); ++k)
      columns.insert(
          {symbol + " " + names[k], {symbol, unit_name(components[k].kind, units), components[k]}});
  };
  const std::vector<std::string> velocities = velocity_names(model);
  add("q", coordinate_names(model), coordinate_components(model), {"rad", "m"});
  add("v", velocities, velocity_components(model), {"rad/s", "m/s"});
  add("a", velocities, velocity_components(model), {"rad/s^2", "m/s^2"});
  add("tau", velocities, velocity_components(model), {"N m", "N"});
  return columns;
}

Curve curve_of(const Component& component) {
  return {.name = component.name, .of = {component.joint, component.body}, .body = component.index};
}

void add_panels(Chart& chart, const std::string& symbol, const std::vector<Component>& components,
                const std::vector<std::string_view>& units, const std::vector<double>& x,
                const Eigen::MatrixXd& columns) {
  for (const Component::Kind kind : {Component::angle, Component::quaternion, Component::length}) {
    Panel panel{.y_axis = symbol + ", " + unit_name(kind, units), .name = symbol};
    for (std::size_t k = 0; k < components.size(); ++k) {
      if (components[k].kind != kind) continue;
      const auto column = columns.col(static_cast<Eigen::Index>(k));
      Curve& curve = panel.curves.emplace_back(curve_of(components[k]));
      curve.x = x;
      curve.y = {column.begin(), column.end()};
    }
    if (!panel.curves.empty()) chart.panels.push_back(std::move(panel));
  }
}

std::vector<Panel> panels_by_unit(const Model& model, const std::string& quantity, const std::string& units,
                                  const std::vector<Curve>& curves) {
  const std::vector<std::string> each = list_of(units), velocities = velocity_names(model);
  const std::vector<Component> components = velocity_components(model);
  const auto unit_of = [&](Curve& curve) {
    if (curve.name.find("quaternion ") != std::string::npos) return std::string("quaternion");
    if (each.size() < 2) return units;
    if (const std::optional<bool> linear = linear_part(curve.name)) return each[*linear ? 1 : 0];
    std::string_view rest = curve.name;
    std::string name;
    std::size_t lengths = 0;
    while (const std::optional<std::size_t> k = take_velocity(rest, velocities)) {
      const Component& component = components[*k];
      lengths += component.kind == Component::length ? 1 : 0;
      curve.of.insert(curve.of.end(), {component.joint, component.body});
      curve.body = component.index;
      name += component.name + " ";
    }
    if (name.empty() || lengths >= each.size()) return units;
    curve.name = name + std::string(rest);
    if (rest.empty()) curve.name.pop_back();  // the space behind the last velocity
    return each[lengths];
  };
  std::vector<Panel> panels;
  for (Curve curve : curves) {
    const std::string unit = unit_of(curve), title = quantity + (unit.empty() ? "" : "; " + unit);
    auto panel = std::ranges::find(panels, title, &Panel::title);
    if (panel == panels.end()) panel = panels.insert(panels.end(), Panel{.title = title, .name = quantity});
    panel->curves.push_back(std::move(curve));
  }
  return panels;
}

}  // namespace axode::command
