// All joint Jacobians at once, accelerations, and jerk of all bodies, in one thread, on states drawn at
// random.
#include "bench/subjects.hpp"

#ifdef AXODE_BENCH_PINOCCHIO
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#endif

namespace {

using namespace axode;
using namespace axode::bench;

void joint_screws_of_all(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  States states(model, 1);
  std::vector<Twist<Spatial>> J(static_cast<std::size_t>(model.n_screws()));
  for (auto _ : state) {
    joint_screws(model, workspace, states.q[states.next()], J);
    benchmark::DoNotOptimize(J.data());
    benchmark::ClobberMemory();
  }
}

template <class Rep> void accelerations_of_all(benchmark::State& state, const Model& model) {
  Workspace<> workspace(model);
  States states(model, 2);
  std::vector<TwistRate<Rep>> dV(static_cast<std::size_t>(model.n_frames()));
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  for (auto _ : state) {
    const std::size_t s = states.next();
    const std::span<const double> rates = states.rates[s];
    accelerations<Rep>(model, workspace, states.q[s], rates.first(nv), rates.last(nv), dV);
    benchmark::DoNotOptimize(dV.data());
    benchmark::ClobberMemory();
  }
}

template <class Rep> void jerk_of_all(benchmark::State& state, const Model& model) {
  HigherOrderMotion<> motion(model, 2);
  States states(model, 3);
  std::vector<TwistRate<Rep>> jerk(static_cast<std::size_t>(model.n_bodies() + 1));
  for (auto _ : state) {
    const std::size_t s = states.next();
    motion.evaluate(states.q[s], states.rates[s]);
    for (int i = 1; i <= model.n_bodies(); ++i) jerk[i] = motion.template twist_derivative<Rep>(i, 2);
    benchmark::DoNotOptimize(jerk.data());
    benchmark::ClobberMemory();
  }
}

#ifdef AXODE_BENCH_PINOCCHIO
void peer_joint_jacobians(benchmark::State& state, const Model& model) {
  const pinocchio::Model other = peer(model);
  pinocchio::Data data(other);
  States states(model, 1);
  const auto q = vectors(states.q, 0, model.nq());
  for (auto _ : state) {
    pinocchio::computeJointJacobians(other, data, q[states.next()]);
    benchmark::DoNotOptimize(data.J.data());
    benchmark::ClobberMemory();
  }
}
void peer_accelerations(benchmark::State& state, const Model& model) {
  const pinocchio::Model other = peer(model);
  pinocchio::Data data(other);
  States states(model, 2);
  const auto q = vectors(states.q, 0, model.nq()), v = vectors(states.rates, 0, model.nv()),
             a = vectors(states.rates, model.nv(), model.nv());
  for (auto _ : state) {
    const std::size_t s = states.next();
    pinocchio::forwardKinematics(other, data, q[s], v[s], a[s]);
    benchmark::DoNotOptimize(data.a.data());
    benchmark::ClobberMemory();
  }
}
#endif

const bool registered = [] {
  for (const Model& model : models()) {
    const auto add = [&](const std::string& name, void (*run)(benchmark::State&, const Model&)) {
      benchmark::RegisterBenchmark((name + "/" + model.name()).c_str(), run, model);
    };
    add("joint_screws/spatial", joint_screws_of_all);
    add("accelerations/body", accelerations_of_all<BodyFixed>);
    add("accelerations/hybrid", accelerations_of_all<Hybrid>);
    add("jerk/spatial", jerk_of_all<Spatial>);
    add("jerk/hybrid", jerk_of_all<Hybrid>);
#ifdef AXODE_BENCH_PINOCCHIO
    add("joint_screws/pinocchio", peer_joint_jacobians);
    add("accelerations/pinocchio", peer_accelerations);
#endif
  }
  return true;
}();

}  // namespace
