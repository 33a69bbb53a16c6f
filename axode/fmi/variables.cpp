#include "axode/fmi/variables.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "axode/drives/drive_system.hpp"
#include "axode/fmi/parameters.hpp"
#include "axode/integration/dry_friction.hpp"
#include "axode/integration/runs/plays.hpp"
#include "axode/io/drawing/toml.hpp"
#include "axode/model/configuration.hpp"

namespace axode::fmi {
namespace {

/// coordinate_units() returns the units of the coordinates of a joint: `rad`, `m`, or `1` for entries of
/// quaternions. velocity_units() returns the units of its velocities, without the ending `/s`.
std::vector<std::string> coordinate_units(const Joint& joint) {
  return with_subgroup(joint.kind, joint.pitch, []<class Kind>(const Kind&) {
    std::vector<std::string> units;
    for (int k = 0; k < Kind::nq; ++k) {
      const bool quaternion = Kind::nq > Kind::nv && k < 4;
      const bool angle = Kind::nq == Kind::nv && k < Kind::angles;
      units.emplace_back(quaternion ? "1" : angle ? "rad" : "m");
    }
    return units;
  });
}
std::vector<std::string> velocity_units(const Joint& joint) {
  return with_subgroup(joint.kind, joint.pitch, []<class Kind>(const Kind&) {
    std::vector<std::string> units(Kind::nv, "m");
    std::fill_n(units.begin(), Kind::angles, "rad");
    return units;
  });
}

template <class F> void each_own_joint(const Model& model, const F& f) {
  for (const Joint& joint : model.joints())
    if (!joint.leader) f(joint);
}

/// Throws std::invalid_argument if a frame is named twice, because names of variables must differ.
void refuse_repeated(const std::vector<std::string>& names, const std::string& what) {
  for (auto name = names.begin(); name != names.end(); ++name)
    if (std::find(names.begin(), name, *name) != name)
      throw std::invalid_argument(what + ": frame \"" + *name + "\" is given twice; give it once");
}

std::string rate_of(const std::string& name) { return "der(" + name + ")"; }

}  // namespace

std::string to_text(const Settings& settings) {
  const auto list = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
      text += text.empty() ? "\"" : ", \"";
      for (const char c : name) text += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
      text += '"';
    }
    return "[" + text + "]\n";
  };
  return std::string("joint_losses = ") + (settings.joint_losses ? "true" : "false") +
         "\nframes = " + list(settings.frames) + "loads = " + list(settings.loads);
}

Settings read_settings(std::string_view text) {
  const io::toml::Document document = io::toml::parse(text);
  const auto require = [](bool good) {
    if (!good) throw std::invalid_argument("settings.toml is not a file that axode has written");
  };
  require(!document.failure);
  Settings settings;
  for (const auto& [key, entry] : *document.root().table()) {
    if (key == "joint_losses") {
      require(entry.value->flag() != nullptr);
      settings.joint_losses = *entry.value->flag();
      continue;
    }
    require((key == "frames" || key == "loads") && entry.value->array() != nullptr);
    for (const io::toml::Value* name : *entry.value->array()) {
      require(name->text() != nullptr);
      (key == "frames" ? settings.frames : settings.loads).push_back(*name->text());
    }
  }
  return settings;
}

VariableTable::VariableTable(const Model& model, const Settings& settings)
    : parameters_(parameters_of(model.description(), settings)) {
  add(Role::time, {.name = "time", .unit = "s", .description = "time"});
  add_states(model);
  add_forces(model);
  add_loads(model, settings);
  add_poses(model, settings);
  add_indicators(model, settings);
  Description numbers = model.description();
  for (const Parameter& it : parameters_)
    add(Role::parameter,
        {.name = it.name, .unit = it.unit, .description = it.description, .start = it.in(numbers)});
}

void VariableTable::add(Role role, Variable variable) {
  std::size_t& count = count_[at(role)];
  if (count == 0) first_[at(role)] = all_.size();
  variable.role = role;
  variable.index = count++;
  all_.push_back(std::move(variable));
}

void VariableTable::add_states(const Model& model) {
  const InitialState start = initial_state(model);
  std::vector<std::string> q_units, v_units;
  each_own_joint(model, [&](const Joint& joint) {
    std::ranges::move(coordinate_units(joint), std::back_inserter(q_units));
    std::ranges::move(velocity_units(joint), std::back_inserter(v_units));
  });
  const std::vector<std::string> q_names = coordinate_names(model), v_names = velocity_names(model);
  for (std::size_t k = 0; k < q_names.size(); ++k)
    add(Role::coordinate, {.name = "q." + q_names[k],
                           .unit = q_units[k],
                           .description = "coordinate of the joint",
                           .start = start.q[k]});
  for (std::size_t k = 0; k < v_names.size(); ++k)
    add(Role::velocity, {.name = "v." + v_names[k],
                         .unit = v_units[k] + "/s",
                         .description = "velocity of the joint",
                         .start = start.v[k]});
  DriveSystem drives(model);
  std::vector<double> x(drives.nx());
  drives.start(0, start.q, start.v, x);
  for (std::size_t k = 0; k < x.size(); ++k)
    add(Role::drive_state, {.name = "drive." + drives.states()[k].name,
                            .unit = drives.states()[k].unit,
                            .description = "state of the drive",
                            .start = x[k],
                            .nominal = drives.states()[k].nominal});
  for (std::size_t k = 0; k < q_names.size(); ++k)
    add(Role::coordinate_rate, {.name = rate_of("q." + q_names[k]),
                                .unit = q_units[k] == "1" ? "1/s" : q_units[k] + "/s",
                                .description = "rate of the coordinate"});
  for (std::size_t k = 0; k < v_names.size(); ++k)
    add(Role::acceleration, {.name = rate_of("v." + v_names[k]),
                             .unit = v_units[k] + "/s2",
                             .description = "acceleration of the joint"});
  for (std::size_t k = 0; k < x.size(); ++k)
    add(Role::drive_rate, {.name = rate_of("drive." + drives.states()[k].name),
                           .unit = "",
                           .description = "rate of the state"});
}

