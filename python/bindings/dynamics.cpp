#include "axode/dynamics.hpp"

#include "axode/batch.hpp"
#include "bindings.hpp"
#include "choice.hpp"
#include "conversions.hpp"
#include "states.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

Array inverse_dynamics_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a, Algorithm algorithm,
                          LoadList given, bool joint_losses, int threads) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v), accelerations = states.velocities("a", a);
  const AppliedLoads loads(states, given, joint_losses);
  NewArray tau = states.result({m->nv()});
  if (states.many() && !algorithm.representation && loads.none()) {
    states.unlocked(linear_cost(m), [&] {
      batch::inverse_dynamics<double>(m, states.q(), velocities.all(), accelerations.all(),
                                      numbers_of(tau, 0, m->nv() * static_cast<int>(states.count())),
                                      states.threads());
    });
  } else {
    with_algorithm(algorithm, [&](auto rep) {
      states.each(linear_cost(m), [&](Workspace<>& workspace, std::size_t k) {
        loads.with(k, [&](const Loads<double>& now) {
          inverse_dynamics<decltype(rep)>(m, workspace, states.q(k), velocities[k], accelerations[k],
                                          numbers_of(tau, k, m->nv()), now);
        });
      });
    });
  }
  return tau.array();
}

}  // namespace

void add_dynamics(nb::module_& module) {
  module.def("inverse_dynamics", &inverse_dynamics_of, "m"_a, "q"_a, "v"_a, "a"_a,
             "representation"_a = "fast", "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
             "threads"_a = 1, R"(
tau = M(q) a + C(q, v) v + g(q) - (applied forces): the drive forces that make the accelerations a, (nv,) or (N, nv).

N m or N. `loads` are wrenches on frames, see `axode.Load`; joint_losses adds damping and friction; armature is always
part of it. All representations give the same; "fast" is the quickest, and goes through N states in SIMD lanes, on as
many cores as `threads` says. O(n), by the recursive Newton-Euler algorithm (eqs. aVbRec2 to cWhRec).

>>> q, v, a = arm.neutral(), np.full(7, 0.5), np.ones(7)
>>> q[1] = 0.8
>>> print(axode.inverse_dynamics(arm, q, v, a).round(3))
[ 2.6700e+00 -5.0147e+01 -1.0900e-01  1.4362e+01 -1.7000e-01 -5.1400e-01
  1.0000e-03]
)");
}

}  // namespace axode::python
