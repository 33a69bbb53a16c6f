#include "axode/model/building/builder.hpp"

#include <algorithm>
#include <utility>

#include "axode/model/building/checks/value_checks.hpp"
#include "axode/model/building/compilation.hpp"
#include "axode/model/building/inspection.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/scalar/instruction_set.hpp"

namespace axode {
namespace {

bool has_error(const std::vector<Fault>& faults) {
  return std::any_of(faults.begin(), faults.end(),
                     [](const Fault& f) { return f.severity == Severity::error; });
}

std::vector<Gear> gears_of(const std::vector<Joint>& joints) {
  std::vector<Gear> gears;
  for (const Joint& joint : joints)
    for (const Dof& dof : joint.dof)
      if (has_gear_losses(dof))
        gears.push_back({joint.iv, dof.armature, dof.gear_loss, dof.gear_loss_back.value_or(dof.gear_loss)});
  std::ranges::sort(gears, {}, &Gear::velocity);
  return gears;
}

}  // namespace

ModelBuilder& ModelBuilder::add(BodyDescription body) {
  description_.bodies.push_back(std::move(body));
  return *this;
}
ModelBuilder& ModelBuilder::add(FrameDescription frame) {
  description_.frames.push_back(std::move(frame));
  return *this;
}
ModelBuilder& ModelBuilder::add(SpringDescription spring) {
  description_.springs.push_back(std::move(spring));
  return *this;
}
ModelBuilder& ModelBuilder::add(LoopDescription loop) {
  description_.loops.push_back(std::move(loop));
  return *this;
}
ModelBuilder& ModelBuilder::add(CouplingDescription coupling) {
  description_.couplings.push_back(std::move(coupling));
  return *this;
}
ModelBuilder& ModelBuilder::add(MotionDescription motion) {
  description_.motions.push_back(std::move(motion));
  return *this;
}
ModelBuilder& ModelBuilder::add(DriveDescription drive) {
  description_.drives.push_back(std::move(drive));
  return *this;
}
ModelBuilder& ModelBuilder::state(InitialStateDescription state) {
  description_.state = std::move(state);
  return *this;
}
ModelBuilder& ModelBuilder::gravity(const Vec3<>& g) {
  description_.gravity = g;
  return *this;
}

BodyDescription& ModelBuilder::body(std::string_view name) {
  for (BodyDescription& body : description_.bodies)
    if (body.name == name) return body;
  throw std::invalid_argument(
      "ModelBuilder::body: model " + quoted(description_.name) + " has no body " + quoted(name) +
      did_you_mean(name, description_.bodies, [](const BodyDescription& b) { return b.name; }));
}

std::vector<Fault> ModelBuilder::check(Strictness strictness) const {
  std::vector<Fault> faults = inspect(description_, strictness);
  if (!has_error(faults)) {
    const std::vector<Fault> more = compile(description_).faults;
    faults.insert(faults.end(), more.begin(), more.end());
  }
  return faults;
}

Model ModelBuilder::build(Strictness strictness) const {
  static_cast<void>(instruction_set());  // throws if AXODE_INSTRUCTION_SET names none that can be used
  std::vector<Fault> faults = inspect(description_, strictness);
  if (has_error(faults)) throw ModelError(description_.name, std::move(faults));
  Compilation out = compile(description_);
  faults.insert(faults.end(), out.faults.begin(), out.faults.end());
  if (has_error(faults)) throw ModelError(description_.name, std::move(faults));
  Tree<float> tree_float = cast<float>(out.tree);
  std::vector<Gear> gears = gears_of(out.joints);
  auto data = std::make_shared<const Model::Data>(
      Model::Data{description_, std::move(out.bodies), std::move(out.joints), std::move(out.frames),
                  std::move(out.springs), std::move(out.loops), std::move(gears), std::move(faults),
                  std::move(out.tree), std::move(tree_float)});
  return Model(std::move(data));
}

Description with_free_base(Description description) {
  std::vector<BodyDescription*> roots;
  for (BodyDescription& body : description.bodies)
    if (body.predecessor == "ground" && body.joint.kind == JointKind::fixed) roots.push_back(&body);
  const auto is_free = [](const BodyDescription& body) {
    return body.predecessor == "ground" && body.joint.kind == JointKind::free;
  };
  if (roots.empty() && std::ranges::any_of(description.bodies, is_free)) return description;
  if (roots.size() != 1)
    throw ModelError(description.name,
                     {{Severity::error, Rule::no_base, "model " + quoted(description.name),
                       std::to_string(roots.size()) +
                           " bodies are fixed to the ground; a free base needs exactly one to set free",
                       description.source}});
  std::string name = "free_base";
  const auto taken = [&](const BodyDescription& body) {
    return body.joint.name == name && &body != roots[0];
  };
  for (int k = 2; std::ranges::any_of(description.bodies, taken); ++k)
    name = "free_base_" + std::to_string(k);
  roots[0]->joint = {.name = name, .kind = JointKind::free};
  return description;
}

Description with_fixed_base(Description description) {
  std::vector<BodyDescription*> roots;
  bool taken = false;
  for (BodyDescription& body : description.bodies) {
    if (body.predecessor == "ground" && body.joint.kind == JointKind::free) {
      roots.push_back(&body);
    } else {
      taken = taken || body.joint.name == "fixed_base";
    }
  }
  std::unordered_set<std::string> freed;
  for (BodyDescription* body : roots) {
    freed.insert(joint_name(*body));
    body->joint = {.name = roots.size() == 1 && !taken ? "fixed_base" : "", .source = body->joint.source};
  }
  leave_out_state(description, freed, "is left out, because the base is fixed now");
  return description;
}

}  // namespace axode