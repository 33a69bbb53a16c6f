// The jerk of all bodies, by one recursion on truncated series.
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

template <class Rep> void jerk_of_all(benchmark::State& state, const Model& model) {
  HigherOrderMotion<> motion(model, 2);
  States states(model);
  std::vector<std::vector<double>> rates;
  for (std::size_t s = 0; s < States::count; ++s) {
    rates.push_back(states.v[s]);
    for (const auto* more : {&states.a, &states.jerk})
      rates[s].insert(rates[s].end(), (*more)[s].begin(), (*more)[s].end());
  }
  std::vector<TwistRate<Rep>> jerk(static_cast<std::size_t>(model.n_bodies() + 1));
  repeat(state, jerk.data(), [&] {
    const std::size_t s = states.next();
    motion.evaluate(states.q[s], rates[s]);
    for (int i = 1; i <= model.n_bodies(); ++i) jerk[i] = motion.template twist_derivative<Rep>(i, 2);
  });
}

const bool registered = [] {
  measure("jerk", "spatial", jerk_of_all<Spatial>);
  measure("jerk", "hybrid", jerk_of_all<Hybrid>);
  return true;
}();

}  // namespace
