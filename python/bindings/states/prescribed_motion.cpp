#include "python/bindings/states/prescribed_motion.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>

#include "axode/integration/prescribed/kinematic_motion.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"

/// Prescribed motions. Their functions of time may be Python functions.
namespace axode::python {

using namespace nb::literals;

std::vector<PrescribedMotion> motions_from(nb::handle given) {
  std::vector<PrescribedMotion> motions;
  if (given.is_none()) return motions;
  if (!nb::hasattr(given, "items"))
    throw nb::type_error("motions: expected a mapping from joints and rods to functions of time");
  for (const nb::handle item : nb::iter(given.attr("items")())) {
    const nb::object key = item[0], function = item[1];
    if (!nb::isinstance<nb::str>(key))
      throw nb::type_error(
          ("motions: expected names of joints and rods as keys, got " + type_of(key)).c_str());
    const std::string of = text_of(key), name = "motions[\"" + of + "\"]";
    if (!nb::isinstance<nb::callable>(function))
      throw nb::type_error(
          (name + ": expected a function t -> (s, ds, dds), got " + type_of(function)).c_str());
    motions.push_back(
        {of, MotionFunction([f = nb::borrow<nb::callable>(function), name](double t) {
           const nb::object result = f(t);
           const Numbers x(name + "(t)", {result.ptr()});
           if (x.axes() != 1 || x.size() < 3 || x.size() > 4)
             x.wrong_shape("(3,) or (4,): s and its first two or three derivatives");
           return MotionValue{x.data()[0], x.data()[1], x.data()[2], x.size() == 4 ? x.data()[3] : 0};
         })});
  }
  return motions;
}

namespace {

nb::object dynamics_of(const BoundModel& m, double t, ArrayLike q, ArrayLike v, ArrayLike tau,
                       nb::handle motions) {
  const States states = one_state(m, q);
  const Items velocities = states.velocities("v", v), forces = states.velocities("tau", tau);
  const DynamicsAtTime found =
      forward_dynamics_at(*m, t, states.q(0), velocities[0], forces[0], {}, motions_from(motions));
  NewArray a = states.result({m->nv()});
  std::ranges::copy(found.a, a.data());
  states.refuse({found.solvability}, a);
  return record("DynamicsAtTime", a.array(), to_array(found.lambda), to_array(found.motion_forces));
}

/// An array of `count` rows of `width` numbers each.
Array rows_of(const std::vector<double>& all, int width, std::size_t count) {
  NewArray out({static_cast<nb::ssize_t>(count), width});
  std::ranges::copy(all, out.all().begin());
  return out.array();
}

nb::object kinematic_motion_of(const BoundModel& m, ArrayLike times, nb::handle q, nb::handle motions) {
  const Numbers at("times", times);
  if (at.axes() != 1) at.wrong_shape("(N,), increasing");
  const std::vector<double> start = q.is_none() ? initial_state(*m).q : [&] {
    const States states = one_state(m, {q.ptr()});
    return std::vector<double>(states.q(0).begin(), states.q(0).end());
  }();
  const std::vector<PrescribedMotion> more = motions_from(motions);
  LongCall call(more.empty());  // Python functions need the interpreter's lock
  const batch::Monitor monitor = call.monitor();
  batch::MonitorThrottle throttle(monitor, 0);
  const KinematicMotion found = kinematic_motion(*m, start, {at.data(), static_cast<std::size_t>(at.size())},
                                                 more, [&] { return throttle.should_continue(0); });
  call.end();
  const std::size_t n = found.t.size();
  return record("KinematicMotion", to_array(found.t), rows_of(found.q, m->nq(), n),
                rows_of(found.v, m->nv(), n), rows_of(found.a, m->nv(), n), rows_of(found.jerk, m->nv(), n),
                found.complete, found.stop_reason);
}

}  // namespace

void add_prescribed_motion(nb::module_& module) {
  module.def(
      "forward_dynamics_at", &dynamics_of, "m"_a, "t"_a, "q"_a, "v"_a, "tau"_a, nb::kw_only(),
      "motions"_a = nb::none(),
      nb::sig(
          "def forward_dynamics_at(m: Model, t: float, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
          "tau: numpy.typing.ArrayLike, *, motions: collections.abc.Mapping[str, "
          "collections.abc.Callable[[float], numpy.typing.ArrayLike]] | None = None) -> "
          "axode.records.DynamicsAtTime"),
      R"(
(a, multipliers, motion_forces) at a time at which joints or rods follow prescribed motions.

The motions are those of the drawing, and `motions`: functions t -> (s, ds, dds) by joint or rod. A force is in N m for
an angle and in N for a length; that along a rod pushes its ends apart if it is positive. q and v should follow the
motions, see assemble. Springs are ignored.

>>> q, v = arm.neutral(), np.zeros(7)
>>> lift = {"A2": lambda t: (0, 0, 1)}
>>> found = axode.forward_dynamics_at(arm, 0, q, v, np.zeros(7), motions=lift)
>>> round(float(found.a[1]), 9)
1.0
)");
  module.def(
      "kinematic_motion", &kinematic_motion_of, "m"_a, "times"_a, "q"_a = nb::none(), nb::kw_only(),
      "motions"_a = nb::none(),
      nb::sig(
          "def kinematic_motion(m: Model, times: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike | None = "
          "None, *, motions: collections.abc.Mapping[str, collections.abc.Callable[[float], "
          "numpy.typing.ArrayLike]] | None = None) -> axode.records.KinematicMotion"),
      R"(
Positions, velocities, accelerations and jerks of a mechanism whose motions use up its mobility, without dynamics.

times (N,) increase; q (nq,) is near the configuration at the first of them, and the initial state if it is left out.
`motions` are functions t -> (s, ds, dds, ddds) by joint or rod, in addition to those of the drawing. A motion that
cannot be followed further ends early: `complete` is False, and `stop_reason` names the singularity.

>>> turn = {"crank_joint": lambda t: (0.1 * t, 0.1, 0, 0)}
>>> axode.kinematic_motion(fourbar, [0, 1, 2], motions=turn).q.shape
(3, 3)
)");
}

}  // namespace axode::python
