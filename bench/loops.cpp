// Mechanisms with closed loops, at closed states: their dynamics, and the functions of loops that
// integrations call.
#include <algorithm>

#include "axode/constraints.hpp"
#include "axode/constraints/embedding/task_space.hpp"
#include "axode/constraints/loop_system/loop_system.hpp"
#include "axode/integration/simulation.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;
using Numbers = std::vector<double>;

/// A closed mechanism with its states, and memory for results.
struct Subject {
  const Model& model;
  LoopWorkspace<> workspace;
  RowRank rank;
  ClosedStates states;
  std::size_t nv = static_cast<std::size_t>(model.nv()), m = static_cast<std::size_t>(model.loops().rows),
              s = 0;
  Numbers a = Numbers(nv), lambda = Numbers(m), A = Numbers(m * nv);
  Numbers a_q = Numbers(nv * nv), a_v = a_q, a_tau = a_q;

  explicit Subject(const ClosedMechanism& mechanism)
      : model(mechanism.model), workspace(model), states(mechanism) {}
  std::span<const double> q() const {
    return std::span(states.q[s]).first(static_cast<std::size_t>(model.nq()));
  }
  std::span<const double> v() const { return std::span(states.v[s]).first(nv); }
  std::span<const double> tau() const { return std::span(states.tau[s]).first(nv); }
  LoopSystem<double>& system() { return workspace.system(model); }
};

/// Measures f(subject), at one state after the other.
template <class F>
void measure_closed(const std::string& function, const std::string& variant, const F& f,
                    const std::vector<ClosedMechanism>& mechanisms) {
  for (const ClosedMechanism& mechanism : mechanisms)
    measure(function, variant,
            [&mechanism, f](benchmark::State& state, const Model&) {
              Subject subject(mechanism);
              repeat(state, subject.a.data(), [&] {
                subject.s = subject.states.next();
                f(subject);
              });
            },
            {mechanism.model});
}

/// A platform in its task space, with accelerations that the loops allow at each state.
struct PlatformSubject : Subject {
  TaskSpace space;
  std::vector<Numbers> accelerations;
  Numbers dV = Numbers(static_cast<std::size_t>(space.freedom()));

  explicit PlatformSubject(const ClosedMechanism& mechanism)
      : Subject(mechanism), space(model, neutral(model)) {
    for (s = 0; s < states.q.size(); ++s) {
      static_cast<void>(forward_dynamics<double>(model, workspace, q(), v(), tau(), a));
      accelerations.push_back(a);
    }
  }
};

/// Measures f(subject) with the platforms among the mechanisms.
template <class F>
void measure_platforms(const std::string& function, const std::string& variant, const F& f) {
  for (const ClosedMechanism& mechanism : loop_mechanisms()) {
    if (TaskSpace(mechanism.model, neutral(mechanism.model)).platform() == 0) continue;
    measure(function, variant,
            [&mechanism, f](benchmark::State& state, const Model&) {
              PlatformSubject subject(mechanism);
              repeat(state, subject.a.data(), [&] {
                subject.s = subject.states.next();
                f(subject);
              });
            },
            {mechanism.model});
  }
}

constexpr double step = 1e-3, steps = 10;

const bool registered = [] {
  measure_closed(
      "constrained_forward_dynamics", "spatial",
      [](Subject& at) {
        benchmark::DoNotOptimize(
            forward_dynamics<double>(at.model, at.workspace, at.q(), at.v(), at.tau(), at.a, at.lambda));
      },
      closed_mechanisms());
  const std::vector<ClosedMechanism>& all = loop_mechanisms();
  measure_closed(
      "loops_forward_dynamics", "axode",
      [](Subject& at) {
        benchmark::DoNotOptimize(
            forward_dynamics<double>(at.model, at.workspace, at.q(), at.v(), at.tau(), at.a, at.lambda));
      },
      all);
  measure_platforms("platform_inverse_dynamics", "axode", [](PlatformSubject& at) {
    benchmark::DoNotOptimize(
        inverse_dynamics<double>(at.model, at.workspace, at.q(), at.v(), at.accelerations[at.s], at.a));
  });
  measure_platforms("platform_forward_dynamics", "loops", [](PlatformSubject& at) {
    benchmark::DoNotOptimize(
        forward_dynamics<double>(at.model, at.workspace, at.q(), at.v(), at.tau(), at.a));
  });
  measure_platforms("platform_forward_dynamics", "task_space", [](PlatformSubject& at) {
    benchmark::DoNotOptimize(at.space.forward_dynamics(at.q(), at.v(), at.tau(), at.dV));
  });
  measure_closed(
      "loops_impact", "axode",
      [](Subject& at) {
        benchmark::DoNotOptimize(
            impact<double>(at.model, at.workspace, at.q(), at.v(), 0.5, at.a, at.lambda));
      },
      all);
  measure_closed(
      "loops_projection", "axode",
      [](Subject& at) { benchmark::DoNotOptimize(at.system().projection_step(at.q().data(), at.a.data())); },
      all);
  measure_closed(
      "loops_rank", "axode",
      [](Subject& at) { benchmark::DoNotOptimize(at.system().determine_rank(at.q().data(), at.rank)); }, all);
  measure_closed(
      "loops_jacobian", "axode",
      [](Subject& at) { loop_jacobian<double>(at.model, at.workspace, at.q(), at.A); }, all);
  measure_closed(
      "loops_derivatives", "axode",
      [](Subject& at) {
        benchmark::DoNotOptimize(forward_dynamics_derivatives<double>(at.model, at.workspace, at.q(), at.v(),
                                                                      at.tau(), {at.a_q, at.a_v, at.a_tau}));
      },
      all);
  measure_closed(
      "loops_ten_steps", "rattle",
      [](Subject& at) {
        benchmark::DoNotOptimize(simulate_rattle(at.model, at.q(), at.v(), steps * step, step, 2,
                                                 {.coordinates = Coordinates::absolute}));
      },
      all);
  static std::vector<ClosedMechanism> holonomic = all;
  std::erase_if(holonomic, [](const ClosedMechanism& of) {
    return of.model.loops().rows != of.model.loops().residuals;
  });
  measure_closed(
      "loops_ten_steps", "midpoint",
      [](Subject& at) {
        benchmark::DoNotOptimize(simulate_symplectic(at.model, at.q(), at.v(), steps * step, step));
      },
      holonomic);
  return true;
}();

}  // namespace
