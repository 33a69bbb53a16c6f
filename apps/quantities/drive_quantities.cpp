#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>

#include "apps/files/csv_file.hpp"
#include "apps/quantities/quantities.hpp"
#include "apps/shell/commands.hpp"
#include "axode/drives/elastic_feed_forward.hpp"
#include "axode/drives/make_law.hpp"
#include "axode/kinematics.hpp"

/// Quantities that `axode eval` computes about the motors of a mechanism.
namespace axode::command {
namespace {

constexpr double rigid = std::numeric_limits<double>::infinity();

/// Copies the stiffness and the motor inertia of each series_elastic drive of the model (a motor with a
/// spring between its gear and the joint) to the entry of `drives` for the velocity of its joint. The motor
/// inertia is multiplied by the square of the gear ratio. Throws InputError if such a drive acts on several
/// joints, acts with a factor other than 1, or has damping or viscous friction, because ElasticFeedForward,
/// which computes the motor forces, does not support this.
void add_drives_of_drawing(const Model& model, std::vector<ElasticDrive>& drives) {
  for (const DriveDescription& drive : model.description().drives) {
    if (drive.kind != DriveKind::series_elastic) continue;
    const auto refuse = [&](const char* what) {
      throw InputError(fmt::format("elastic_feed_forward: the drive \"{}\" {}", drive.name, what));
    };
    if (drive.joints.size() != 1 || drive.joints[0].second != 1)
      refuse("acts on more than one joint, or with a factor; the feed-forward needs a motor for each joint");
    for (const char* lost : {"damping", "viscous"})
      if (parameter_of(drive, lost) != 0)
        refuse(
            "has damping or viscous friction, which the feed-forward does not count; leave it out of the "
            "drawing");
    const double ratio = parameter_of(drive, "ratio");
    const Joint& joint = model.joint(model.joint_index(drive.joints[0].first));
    drives[static_cast<std::size_t>(joint.iv)] = {parameter_of(drive, "stiffness"),
                                                  ratio * ratio * parameter_of(drive, "rotor_inertia")};
  }
}

/// Sets a member of the elastic drives (one for each of the nv velocities) from the words of an option. A
/// word is a number, which applies to all joints with one velocity that are not coupled, or JOINT=NUMBER,
/// which applies to one joint. Later words override earlier ones.
void set_drives(const Model& model, const char* option, const std::vector<std::string>& words,
                double ElasticDrive::*member, std::vector<ElasticDrive>& drives) {
  for (const std::string& word : words) {
    const std::size_t equals = word.rfind('=');
    const std::optional<double> number =
        number_in(equals == std::string::npos ? word : word.substr(equals + 1));
    if (!number)
      throw UsageError(
          fmt::format("{}: \"{}\" is not a number, and not a joint's name, = and a number", option, word));
    if (equals == std::string::npos) {
      for (const Joint& joint : model.joints())
        if (!joint.leader && joint.nv == 1) drives[static_cast<std::size_t>(joint.iv)].*member = *number;
      continue;
    }
    const Joint& joint = model.joint(model.joint_index(word.substr(0, equals)));
    for (int c = joint.iv; c < joint.iv + joint.nv; ++c)
      drives[static_cast<std::size_t>(c)].*member = *number;
  }
}

std::vector<ElasticDrive> drives_of(const Question& ask) {
  std::vector<ElasticDrive> drives(static_cast<std::size_t>(ask.model.nv()), {rigid, 0});
  add_drives_of_drawing(ask.model, drives);
  set_drives(ask.model, "--stiffness", ask.stiffness, &ElasticDrive::stiffness, drives);
  set_drives(ask.model, "--inertia", ask.inertia, &ElasticDrive::inertia, drives);
  return drives;
}

/// Returns the task velocities of a parallel manipulator and their first three time derivatives, in four
/// rows, for the motion with the coordinates, velocities, accelerations, jerks and snaps of `state`. Task
/// velocities are components of the body-fixed twist of the platform, followed by velocities of joints that
/// the platform does not determine. Of the joint rates in `state`, only those of the latter joints and of the
/// joint that connects the platform to the ground in the spanning tree are used.
std::vector<double> task_rates(const TaskSpace& space, const State& state) {
  const Model& model = space.model();
  const std::vector<double> rows = rates_of(state);
  std::vector<double> rates;
  HigherOrderMotion<> motion(model, 3);
  motion.evaluate(state.q, rows);
  const std::string platform = space.platform() > 0 ? model.body(space.platform()).name + "." : "";
  const std::vector<std::string> velocities = velocity_names(model);
  constexpr std::array<std::string_view, 6> components{"omega_x", "omega_y", "omega_z", "v_x", "v_y", "v_z"};
  for (int order = 0; order < 4; ++order) {
    const TwistRate<BodyFixed> V = motion.twist_derivative<BodyFixed>(space.platform(), order);
    const std::array<double, 6> twist{V.w.x, V.w.y, V.w.z, V.v.x, V.v.y, V.v.z};
    for (const std::string& name : space.names()) {
      const auto component = std::ranges::find_if(components, [&](std::string_view x) {
        return !platform.empty() && name == platform + std::string(x);
      });
      rates.push_back(
          component != components.end()
              ? twist[static_cast<std::size_t>(component - components.begin())]
              : rows[static_cast<std::size_t>(order) * velocities.size() +
                     static_cast<std::size_t>(std::ranges::find(velocities, name) - velocities.begin())]);
    }
  }
  return rates;
}

Answer elastic_feed_forward_answer(const Question& ask) {
  ElasticFeedForward feed_forward(ask.model, drives_of(ask));
  MotorMotion motors;
  if (ask.model.loops().empty()) {
    feed_forward.evaluate(ask.state.q, rates_of(ask.state), motors, ask.loads());
  } else {
    TaskSpace space(ask.model, ask.state.q);
    const TaskVerdict verdict =
        feed_forward.evaluate(space, ask.state.q, task_rates(space, ask.state), motors, ask.loads());
    if (!verdict.ok()) throw InputError(to_string(space, verdict));
  }
  Answer answer{Json{{"position", motors.position}, {"velocity", motors.velocity}, {"force", motors.force}},
                Table({"joint", "position", "velocity", "force"})};
  const std::vector<std::string> names = velocity_names(ask.model);
  for (std::size_t c = 0; c < names.size(); ++c)
    if (ask.model.loops().driven[c])
      answer.table.row({names[c], motors.position[c], motors.velocity[c], motors.force[c]});
  return answer;
}

}  // namespace

std::vector<Quantity> drive_quantities() {
  return {{"elastic_feed_forward",
           "The positions, velocities and forces of motors before springs (--stiffness, --inertia) let the "
           "joints follow q, v, a, jerk and snap.",
           elastic_feed_forward_answer}};
}

}  // namespace axode::command
