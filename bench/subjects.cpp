#include "bench/subjects.hpp"

#include <cstdlib>
#include <filesystem>

#include "axode/constraints.hpp"
#include "axode/io.hpp"

namespace axode::bench {
namespace {

class Random {
 public:
  double number() { return std::uniform_real_distribution(-1.0, 1.0)(engine_); }
  Vec3<> vector() { return {number(), number(), number()}; }

 private:
  std::mt19937_64 engine_{1};
};

/// A link with a hinge in general position.
BodyDescription link(Random& random, int i, int predecessor) {
  return {.name = std::to_string(i),
          .predecessor = predecessor == 0 ? "ground" : std::to_string(predecessor),
          .joint = {.kind = JointKind::revolute, .axis = random.vector(), .point = 0.1 * random.vector()},
          .geometry = InBodyFrame{exp(Screw<>{random.vector(), 0.3 * random.vector()})},
          .inertia = MassProperties{.mass = 1, .com = 0.1 * random.vector(), .Theta = {.1, .1, .1, 0, 0, 0}}};
}
Model chain(int n) {
  Random random;
  ModelBuilder builder("chain" + std::to_string(n));
  for (int i = 1; i <= n; ++i) builder.add(link(random, i, i - 1));
  return builder.build();
}
Model binary_tree(int n) {
  Random random;
  ModelBuilder builder("tree" + std::to_string(n));
  for (int i = 1; i <= n; ++i) builder.add(link(random, i, i / 2));
  return builder.build();
}

Model robot(const std::filesystem::path& file, Base base) {
  Description description = load(file, base).description();
  for (BodyDescription& body : description.bodies) body.joint.coupling.reset();
  description.name = file.stem().string();
  return ModelBuilder(std::move(description)).build();
}

std::vector<Model> load_models() {
  std::vector<Model> all{load(AXODE_ROBOTS_DIR "/arm7.toml")};
  const char* set = std::getenv("AXODE_ROBOTS");
  const std::filesystem::path folder = set ? set : AXODE_SHARED_ROBOTS;
  const std::pair<const char*, Base> robots[]{{"panda", Base::fixed},        {"ur5_robot", Base::fixed},
                                              {"anymal_b", Base::free},      {"solo12", Base::free},
                                              {"talos_reduced", Base::free}, {"simple_humanoid", Base::free}};
  for (const auto& [name, base] : robots) {
    const std::filesystem::path file = folder / (std::string(name) + ".urdf");
    if (std::filesystem::exists(file)) all.push_back(robot(file, base));
  }
  for (int n : {7, 10, 36, 50, 100, 200}) all.push_back(chain(n));
  all.push_back(binary_tree(63));
  return all;
}

Description drawing(const std::string& name) {
  Description description = load(AXODE_ROBOTS_DIR "/" + name + ".toml").description();
  description.name = name;
  return description;
}
/// The leg with its rod as a slender bar, which has a universal joint at one end and a ball joint at the
/// other.
Description leg_with_bar(double mass) {
  Description leg = drawing("leg");
  const LoopDescription rod = leg.loops.front();
  const auto& [p, q] = rod.points;
  const double l = mass * dot(q - p, q - p) / 12;
  leg.name = "leg_with_bar";
  leg.bodies.push_back({.name = "bar",
                        .predecessor = rod.between[1],
                        .joint = {.kind = JointKind::universal, .axis = {0, 1, 0}, .point = q},
                        .inertia = MassProperties{.mass = mass,
                                                  .com = 0.5 * (p + q),
                                                  .Theta = {l, l, 0.01 * l, 0, 0, 0},
                                                  .in = GivenIn::construction_frame}});
  leg.loops = {{.between = {rod.between[0], "bar"}, .kind = LoopKind::spherical, .point = p}};
  return leg;
}

}  // namespace

const std::vector<Model>& models() {
  static const std::vector<Model> all = load_models();
  return all;
}

const std::vector<Model>& small_models() {
  static const std::vector<Model> small = [] {
    std::vector<Model> some;
    for (const Model& model : models())
      if (model.nv() <= 40) some.push_back(model);
    return some;
  }();
  return small;
}

const std::vector<ClosedMechanism>& closed_mechanisms() {
  static const std::vector<ClosedMechanism> all = [] {
    const auto build = [](Description description) { return ModelBuilder(std::move(description)).build(); };
    const Model gough = build(drawing("gough")), bar = build(leg_with_bar(0.1));
    return std::vector<ClosedMechanism>{
        {gough, gough}, {build(drawing("leg")), build(leg_with_bar(1e-8))}, {bar, bar}};
  }();
  return all;
}

const std::vector<ClosedMechanism>& loop_mechanisms() {
  static const std::vector<ClosedMechanism> all = [] {
    std::vector<ClosedMechanism> some;
    for (const char* name : {"four_bar", "gough", "leg", "cart"}) {
      const Model model = ModelBuilder(drawing(name)).build();
      some.push_back({model, model});
    }
    return some;
  }();
  return all;
}

ClosedStates::ClosedStates(const ClosedMechanism& mechanism) {
  Random random;
  const Model& model = mechanism.of_balls;
  const auto numbers = [&](double size) {
    std::vector<double> out(static_cast<std::size_t>(model.nv()));
    for (double& x : out) x = size * random.number();
    return out;
  };
  while (q.size() < States::count) {
    AssemblyResult found = assemble(model, integrate(model, neutral(model), numbers(0.1)), numbers(1));
    if (found.status != AssemblyStatus::closed) throw std::logic_error(to_string(model, found));
    q.push_back(std::move(found.q)), v.push_back(std::move(found.v)), tau.push_back(numbers(10));
    std::fill(tau.back().begin() + mechanism.model.nv(), tau.back().end(), 0);
  }
}

States::States(const Model& model) {
  Random random;
  for (std::size_t s = 0; s < count; ++s) {
    q.push_back(random_configuration(model, s));
    for (auto* rates : {&v, &a, &jerk}) {
      rates->emplace_back(static_cast<std::size_t>(model.nv()));
      for (double& x : rates->back()) x = random.number();
    }
  }
}

}  // namespace axode::bench
