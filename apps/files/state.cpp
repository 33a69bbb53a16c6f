#include "apps/files/state.hpp"

#include <random>

#include "axode/model/configuration.hpp"

namespace axode::command {

std::vector<double> rates_of(const State& state) {
  std::vector<double> rates = state.v;
  for (const std::vector<double>* next : {&state.a, &state.jerk, &state.snap})
    rates.insert(rates.end(), next->begin(), next->end());
  return rates;
}

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

State random_state(const Model& model) { return random_state(model, 7); }

State random_state(const Model& model, unsigned seed) {
  std::mt19937_64 bits(seed);
  const auto random = [&](double largest) {
    std::vector<double> x(model.nv());
    for (double& x_k : x) x_k = largest * (static_cast<double>(bits() >> 11) * 0x1p-52 - 1);
    return x;
  };
  State state = neutral_state(model);
  state.q = random_configuration(model, seed);
  state.v = random(1);
  state.a = random(2);
  return state;
}

}  // namespace axode::command
