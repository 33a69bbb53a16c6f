#include "python/bindings/drives.hpp"

#include "axode/drives/linearization.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/trajectory.hpp"

/// Drives for simulations. The arguments are documented in the Python module axode.drives.
namespace axode::python {

using namespace nb::literals;

namespace {

std::span<const double> span_of(const Numbers& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

/// The gains in an argument: one number for all velocities, or one for each velocity.
Numbers gains(const BoundModel& m, const char* name, ArrayLike given) {
  Numbers numbers(name, given);
  const Shape expected{m->nv()};
  if (numbers.axes() > 1 || (numbers.axes() == 1 && !numbers.ends_with(expected)))
    numbers.wrong_shape("() or " + expected.text() + ", nv numbers");
  return numbers;
}

/// The numbers of an argument that has one number for each velocity of one state.
Numbers one_velocity(const BoundModel& m, const char* name, nb::handle given) {
  Numbers numbers(name, {given.ptr()});
  const Shape expected{m->nv()};
  if (numbers.axes() != 1 || !numbers.ends_with(expected))
    numbers.wrong_shape(expected.text() + ", nv numbers");
  return numbers;
}

/// The reference motion that a controller follows. `q` is either an axode.Trajectory, or one configuration. A
/// trajectory has its own velocities and accelerations, so that v and a must be None. A configuration, with
/// the velocities v and the accelerations a, is the reference at all times; for None, v or a is 0.
Reference reference(const BoundModel& m, nb::handle q, nb::handle v, nb::handle a) {
  if (const Trajectory* motion = motion_in(q)) {
    for (const auto& [name, given] : {std::pair{"v", v}, {"a", a}})
      if (!given.is_none())
        throw nb::value_error(
            (std::string(name) + ": leave it out, because q is a trajectory and has its own").c_str());
    return {*m, *motion};
  }
  const States state = one_state(m, {q.ptr()});
  const auto numbers = [&](const char* name, nb::handle given) -> std::vector<double> {
    if (given.is_none()) return {};
    const Numbers all = one_velocity(m, name, given);
    return {all.data(), all.data() + all.size()};
  };
  return {*m, state.q(0), numbers("v", v), numbers("a", a)};
}

BoundDrive sampled(const BoundModel& m, ArrayLike t, ArrayLike tau, bool hold) {
  const Numbers times("t", t), forces("tau", tau);
  if (times.axes() != 1) times.wrong_shape("(K,)");
  const Shape expected{times.size(), m->nv()};
  if (forces.axes() != 2 || !forces.ends_with(expected))
    forces.wrong_shape(expected.text() + ", nv numbers for each time");
  return {*m, SampledDrive(*m, span_of(times), span_of(forces), hold)};
}

BoundDrive proportional_derivative(const BoundModel& m, ArrayLike kp, ArrayLike kd, nb::handle q,
                                   nb::handle v, nb::handle feedforward, bool clip) {
  const Numbers p = gains(m, "kp", kp), d = gains(m, "kd", kd);
  Drive forward;
  if (nb::isinstance<BoundDrive>(feedforward)) {
    forward = nb::cast<BoundDrive&>(feedforward).drive;
  } else if (!feedforward.is_none()) {
    const std::array<double, 1> always{0};
    forward = SampledDrive(*m, always, span_of(one_velocity(m, "feedforward", feedforward)));
  }
  return {*m, ProportionalDerivative(*m, {span_of(p), span_of(d)}, reference(m, q, v, nb::none()), forward,
                                     clip)};
}

BoundDrive computed_torque(const BoundModel& m, ArrayLike kp, ArrayLike kd, nb::handle q, nb::handle v,
                           nb::handle a) {
  const Numbers p = gains(m, "kp", kp), d = gains(m, "kd", kd);
  return {*m, ComputedTorque(*m, {span_of(p), span_of(d)}, reference(m, q, v, a))};
}

Array forces(BoundDrive& drive, double t, ArrayLike q, ArrayLike v) {
  const BoundModel m(drive.model);
  const States state = one_state(m, q);
  const Items velocities = state.velocities("v", v);
  NewArray tau({m->nv()});
  drive.drive(t, state.q(0), velocities[0], tau.all());
  return tau.array();
}

/// The drives of a mechanism and their states x: the given ones or, for None, those at the start of a motion.
struct DrivesAt {
  DrivesAt(const Model& m, double t, std::span<const double> q, std::span<const double> v, nb::handle given)
      : drives(m), x(drives.nx()) {
    if (given.is_none()) {
      drives.start(t, q, v, x);
      return;
    }
    const Numbers numbers("x", {given.ptr()});
    const Shape expected{static_cast<nb::ssize_t>(x.size())};
    if (numbers.axes() != 1 || !numbers.ends_with(expected))
      numbers.wrong_shape(expected.text() + ", a number for each state of the drives");
    std::ranges::copy(span_of(numbers), x.begin());
  }
  nb::list states() const {
    nb::list all;
    for (const DriveState& state : drives.states()) all.append(to_str(state.name));
    return all;
  }
  DriveSystem drives;
  std::vector<double> x;
};

nb::object linearize_with_drives_of(const BoundModel& m, ArrayLike q, ArrayLike v, nb::handle x, double t,
                                    LoadList loads, bool joint_losses) {
  const States states = one_state(m, q);
  const Items of_v = states.velocities("v", v);
  const AppliedLoads applied(states, loads, joint_losses);
  DrivesAt at(m, number("t", nb::float_(t)), states.q(0), of_v[0], x);
  const DriveLinearization found = applied.with(0, [&](const Loads<double>& now) {
    return linearize_with_drives(m, at.drives, t, states.q(0), of_v[0], at.x, now);
  });
  const Shape square{found.A.rows(), found.A.rows()};
  NewArray A = states.result(square);
  as_eigen(item(A, 0, square)) = found.A.transpose().reshaped();  // arrays are stored row by row
  states.refuse({found.solvability}, A);
  nb::list inputs;
  for (const std::size_t drive : at.drives.inputs()) inputs.append(to_str(at.drives.name(drive)));
  return record("DriveLinearization", A.array(), to_array(found.B), at.states(), inputs);
}

nb::object equilibrium_with_drives_of(const BoundModel& m, ArrayLike q, nb::handle x, double t) {
  const States states = one_state(m, q);
  const std::vector<double> still(static_cast<std::size_t>(m->nv()));
  DrivesAt at(m, number("t", nb::float_(t)), states.q(0), still, x);
  const DriveEquilibrium found = equilibrium_with_drives(m, at.drives, t, states.q(0), at.x);
  return record("DriveEquilibrium", found.found, to_array(found.q), to_array(found.x), at.states(),
                found.residual);
}

}  // namespace

void check_drive(const BoundModel& m, const BoundDrive& drive) {
  if (drive.model.nq() != m->nq() || drive.model.nv() != m->nv())
    throw nb::value_error(
        ("tau: a drive of model \"" + drive.model.name() + "\", which has other velocities").c_str());
}

void add_drives(nb::module_& module) {
  nb::class_<BoundDrive>(module, "Drive",
                         "A drive of one mechanism: a function (t, q, v) -> tau, see axode.drives.")
      .def("__call__", &forces, "t"_a, "q"_a, "v"_a, "tau (nv,) at a time and state.");
  module.def("linearize_with_drives", &linearize_with_drives_of, "m"_a, "q"_a, "v"_a, "x"_a = nb::none(),
             "t"_a = 0.0, "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
             nb::sig("def linearize_with_drives(m: Model, q: numpy.typing.ArrayLike, v: "
                     "numpy.typing.ArrayLike, x: numpy.typing.ArrayLike | None = None, t: float = 0.0, "
                     "loads: collections.abc.Sequence[axode.Load] | None = None, *, joint_losses: bool = "
                     "False) -> axode.records.DriveLinearization"),
             R"(
The linear system z' = A z + B du of small deviations z = (delta, dv, dx) of a mechanism with drives, see `DriveLinearization`.

The deviations are from the motion through q (nq,), v (nv,) and the states x (nx,) of the drives at the time t (s); delta and
dv are those of `linearize`, and dx are changes of x, in the units of docs/drives.md. If x is left out, it is that with which
a motion starts. The drives have the statuses that belong to the state. Springs act; loads and joint_losses are those of
`linearize`. O(nv^3 + nx^2) (eq. (D17.4)). ValueError for loops and prescribed motions; SingularError, with A, if the mass
matrix is singular.

>>> wheel = axode.Builder("wheel", gravity=[0, 0, 0]).body(
...     "wheel", joint={"name": "axle", "kind": "revolute", "axis": "z", "point": [0, 0, 0]}, mass=1, com=[0, 0, 0],
...     inertia=[0.01, 0.01, 0.02]).drive("dc_motor", "axle", name="motor", resistance=1, inductance=0.01,
...                                       torque_constant=0.1, input={"kind": "ramp", "to": 12, "end": 1}).build()
>>> small = axode.linearize_with_drives(wheel, [0], [0])
>>> small.states, small.A.round(6) + 0
(['motor.current'], array([[   0.,    1.,    0.],
       [   0.,    0.,    5.],
       [   0.,  -10., -100.]]))
)");
  module.def("equilibrium_with_drives", &equilibrium_with_drives_of, "m"_a, "q"_a, "x"_a = nb::none(),
             "t"_a = 0.0,
             nb::sig("def equilibrium_with_drives(m: Model, q: numpy.typing.ArrayLike, x: "
                     "numpy.typing.ArrayLike | None = None, t: float = 0.0) -> "
                     "axode.records.DriveEquilibrium"),
             R"(
A state of rest of a mechanism with drives near q (nq,) and x (nx,), at the inputs of the time t (s), see `DriveEquilibrium`.

Nothing accelerates there, and x' = 0. The method is Newton's with exact derivatives; where these are singular, as for trapped
oil or an integrator, it finds the nearest such state. If x is left out, it is that with which a motion starts. Springs act.
ValueError for loops and prescribed motions.

>>> wheel = axode.Builder("wheel", gravity=[0, 0, 0]).body(
...     "wheel", joint={"name": "axle", "kind": "revolute", "axis": "z", "point": [0, 0, 0], "spring": {"stiffness": 4.0}},
...     mass=1, com=[0, 0, 0], inertia=[0.01, 0.01, 0.02]).drive("dc_motor", "axle", name="motor", resistance=1,
...                                                              inductance=0.01, torque_constant=0.1, input=12).build()
>>> rest = axode.equilibrium_with_drives(wheel, [0])
>>> rest.found, rest.q.round(9), rest.x.round(9)  # 0.1 N m/A times 12 A against 4 N m/rad
(True, array([0.3]), array([12.]))
)");
  module.def("sampled_drive", &sampled, "m"_a, "t"_a, "tau"_a, "hold"_a, "See axode.drives.Sampled.");
  module.def("pd_drive", &proportional_derivative, "m"_a, "kp"_a, "kd"_a, "q"_a, "v"_a.none(),
             "feedforward"_a.none(), "clip"_a, "See axode.drives.PD.");
  module.def("computed_torque_drive", &computed_torque, "m"_a, "kp"_a, "kd"_a, "q"_a, "v"_a.none(),
             "a"_a.none(), "See axode.drives.ComputedTorque.");
}

}  // namespace axode::python
