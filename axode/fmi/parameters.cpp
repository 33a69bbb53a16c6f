#include "axode/fmi/parameters.hpp"

#include <array>
#include <string_view>

#include "axode/model/building/placement.hpp"
#include "axode/model/kinds/joint_kinds.hpp"

namespace axode::fmi {
namespace {

constexpr std::array<double Vec3<>::*, 3> components{&Vec3<>::x, &Vec3<>::y, &Vec3<>::z};
constexpr std::array<std::pair<std::string_view, double Sym3<>::*>, 6> inertias{{{"xx", &Sym3<>::xx},
                                                                                 {"yy", &Sym3<>::yy},
                                                                                 {"zz", &Sym3<>::zz},
                                                                                 {"xy", &Sym3<>::xy},
                                                                                 {"xz", &Sym3<>::xz},
                                                                                 {"yz", &Sym3<>::yz}}};

std::string component(const std::string& name, std::size_t c) { return name + "[" + std::to_string(c) + "]"; }

class Parameters {
 public:
  explicit Parameters(const Settings& settings) : settings_(settings) {}

  void add_gravity() {
    for (std::size_t c = 0; c < 3; ++c)
      add(component("gravity", c), "m/s2", "component of gravity in the construction frame",
          [c](Description& d) -> double& { return d.gravity.*components[c]; });
  }

  void add_body(const BodyDescription& body, std::size_t i) {
    if (!body.inertia) return;
    const std::string name = "body." + body.name;
    add(name + ".mass", "kg", "mass", [i](Description& d) -> double& { return d.bodies[i].inertia->mass; });
    for (std::size_t c = 0; c < 3; ++c)
      add(component(name + ".com", c), "m", "component of the centre of mass",
          [i, c](Description& d) -> double& { return d.bodies[i].inertia->com.*components[c]; });
    for (const auto& [entry, member] : inertias)
      add(name + ".inertia." + std::string(entry), "kg.m2", "entry of the rotational inertia",
          [i, member = member](Description& d) -> double& { return d.bodies[i].inertia->Theta.*member; });
  }

  void add_joint(const BodyDescription& body, std::size_t i) {
    const JointDescription& joint = body.joint;
    const std::string name = "joint." + joint_name(body);
    if (traits(joint.kind).has("point") && std::holds_alternative<InConstructionFrame>(body.geometry))
      for (std::size_t c = 0; c < 3; ++c)
        add(
            component(name + ".point", c), "m", "component of the point of the joint",
            [i, c](Description& d) -> double& { return d.bodies[i].joint.point.*components[c]; }, false);
    for (std::size_t k = 0; k < joint.dof.size(); ++k) {
      const auto number = [&](const char* what, const char* unit, double Dof::*member) {
        const std::string full = name + "." + what;
        add(joint.dof.size() == 1 ? full : component(full, k), unit, std::string(what) + " of the joint",
            [i, k, member](Description& d) -> double& { return d.bodies[i].joint.dof[k].*member; });
      };
      const bool turns = traits(joint.kind).angles > 0 && joint.dof.size() == 1;
      const bool mixed = joint.dof.size() > 1;
      if (joint.dof[k].stiffness != 0) {
        number("stiffness", mixed ? "" : turns ? "N.m/rad" : "N/m", &Dof::stiffness);
        if (!mixed) number("rest", turns ? "rad" : "m", &Dof::rest);
      }
      if (settings_.joint_losses && joint.dof[k].damping != 0)
        number("damping", mixed ? "" : turns ? "N.m.s/rad" : "N.s/m", &Dof::damping);
    }
  }

  void add_spring(const SpringDescription& spring, std::size_t i) {
    if (spring.kind == SpringKind::bushing) return;
    const std::string name = "spring." + spring_name(spring, i);
    const bool turns = spring.kind == SpringKind::torsion, mixed = spring.kind == SpringKind::joints;
    const auto number = [&](const char* what, const char* unit, double SpringDescription::*member) {
      add(name + "." + what, unit, std::string(what) + " of the spring",
          [i, member](Description& d) -> double& { return d.springs[i].*member; });
      if (spring.acts != Acts::both_ways) all.back().step = 0x1p-17;
    };
    if (!spring.curve) {
      number("stiffness", mixed ? "" : turns ? "N.m/rad" : "N/m", &SpringDescription::stiffness);
      if (!spring.preload) number("rest", mixed ? "" : turns ? "rad" : "m", &SpringDescription::rest);
    }
    if (spring.damping != 0)
      number("damping", mixed ? "" : turns ? "N.m.s/rad" : "N.s/m", &SpringDescription::damping);
  }

  std::vector<Parameter> all;

 private:
  void add(std::string name, std::string unit, std::string description,
           std::function<double&(Description&)> in, bool has_derivative = true) {
    all.push_back({std::move(name), std::move(unit), std::move(description), std::move(in), has_derivative});
  }

  const Settings& settings_;
};

}  // namespace

std::vector<Parameter> parameters_of(const Description& description, const Settings& settings) {
  Parameters parameters(settings);
  parameters.add_gravity();
  for (std::size_t i = 0; i < description.bodies.size(); ++i) {
    parameters.add_body(description.bodies[i], i);
    parameters.add_joint(description.bodies[i], i);
  }
  for (std::size_t i = 0; i < description.springs.size(); ++i)
    parameters.add_spring(description.springs[i], i);
  return std::move(parameters.all);
}

}  // namespace axode::fmi
