// Inverse and forward dynamics, mass matrix and its inverse, in one thread, on states drawn at random.
#include "bench/subjects.hpp"

#ifdef AXODE_BENCH_PINOCCHIO
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#endif

namespace {

using namespace axode;
using namespace axode::bench;

/// f(q, v, a, out) on one state after the other; out has a number for each pair of velocities.
template <class F> void on_states(benchmark::State& state, const Model& model, const F& f) {
  States states(model, 2);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  std::vector<double> out(nv * nv);
  for (auto _ : state) {
    const std::size_t s = states.next();
    const std::span<const double> rates = states.rates[s];
    f(states.q[s], rates.first(nv), rates.last(nv), std::span(out));
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
}

template <class Rep> void inverse_dynamics_of(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  on_states(state, model, [&](const auto& q, auto v, auto a, auto out) {
    inverse_dynamics<Rep>(model, workspace, q, v, a, out.first(v.size()));
  });
}
template <class Rep> void forward_dynamics_of(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  on_states(state, model, [&](const auto& q, auto v, auto a, auto out) {
    benchmark::DoNotOptimize(forward_dynamics<Rep>(model, workspace, q, v, a, out.first(v.size())));
  });
}
template <class Rep> void mass_matrix_of(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  on_states(state, model,
            [&](const auto& q, auto, auto, auto out) { mass_matrix<Rep>(model, workspace, q, out); });
}
template <class Rep> void inverse_mass_matrix_of(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  on_states(state, model, [&](const auto& q, auto, auto, auto out) {
    benchmark::DoNotOptimize(inverse_mass_matrix<Rep>(model, workspace, q, out));
  });
}
void momentum_form_of(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  std::vector<double> velocity(static_cast<std::size_t>(model.nv()));
  on_states(state, model, [&](const auto& q, auto p, auto tau, auto out) {
    benchmark::DoNotOptimize(momentum_form(model, workspace, q, p, tau, velocity, out.first(p.size())));
  });
}

#ifdef AXODE_BENCH_PINOCCHIO
/// f(model, data, q, v, a) of Pinocchio.
template <class F> void on_peer_states(benchmark::State& state, const Model& model, const F& f) {
  const pinocchio::Model other = peer(model);
  pinocchio::Data data(other);
  States states(model, 2);
  const auto q = vectors(states.q, 0, model.nq()), v = vectors(states.rates, 0, model.nv()),
             a = vectors(states.rates, model.nv(), model.nv());
  for (auto _ : state) {
    const std::size_t s = states.next();
    f(other, data, q[s], v[s], a[s]);
    benchmark::DoNotOptimize(data.tau.data());
    benchmark::ClobberMemory();
  }
}
void peer_inverse_dynamics(benchmark::State& state, const Model& model) {
  on_peer_states(state, model,
                 [](const auto& m, auto& d, auto& q, auto& v, auto& a) { pinocchio::rnea(m, d, q, v, a); });
}
void peer_forward_dynamics(benchmark::State& state, const Model& model) {
  on_peer_states(state, model,
                 [](const auto& m, auto& d, auto& q, auto& v, auto& a) { pinocchio::aba(m, d, q, v, a); });
}
void peer_mass_matrix(benchmark::State& state, const Model& model) {
  on_peer_states(state, model,
                 [](const auto& m, auto& d, auto& q, auto&, auto&) { pinocchio::crba(m, d, q); });
}
void peer_inverse_mass_matrix(benchmark::State& state, const Model& model) {
  on_peer_states(state, model,
                 [](const auto& m, auto& d, auto& q, auto&, auto&) { pinocchio::computeMinverse(m, d, q); });
}
#endif

const bool registered = [] {
  for (const Model& model : models()) {
    const auto add = [&](const std::string& name, void (*run)(benchmark::State&, const Model&)) {
      benchmark::RegisterBenchmark((name + "/" + model.name()).c_str(), run, model);
    };
    add("inverse_dynamics/body", inverse_dynamics_of<BodyFixed>);
    add("inverse_dynamics/hybrid", inverse_dynamics_of<Hybrid>);
    add("forward_dynamics/body", forward_dynamics_of<BodyFixed>);
    add("forward_dynamics/spatial", forward_dynamics_of<Spatial>);
    add("forward_dynamics/hybrid", forward_dynamics_of<Hybrid>);
    add("momentum_form/spatial", momentum_form_of);
    add("mass_matrix/body", mass_matrix_of<BodyFixed>);
    add("mass_matrix/spatial", mass_matrix_of<Spatial>);
    add("inverse_mass_matrix/spatial", inverse_mass_matrix_of<Spatial>);
#ifdef AXODE_BENCH_PINOCCHIO
    add("inverse_dynamics/pinocchio", peer_inverse_dynamics);
    add("forward_dynamics/pinocchio", peer_forward_dynamics);
    add("mass_matrix/pinocchio", peer_mass_matrix);
    add("inverse_mass_matrix/pinocchio", peer_inverse_mass_matrix);
#endif
  }
  return true;
}();

}  // namespace
