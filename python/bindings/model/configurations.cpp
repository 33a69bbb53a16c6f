#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include "axode/model/configuration.hpp"
#include "python/bindings/model/model.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/conversions.hpp"

namespace axode::python {

using namespace nb::literals;

void add_configurations(nb::class_<BoundModel>& model) {
  model
      .def(
          "neutral", [](const BoundModel& m) { return to_array(neutral(m)); }, R"(
The configuration with every joint at zero and every quaternion (x y z w) the identity: shape (nq,).

>>> arm.neutral()
array([0., 0., 0., 0., 0., 0., 0.])
)")
      .def(
          "random",
          [](const BoundModel& m, std::uint64_t seed, std::optional<std::size_t> n) {
            if (!n) return to_array(random_configuration(m, seed));
            NewArray out({static_cast<nb::ssize_t>(*n), m->nq()});
            put(random_configurations(m, seed, *n), out.all());
            return out.array();
          },
          "seed"_a = 0, "n"_a = nb::none(), R"(
A random configuration within the limits, uniform for each joint, shape (nq,), or n configurations, (n, nq). The same
seed gives the same result.

Unlimited angles are in [-pi, pi], unlimited lengths in [-1, 1] m, rotations uniform on SO(3).

>>> q = arm.random(seed=3)
>>> q.shape
(7,)
>>> arm.random(seed=3, n=100).shape
(100, 7)
)")
      .def(
          "normalize",
          [](const BoundModel& m, ArrayLike q) {
            return map_states(m, 1, linear_cost(m), {m->nq()}, q,
                              [&](auto&, auto from, auto out) { put(normalize(m, from), out); })
                .array();
          },
          "q"_a, R"(
The configuration q with every quaternion scaled to norm 1, shape (nq,) or (N, nq). ValueError if the norm of one is
0.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> base.normalize(2 * base.neutral())[:4]
array([0., 0., 0., 1.])
)")
      .def(
          "coordinate_rates",
          [](const BoundModel& m, ArrayLike q, ArrayLike v) {
            return map_states(
                       m, 1, linear_cost(m), {m->nq()}, q,
                       [&](auto&, auto from, auto by, auto out) { put(coordinate_rates(m, from, by), out); },
                       Named{"v", v})
                .array();
          },
          "q"_a, "v"_a, R"(
The rates dq/dt = E(q) v of the coordinates, shape (nq,) or (N, nq), from v (nv,) or (N, nv). The rate of a quaternion
a is a (omega; 0) / 2.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> base.coordinate_rates(base.neutral(), np.arange(base.nv))[:7]
array([0. , 0.5, 1. , 0. , 3. , 4. , 5. ])
)")
      .def(
          "velocities_from_rates",
          [](const BoundModel& m, ArrayLike q, ArrayLike dq) {
            const States states(m, q, 1);
            const Items rates = states.configurations("dq", dq);
            return each_item(states, linear_cost(m), {m->nv()},
                             [&](auto&, std::size_t k, auto out) {
                               put(velocities_from_rates(m, states.q(k), rates[k]), out);
                             })
                .array();
          },
          "q"_a, "dq"_a, R"(
The velocities v from the rates dq/dt, the inverse of `coordinate_rates`: shape (nv,) or (N, nv).

The part of a quaternion's rate that would change its norm is left out.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> q, v = base.random(), np.arange(base.nv)
>>> bool(np.allclose(base.velocities_from_rates(q, base.coordinate_rates(q, v)), v))
True
)")
      .def(
          "integrate",
          [](const BoundModel& m, ArrayLike q, ArrayLike dv) {
            return map_states(
                       m, 1, linear_cost(m), {m->nq()}, q,
                       [&](auto&, auto from, auto by, auto out) { put(integrate(m, from, by), out); },
                       Named{"dv", dv})
                .array();
          },
          "q"_a, "dv"_a, R"(
q (+) dv: the configuration after every joint has moved along its left-trivialised direction.

q has shape (nq,) or (N, nq), dv (nv,) or (N, nv), rad and m; a step of length h with velocity v is dv = h v.

>>> arm.integrate(arm.neutral(), np.full(7, 0.1))
array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
)")
      .def(
          "difference",
          [](const BoundModel& m, ArrayLike q0, ArrayLike q1) {
            const States states(m, q0, 1, "q0");
            const Items to = states.configurations("q1", q1);
            return each_item(
                       states, linear_cost(m), {m->nv()},
                       [&](auto&, std::size_t k, auto out) { put(difference(m, states.q(k), to[k]), out); })
                .array();
          },
          "q0"_a, "q1"_a, R"(
q1 (-) q0: the dv with integrate(q0, dv) = q1, the shorter way round on rotations.

Shapes (nq,) or (N, nq) to (nv,) or (N, nv), rad and m.

>>> arm.difference(arm.neutral(), np.full(7, 0.2))
array([0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2])
)")
      .def(
          "initial_state",
          [](const BoundModel& m) {
            const InitialState start = initial_state(m);
            return std::pair(to_array(start.q), to_array(start.v));
          },
          R"(
(q, v): the state in which a motion of the mechanism starts, as its drawing says; (nq,) and (nv,).

Joints that the drawing does not name are at zero and at rest.

>>> bool(arm.initial_state()[1].any())
False
)")
      .def(
          "interpolate",
          [](const BoundModel& m, ArrayLike q0, ArrayLike q1, nb::handle s) {
            const double part = number("s", s);
            const States states(m, q0, 1, "q0");
            const Items to = states.configurations("q1", q1);
            return each_item(states, linear_cost(m), {m->nq()},
                             [&](auto&, std::size_t k, auto out) {
                               put(interpolate(m, states.q(k), to[k], part), out);
                             })
                .array();
          },
          "q0"_a, "q1"_a, "s"_a,
          nb::sig(
              "def interpolate(self, q0: numpy.typing.ArrayLike, q1: numpy.typing.ArrayLike, s: float) -> "
              "numpy.typing.NDArray[numpy.float64]"),
          R"(
q0 (+) s (q1 (-) q0): a screw motion of every joint from q0 at s = 0 to q1 at s = 1.

Shapes (nq,) or (N, nq).

>>> arm.interpolate(arm.neutral(), np.full(7, 0.2), 0.5)
array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
)")
      .def(
          "clamp",
          [](const BoundModel& m, ArrayLike q) {
            return map_states(m, 1, linear_cost(m), {m->nq()}, q,
                              [&](auto&, auto from, auto out) { put(clamp(m, from), out); })
                .array();
          },
          "q"_a, R"(
The nearest configuration within the limits, shape (nq,) or (N, nq).

>>> bool(np.all(arm.clamp(np.full(7, 10.0)) <= arm.limits()[1]))
True
)")
      .def(
          "limits",
          [](const BoundModel& m) {
            const CoordinateLimits found = limits(m);
            return std::pair(to_array(found.lower), to_array(found.upper));
          },
          R"(
(lower, upper) limit of each coordinate, two arrays (nq,), rad and m; infinite if there is no limit.

>>> lower, upper = arm.limits()
>>> float(upper[0])
2.96706
)");
}

}  // namespace axode::python
