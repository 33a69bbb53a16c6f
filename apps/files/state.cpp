#include "apps/files/state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "apps/shell/commands.hpp"
#include "axode/constraints/prescribed/motion_function.hpp"
#include "axode/model/configuration.hpp"

namespace axode::command {

State neutral_state(const Model& model) {
  const std::vector<double> rest(model.nv());
  return {.q = neutral(model),
          .v = rest,
          .a = rest,
          .jerk = rest,
          .snap = rest,
          .tau = rest,
          .p = {},
          .dq = rest,
          .dv = rest,
          .da = rest,
          .dtau = rest,
          .w = std::vector<double>(rest.size(), 1.0),
          .loads = {},
          .targets = {}};
}

namespace {

/// Throws InputError if the description says that a motion begins with another number than the motion does.
void check_start(const std::vector<std::pair<std::string, std::vector<double>>>& given, const char* what,
                 const std::string& joint, double start) {
  constexpr double tolerance = 1e-6;
  for (const auto& [name, numbers] : given)
    if (name == joint && !(std::abs(numbers[0] - start) <= tolerance * (1 + std::abs(start))))
      throw InputError(fmt::format(
          "state: {} of joint \"{}\" is {}, and its motion begins with {}; leave it out, or begin by --state",
          what, joint, numbers[0], start));
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

State random_state(const Model& model) {
  std::mt19937_64 bits(7);
  const auto random = [&](double largest) {
    std::vector<double> x(model.nv());
    for (double& x_k : x) x_k = largest * (static_cast<double>(bits() >> 11) * 0x1p-52 - 1);
    return x;
  };
  State state = neutral_state(model);
  state.q = random_configuration(model, 7);
  state.v = random(1);
  state.a = random(2);
  return state;
}

}  // namespace axode::command
