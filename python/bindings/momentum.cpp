#include "axode/dynamics.hpp"

#include <nanobind/stl/tuple.h>

#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

/// Computes two results for every state: arrays with items of the shapes `first` and `second`, where
/// f(workspace, k, first, second) writes the two items of state k. If a state cannot be computed, for example
/// because its mass matrix is singular, throws an error that contains the array of the first results of all
/// states.
template <class F>
std::tuple<Array, Array> each_pair(const States& states, const Shape& first, const Shape& second,
                                   const F& f) {
  NewArray rates = states.result(second);
  NewArray v = each_item(states, linear_cost(states.model()), first,
                         [&](auto& workspace, std::size_t k, std::span<double> out) {
                           return f(workspace, k, out, item(rates, k, second));
                         });
  return {v.array(), rates.array()};
}

std::tuple<Array, Array> twist_form_of(const BoundModel& m, ArrayLike q, ArrayLike V, ArrayLike tau,
                                       Representation representation, LoadList given, bool joint_losses,
                                       int threads) {
  const States states(m, q, threads);
  const Shape bodies{m->n_bodies(), 6};
  const Items twists = states.items("V", V, bodies, "a twist for each body"),
              forces = states.velocities("tau", tau);
  const AppliedLoads loads(states, given, joint_losses);
  return with_representation(representation, [&]<class Rep>(Rep) {
    return each_pair(states, {m->nv()}, bodies,
                     [&](auto& workspace, std::size_t k, std::span<double> v, std::span<double> dV) {
                       return loads.with(k, [&](const Loads<double>& now) {
                         return twist_form<Rep>(m, workspace, states.q(k), screws<Twist<Rep>>(twists[k]),
                                                forces[k], v, screws<TwistRate<Rep>>(dV), now);
                       });
                     });
  });
}

std::tuple<Array, Array> spatial_momentum_form_of(const BoundModel& m, ArrayLike q, ArrayLike Pi,
                                                  ArrayLike tau, LoadList given, bool joint_losses,
                                                  int threads) {
  const States states(m, q, threads);
  const Shape bodies{m->n_bodies(), 6};
  const Items momenta = states.items("Pi", Pi, bodies, "a momentum for each body"),
              forces = states.velocities("tau", tau);
  const AppliedLoads loads(states, given, joint_losses);
  return each_pair(states, {m->nv()}, bodies,
                   [&](auto& workspace, std::size_t k, std::span<double> v, std::span<double> dPi) {
                     return loads.with(k, [&](const Loads<double>& now) {
                       return spatial_momentum_form(*m, workspace, states.q(k),
                                                    screws<Momentum<Spatial>>(momenta[k]), forces[k], v,
                                                    screws<Wrench<Spatial>>(dPi), now);
                     });
                   });
}

}  // namespace

void add_momentum(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"momenta">(R"(
The generalized momenta p = M(q) v, armature included: (nv,) or (N, nv), kg m^2/s or kg m/s. O(n).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> np.allclose(axode.momenta(arm, q, v), axode.mass_matrix(arm, q) @ v)
True
)");
  functions.define<"from_momenta">(R"(
The velocities v = M(q)^-1 p that belong to generalized momenta: (nv,) or (N, nv). O(n). SingularError if M is
singular.

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> np.allclose(axode.from_momenta(arm, q, axode.momenta(arm, q, v)), v)
True
)");
  functions.define<"momentum_form">(R"(
(v, p'): the rates of the state (q, p), two arrays (nv,) or (N, nv): Hamilton's equations in O(n).

They are computed in spatial twists, without accelerations and their bias terms. SingularError if M is singular.

>>> v, dp = axode.momentum_form(arm, np.full(7, 0.3), np.zeros(7), np.zeros(7))
>>> np.allclose(dp, -axode.gravity_torques(arm, np.full(7, 0.3)))
True
)");
  functions.define<"body_momenta">(R"(
The momentum Pi_i = M_i V_i of every body in its own frame, (n_bodies, 6) or (N, n_bodies, 6): angular (N m s), then
linear (N s). O(n).

>>> axode.body_momenta(arm, arm.neutral(), np.ones(7), "hybrid").shape
(7, 6)
)");
  functions.define<"spatial_momentum">(R"(
The momentum of the whole mechanism about the inertial origin, in inertial axes, (6,) or (N, 6). O(n).

>>> axode.spatial_momentum(arm, arm.neutral(), np.zeros(7))
array([0., 0., 0., 0., 0., 0.])
)");
  functions.define<"centroidal_momentum">(R"(
The momentum of the whole mechanism about its center of mass, in inertial axes, (6,) or (N, 6). O(n).

ValueError for a massless model.

>>> axode.centroidal_momentum(arm, arm.neutral(), np.zeros(7))
array([0., 0., 0., 0., 0., 0.])
)");
  module.def("twist_form", &twist_form_of, "m"_a, "q"_a, "V"_a, "tau"_a, "representation"_a = "body",
             "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1, R"(
(v, V'): the rates of the state (q, V) for the twists V of all bodies, (n_bodies, 6) or (N, n_bodies, 6).

V should belong to joint velocities v; if it does not, the part of V that the joints allow is used. O(n).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> V = axode.twists(arm, q, v)[1:8]
>>> np.allclose(axode.twist_form(arm, q, V, np.zeros(7))[0], v)
True
)");
  module.def("spatial_momentum_form", &spatial_momentum_form_of, "m"_a, "q"_a, "Pi"_a, "tau"_a,
             "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1, R"(
(v, Pi'): the rates of the state (q, Pi^s) for the spatial momenta Pi of all bodies, (n_bodies, 6) or (N, n_bodies, 6).

The equation is PEs with its erratum corrected. O(n).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> Pi = axode.body_momenta(arm, q, v, "spatial")
>>> np.allclose(axode.spatial_momentum_form(arm, q, Pi, np.zeros(7))[0], v)
True
)");
}

}  // namespace axode::python
