#include "apps/commands/assembling.hpp"

#include <CLI/CLI.hpp>

#include "apps/shell/commands.hpp"
#include "axode/constraints/assembly.hpp"

namespace axode::command {
namespace {

std::vector<int> velocities_of(const Model& model, const std::vector<std::string>& joints) {
  std::vector<int> found;
  for (const std::string& name : joints) {
    const Joint& joint = model.joint(model.joint_index(name));
    if (joint.leader)
      throw UsageError("--hold: joint \"" + name + "\" follows joint \"" +
                       model.joint(joint.leader->joint).name + "\"; hold that one");
    for (int k = 0; k < joint.nv; ++k) found.push_back(joint.iv + k);
  }
  return found;
}

}  // namespace

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

}  // namespace axode::command
