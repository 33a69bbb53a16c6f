#include "python/bindings/trajectory.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "axode/batch/portions.hpp"
#include "axode/drives.hpp"
#include "axode/dynamics.hpp"
#include "python/bindings/contact_force.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/named_tuple.hpp"

namespace axode::python {

using namespace nb::literals;

namespace {

/// Calls f(k) for k = 0 to count - 1, and stops if Ctrl-C is pressed. If count > 20, other Python threads can
/// run during the call, unless f calls back into Python.
template <class F> void each_of(std::size_t count, const F& f, bool calls_back = false) {
  LongCall call(!calls_back && count > 20);
  const batch::Monitor monitor = call.monitor();
  batch::MonitorThrottle throttle(monitor, count);
  for (std::size_t k = 0; k < count && throttle.should_continue(k); ++k) f(k);
  call.end();
}

/// A member function of Trajectory that returns a number of values (such as nv) for each time.
using RowsOf = std::span<const double> (Trajectory::*)() const;
Array rows(const BoundTrajectory& of, RowsOf which, int width) {
  const Trajectory& shown = of.shown();
  NewArray out({static_cast<nb::ssize_t>(shown.size()), width});
  std::ranges::copy((shown.*which)(), out.all().begin());
  return out.array();
}
Array rows(const BoundTrajectory& of, RowsOf which) { return rows(of, which, of.motion.model().nv()); }
/// Computes an array of results for the states of a motion. f(workspace, q, v, numbers) must write the result
/// of one state, an array of the shape `shape`, to `numbers`.
template <class F> Array of_states(const BoundTrajectory& of, const Shape& shape, const F& f) {
  const Trajectory& shown = of.shown();
  NewArray out(shape.times(static_cast<nb::ssize_t>(shown.size())));
  Workspace<> workspace(shown.model());
  each_of(shown.size(), [&](std::size_t k) { f(workspace, shown.q(k), shown.v(k), item(out, k, shape)); });
  return out.array();
}

Array energies(const BoundTrajectory& of) {
  return of_states(of, {}, [&](Workspace<>& w, auto q, auto v, std::span<double> out) {
    const Model& m = of.motion.model();
    out[0] = kinetic_energy<double>(m, w, q, v) + potential_energy<double>(m, w, q) +
             elastic_energy<double>(m, w, q);
  });
}

/// The points of contact at each time, as a list of lists.
nb::list contacts_by_time(const BoundTrajectory& of) {
  const Trajectory& shown = of.shown();
  nb::list all;
  for (std::size_t k = 0; k < shown.size(); ++k)
    all.append(contact_list(of.motion.contact_shapes, shown.contacts(k)));
  return all;
}

/// The sum of the contact forces on a collision shape or, if no shape has this name, on a body, at each time.
Array contact_forces_on(const BoundTrajectory& of, const std::string& name) {
  const Trajectory& shown = of.shown();
  const std::vector<std::string>& shapes = of.motion.contact_shapes;
  const auto shape = std::ranges::find(shapes, name);
  const bool is_shape = shape != shapes.end();
  const Model& model = of.motion.model();
  const int wanted =
      is_shape ? static_cast<int>(shape - shapes.begin()) : model.frame(model.frame_index(name)).body;
  NewArray out({static_cast<nb::ssize_t>(shown.size()), 3});
  for (std::size_t k = 0; k < shown.size(); ++k) {
    Vec3<> sum;
    for (const ContactForce& x : shown.contacts(k)) {
      if (wanted == (is_shape ? x.b : x.body_b)) sum += x.force;
      if (wanted == (is_shape ? x.a : x.body_a)) sum -= x.force;
    }
    std::ranges::copy(std::array{sum.x, sum.y, sum.z}, out.data() + 3 * k);
  }
  return out.array();
}

nb::list play_events_of(const BoundTrajectory& of) {
  nb::list all;
  for (const Trajectory::PlayEvent& x : of.motion.play_events)
    all.append(record("PlayEvent", to_str(x.coupling), x.t, x.side, x.impact, x.stays, x.speed, x.impulse));
  return all;
}

nb::list contact_events_of(const BoundTrajectory& of) {
  nb::list all;
  for (const Trajectory::ContactEvent& x : of.motion.contact_events)
    all.append(record("ContactEvent", to_str(std::string(to_string(x.kind))), x.t, to_str(x.of), x.speed,
                      x.shortened));
  return all;
}

std::vector<std::string> drive_states(const BoundTrajectory& of) {
  return {of.motion.drive_states().begin(), of.motion.drive_states().end()};
}

/// The motion as a pandas DataFrame, with a row for each time and a named column for each number of a state.
nb::object as_data_frame(const BoundTrajectory& of) {
  const Model& m = of.motion.model();
  nb::dict columns;
  const auto add = [&](const char* what, const std::vector<std::string>& names, const Array& all) {
    for (std::size_t c = 0; c < names.size(); ++c)
      columns[nb::str((what + (" " + names[c])).c_str())] = all.array[nb::make_tuple(nb::ellipsis(), c)];
  };
  add("q", coordinate_names(m), rows(of, &Trajectory::q, m.nq()));
  add("v", velocity_names(m), rows(of, &Trajectory::v));
  add("a", velocity_names(m), rows(of, &Trajectory::a));
  add("tau", velocity_names(m), rows(of, &Trajectory::tau));
  add("x", drive_states(of), rows(of, &Trajectory::x, static_cast<int>(of.motion.nx())));
  columns["energy"] = energies(of);
  const nb::module_ pandas = nb::module_::import_("pandas");
  const nb::object times = pandas.attr("Index")(to_array(of.shown().t()), "name"_a = "t");
  return pandas.attr("DataFrame")(columns, "index"_a = times);
}

}  // namespace

void BoundTrajectory::sample(std::span<const double> times, const Drive& drive, bool calls_back) {
  const Model& model = motion.model();
  std::vector<double> q(static_cast<std::size_t>(model.nq())), v(static_cast<std::size_t>(model.nv()));
  std::vector<double> a(v.size()), tau(v.size()), x(motion.nx()), dx(x);
  DriveSystem drives(model);
  const double end = motion.t().empty() ? -1 : motion.t().back();
  const auto after = std::ranges::upper_bound(times, end);
  samples.emplace(model);
  samples->contact_shapes = motion.contact_shapes;
  samples->set_drive_states({motion.drive_states().begin(), motion.drive_states().end()});
  const auto append = [&](std::size_t k) {
    motion.at(times[k], q, v, a);
    motion.drive_states_at(times[k], x);
    std::ranges::fill(tau, 0.0);
    if (drive) drive(times[k], q, v, tau);
    if (!drives.empty()) {
      drives.set_state(times[k], q, v, x);
      drives.evaluate(times[k], q, v, x, tau, dx);
    }
    samples->append(times[k], q, v, a, tau, x, dx);
    if (!motion.contact_shapes.empty()) samples->set_contacts(motion.contacts_at(times[k]));
  };
  each_of(static_cast<std::size_t>(after - times.begin()), append, calls_back);
}

const Trajectory* motion_in(nb::handle given) {
  return nb::isinstance<BoundTrajectory>(given) ? &nb::cast<BoundTrajectory&>(given).motion : nullptr;
}

nb::object bound_trajectory(Trajectory motion) {
  return nb::cast(BoundTrajectory{std::move(motion), std::nullopt});
}

const Trajectory* shown_in(nb::handle given) {
  return nb::isinstance<BoundTrajectory>(given) ? &nb::cast<BoundTrajectory&>(given).shown() : nullptr;
}

void add_trajectory(nb::module_& module) {
  nb::class_<BoundTrajectory>(module, "Trajectory",
                              R"(
A motion from `simulate`: its states at the ends of its steps, or at the given times, with interpolation in between.

Motions for drives to follow are made by `from_samples`, `from_functions` and the profiles of `axode.drives`.

>>> fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=0.5)
>>> fall.complete, bool(np.ptp(fall.energy) < 1e-6)
(True, True)
)")
      .def_prop_ro(
          "t", [](const BoundTrajectory& x) { return to_array(x.shown().t()); }, "(N,) times, s.")
      .def_prop_ro(
          "q", [](const BoundTrajectory& x) { return rows(x, &Trajectory::q, x.motion.model().nq()); },
          "(N, nq) configurations.")
      .def_prop_ro(
          "v", [](const BoundTrajectory& x) { return rows(x, &Trajectory::v); }, "(N, nv) velocities.")
      .def_prop_ro(
          "a", [](const BoundTrajectory& x) { return rows(x, &Trajectory::a); }, "(N, nv) accelerations.")
      .def_prop_ro(
          "tau", [](const BoundTrajectory& x) { return rows(x, &Trajectory::tau); },
          "(N, nv) drive forces, N m or N.")
      .def_prop_ro(
          "x",
          [](const BoundTrajectory& x) { return rows(x, &Trajectory::x, static_cast<int>(x.motion.nx())); },
          "(N, nx) states of the drives, in the units of docs/drives.md.")
      .def_prop_ro("drive_states", &drive_states, "Names of the states of the drives, the columns of x.")
      .def_prop_ro("energy", &energies, "Kinetic and potential energy, including springs and stops, (N,), J.")
      .def_prop_ro(
          "momentum",
          [](const BoundTrajectory& x) {
            return of_states(x, {6}, [&](Workspace<>& w, auto q, auto v, std::span<double> out) {
              write_screw(spatial_momentum<double>(x.motion.model(), w, q, v), out.data());
            });
          },
          "Spatial momentum of the mechanism about the inertial origin, (N, 6), N m s and N s.")
      .def_prop_ro(
          "steps", [](const BoundTrajectory& x) { return x.motion.steps; },
          "Number of steps that were taken.")
      .def_prop_ro(
          "rejected", [](const BoundTrajectory& x) { return x.motion.rejected; },
          "Number of steps that were rejected and repeated.")
      .def_prop_ro(
          "uncontrolled", [](const BoundTrajectory& x) { return x.motion.uncontrolled; },
          "Number of steps of \"dopri5\" whose errors rtol and atol do not control, because branches of the "
          "motion meet there.")
      .def_prop_ro(
          "evaluations", [](const BoundTrajectory& x) { return x.motion.evaluations; }, "Of accelerations.")
      .def_prop_ro(
          "certificates", [](const BoundTrajectory& x) { return to_array(x.motion.certificates); },
          "How exactly the laws of contact hold in each step, 1e-12 being rounding; empty without contact.")
      .def_prop_ro("contacts", &contacts_by_time,
                   nb::sig("def contacts(self) -> list[list[axode.records.ContactForce]]"),
                   R"(
The points of contact at each time, N lists of `ContactForce`: those with a gap below the margin, and those that pressed in
the step that ends there.

Forces are the means over this step, in which an impact is a force as well. The lists of the initial state, and of a motion
without contact, are empty.
)")
      .def("contact_forces", &contact_forces_on, "of"_a,
           nb::sig("def contact_forces(self, of: str) -> numpy.typing.NDArray[numpy.float64]"),
           R"(
The sum of the contact forces on a collision shape or a body at each time, (N, 3), N, in inertial axes.

KeyError for another name. The forces are those of `contacts`.

>>> ball = axode.Model.from_dict({"format": "axode drawing 1", "contact": {}, "body": [{
...     "name": "ball", "joint": {"kind": "prismatic", "axis": "z"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1],
...     "shape": [{"kind": "sphere", "role": "collision", "radius": 0.1}]}]})
>>> at_rest = axode.simulate(axode.with_floor(ball, -0.1), [0], [0], until=0.01)
>>> at_rest.contact_forces("ball")[-1].round(9)
array([0.  , 0.  , 9.81])
)")
      .def_prop_ro(
          "position_residuals",
          [](const BoundTrajectory& x) { return to_array(x.motion.position_residuals); },
          "Largest position residual of joints and loops at the end of each step, rad and m; empty unless "
          "the coordinates are absolute.")
      .def_prop_ro(
          "velocity_residuals",
          [](const BoundTrajectory& x) { return to_array(x.motion.velocity_residuals); },
          "Largest velocity residual of joints and loops at the end of each step, rad/s and m/s; empty "
          "unless the coordinates are absolute.")
      .def_prop_ro(
          "body_energy", [](const BoundTrajectory& x) { return to_array(x.motion.body_energies); },
          "Kinetic energy and potential energy of gravity at the end of each step from the motion of the "
          "bodies, J; empty unless the coordinates are absolute.")
      .def_prop_ro(
          "complete", [](const BoundTrajectory& x) { return x.motion.complete; },
          "Whether the motion reached its end or a terminal event.")
      .def_prop_ro(
          "stop_reason", [](const BoundTrajectory& x) { return nb::str(x.motion.stop_reason.c_str()); },
          "Why the motion ended early, in a sentence; '' if it is complete.")
      .def_prop_ro(
          "events",
          [](const BoundTrajectory& x) {
            nb::list out;
            for (const Trajectory::EventOccurrence& met : x.motion.events)
              out.append(nb::make_tuple(met.event, met.t));
            return out;
          },
          nb::sig("def events(self) -> list[tuple[int, float]]"),
          "Events that occurred, as pairs of the index in the list `events` and the time.")
      .def_prop_ro(
          "play_events", &play_events_of, nb::sig("def play_events(self) -> list[axode.records.PlayEvent]"),
          "The plays of couplings that met one of their ends or left it: a list of `PlayEvent` in the order "
          "of time.")
      .def_prop_ro("contact_events", &contact_events_of,
                   nb::sig("def contact_events(self) -> list[axode.records.ContactEvent]"),
                   R"(
The changes of contacts, hard stops and joints with dry friction in a motion by "contact_exact": a list of `ContactEvent` in the
order of time. Their times are roots, to about 1e-13 s.

>>> ball = axode.Model.from_dict({"format": "axode drawing 1", "contact": {}, "body": [{
...     "name": "ball", "joint": {"kind": "prismatic", "axis": "z"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1],
...     "shape": [{"kind": "sphere", "role": "collision", "radius": 0.1, "restitution": 0.5}]}]})
>>> fall = axode.simulate(axode.with_floor(ball, -1.1), [0], [0], until=1, method="contact_exact", rtol=1e-12)
>>> [(event.kind, round(event.t, 9)) for event in fall.contact_events]
[('bounce', 0.451523641), ('bounce', 0.903047282)]
)")
      .def(
          "at",
          [](const BoundTrajectory& x, ArrayLike t) {
            const Numbers times("t", t);
            if (times.axes() > 1) times.wrong_shape("() or (N,)");
            const Model& m = x.motion.model();
            const Shape one_q{m.nq()}, one_v{m.nv()};
            NewArray q(times.axes() == 0 ? one_q : one_q.times(times.size())),
                v(times.axes() == 0 ? one_v : one_v.times(times.size()));
            each_of(static_cast<std::size_t>(times.size()), [&](std::size_t k) {
              x.motion.at(times.data()[k], item(q, k, one_q), item(v, k, one_v));
            });
            return nb::make_tuple(q.array(), v.array());
          },
          "t"_a,
          nb::sig("def at(self, t: numpy.typing.ArrayLike) -> tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64]]"),
          R"(
(q, v) at a time, (nq,) and (nv,), or at N times, (N, nq) and (N, nv). ValueError for times outside the motion.

Between the ends of steps, configurations are interpolated by quintics on the group relative to the mean motion of the
step, so that bodies may turn by any angle in a step. Errors are of order h^6 in q and h^5 in v.

>>> fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=0.5)
>>> q, v = fall.at(0.25)
>>> q.shape, v.shape
((7,), (7,))
)")
      .def("to_pandas", &as_data_frame, nb::sig("def to_pandas(self) -> typing.Any"),
           R"(
The motion as a pandas.DataFrame. Its index is t, and its columns are "q NAME", "v NAME", "a NAME" and "tau NAME" for
every coordinate and velocity, and "energy".

Its methods to_parquet (with pyarrow) and to_csv write files. ModuleNotFoundError if pandas is not installed.

>>> fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=1, times=[0, 0.5, 1])
>>> fall.to_pandas().shape
(3, 29)
)")
      .def("__repr__", [](const BoundTrajectory& x) {
        return "Trajectory(" + std::to_string(x.motion.steps) + " steps" +
               (x.motion.t().empty() ? "" : " to t = " + std::to_string(x.motion.t().back()) + " s") +
               (x.motion.complete ? ")" : ", " + x.motion.stop_reason + ")");
      });
}

}  // namespace axode::python