void VariableTable::add_forces(const Model& model) {
  const std::vector<std::string> names = velocity_names(model);
  each_own_joint(model, [&](const Joint& joint) {
    const auto follows = [&](const MotionDescription& motion) { return motion.of == joint.name; };
    if (joint.passive || std::ranges::any_of(model.motions(), follows)) return;
    const std::vector<std::string> units = velocity_units(joint);
    for (int k = 0; k < joint.nv; ++k) {
      driven_.push_back(static_cast<std::size_t>(joint.iv + k));
      add(Role::force, {.name = "tau." + names[driven_.back()],
                        .unit = units[static_cast<std::size_t>(k)] == "rad" ? "N.m" : "N",
                        .description = "drive force of the joint"});
    }
  });
}

void VariableTable::add_loads(const Model& model, const Settings& settings) {
  refuse_repeated(settings.loads, "loads");
  for (const std::string& name : settings.loads) {
    loads_.push_back(model.frame_index(name));
    for (const bool is_moment : {true, false})
      for (int k = 0; k < 3; ++k)
        add(Role::load,
            {.name = "load." + name + (is_moment ? ".moment[" : ".force[") + std::to_string(k) + "]",
             .unit = is_moment ? "N.m" : "N",
             .description = "wrench on the frame about its origin, in inertial axes"});
  }
}

void VariableTable::add_poses(const Model& model, const Settings& settings) {
  refuse_repeated(settings.frames, "frames");
  for (const std::string& name : settings.frames) {
    frames_.push_back(model.frame_index(name));
    for (int k = 0; k < 9; ++k)
      add(Role::pose,
          {.name = "frame." + name + ".rotation[" + std::to_string(k % 3) + "," + std::to_string(k / 3) + "]",
           .unit = "1",
           .description = "entry of the rotation matrix of the frame"});
    for (int k = 0; k < 3; ++k)
      add(Role::pose, {.name = "frame." + name + ".position[" + std::to_string(k) + "]",
                       .unit = "m",
                       .description = "component of the position of the frame"});
  }
}

void VariableTable::add_indicators(const Model& model, const Settings& settings) {
  for (const Joint& joint : model.joints()) {
    if (joint.dof.size() != 1 || !(joint.dof[0].stop_stiffness > 0)) continue;
    const Joint& own = joint.leader ? model.joint(joint.leader->joint) : joint;
    for (const int side : {-1, 1}) {
      const double limit = side < 0 ? joint.dof[0].lower : joint.dof[0].upper;
      if (!std::isfinite(limit)) continue;
      stops_.push_back({static_cast<std::size_t>(own.iq), joint.leader ? joint.leader->ratio : 1,
                        joint.leader ? joint.leader->offset : 0, limit, side});
      add(Role::indicator, {.name = "event." + joint.name + (side < 0 ? ".lower" : ".upper"),
                            .unit = joint.kind == Subgroup::prismatic ? "m" : "rad",
                            .description = "gap of the stop"});
    }
  }
  const DryFriction friction(model.tree<double>(), model.gears(), settings.joint_losses);
  const std::vector<std::string> names = velocity_names(model);
  for (std::size_t k = 0; k < friction.size(); ++k)
    add(Role::indicator,
        {.name = "event." + names[static_cast<std::size_t>(friction.velocity(k))] + ".friction",
         .unit = "",
         .description = "velocity of the joint while it slides, reserve of the friction force "
                        "while it sticks"});
  const Plays plays(model, true);
  for (std::size_t k = 0; k < plays.size(); ++k) {
    const std::string& joint = plays.stopped_joint(k);
    add(Role::indicator,
        {.name = "event." + (joint.empty() ? plays.name(k) + ".play" : joint + ".stop"),
         .unit = "",
         .description = "gap to the nearer end while the play is free, force that presses on "
                        "the end while it is there"});
  }
  n_statuses_ = friction.size() + plays.size();
  if (!model.drives().empty())
    add(Role::indicator,
        {.name = "event.drives", .unit = "", .description = "least margin of the statuses of the drives"});
}

}  // namespace axode::fmi
