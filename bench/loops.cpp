// Forward dynamics of mechanisms with closed loops, at closed states.
#include "axode/constraints.hpp"
#include "bench/subjects.hpp"

namespace {

using namespace axode;
using namespace axode::bench;

const bool registered = [] {
  for (const ClosedMechanism& mechanism : closed_mechanisms())
    measure("constrained_forward_dynamics", "spatial",
            [&mechanism](benchmark::State& state, const Model& model) {
              LoopWorkspace<> workspace(model);
              ClosedStates states(mechanism);
              const std::size_t nq = static_cast<std::size_t>(model.nq()),
                                nv = static_cast<std::size_t>(model.nv());
              std::vector<double> a(nv), lambda(static_cast<std::size_t>(model.loops().rows));
              repeat(state, a.data(), [&] {
                const std::size_t s = states.next();
                const std::span q(states.q[s]), v(states.v[s]), tau(states.tau[s]);
                benchmark::DoNotOptimize(forward_dynamics<double>(model, workspace, q.first(nq), v.first(nv),
                                                                  tau.first(nv), a, lambda));
              });
            },
            {mechanism.model});
  return true;
}();

}  // namespace
