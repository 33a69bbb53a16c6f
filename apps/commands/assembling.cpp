#include "apps/commands/assembling.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/shell/commands.hpp"
#include "axode/constraints/assembly.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {
namespace {

std::vector<int> velocities_of(const Model& model, const std::vector<std::string>& joints) {
  std::vector<int> found;
  for (const std::string& name : joints) {
    const Joint& joint = model.joint(model.joint_index(name));
    if (joint.leader)
      throw UsageError(fmt::format("--hold {}: joint \"{}\" follows joint \"{}\"; give --hold {}", name, name,
                                   model.joint(joint.leader->joint).name,
                                   model.joint(joint.leader->joint).name));
    for (int k = 0; k < joint.nv; ++k) found.push_back(joint.iv + k);
  }
  return found;
}

/// Checks the initial state of a joint whose motion is prescribed. Throws InputError if the number that the
/// model's description gives for this joint (in `given`) differs from `start`, with which the prescribed
/// motion begins.
void check_start(const std::vector<std::pair<std::string, std::vector<double>>>& given, const char* what,
                 const std::string& joint, double start) {
  constexpr double tolerance = 1e-6;
  for (const auto& [name, numbers] : given)
    if (name == joint && !(std::abs(numbers[0] - start) <= tolerance * (1 + std::abs(start))))
      throw InputError(
          fmt::format("[state]: {} of joint \"{}\" is {}, but its [[motion]] starts with {} = {}; remove "
                      "\"{}\" from {} in "
                      "[state], or give a state by --state",
                      what, joint, numbers[0], what, start, joint, what));
}

}  // namespace

State starting_state(const Model& model) {
  State state = neutral_state(model);
  InitialState start = initial_state(model);
  state.q = std::move(start.q);
  state.v = std::move(start.v);
  for (const MotionDescription& motion : model.motions()) {
    const auto joint = std::ranges::find(model.joints(), motion.of, &Joint::name);
    if (joint == model.joints().end() || joint->leader) continue;
    const MotionValue first = MotionFunction(motion)(0);
    if (const auto& given = model.description().state) {
      check_start(given->q, "q", joint->name, first.s);
      check_start(given->v, "v", joint->name, first.ds);
    }
    state.q[static_cast<std::size_t>(joint->iq)] = first.s;
    state.v[static_cast<std::size_t>(joint->iv)] = first.ds;
  }
  return state;
}

void add_assembly_options(CLI::App& app, Assembling& assembling) {
  app.add_flag("--assemble", assembling.wanted, "Close the loops of the state first");
  app.add_option("--hold", assembling.hold, "A joint that --assemble does not move; may be given again")
      ->type_name("JOINT")
      ->allow_extra_args(false);
}

void assemble(const Model& model, const Assembling& assembling, State& state) {
  if (!assembling.wanted) {
    if (!assembling.hold.empty())
      throw UsageError("--hold names joints that --assemble does not move; give --assemble as well");
    return;
  }
  const std::vector<int> held = velocities_of(model, assembling.hold);
  AssemblyResult closed = axode::assemble(model, state.q, state.v, {.held = held});
  if (closed.status != AssemblyStatus::closed) throw InputError(to_string(model, closed));
  state.q = std::move(closed.q);
  state.v = std::move(closed.v);
}

std::optional<std::string> open_loop(const Model& model, const State& state, bool strict) {
  if (model.loops().empty()) return std::nullopt;
  LoopWorkspace<double> workspace(model);
  try {
    check_closed(checked<double>(model, workspace, state.q), state.q, state.v);
  } catch (const std::invalid_argument& open) {
    if (strict) throw InputError(open.what());
    return open.what();
  }
  return std::nullopt;
}

}  // namespace axode::command
