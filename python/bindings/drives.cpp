#include "python/bindings/drives.hpp"

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/one_state.hpp"

/// Drives for simulations. Arguments are documented in axode.drives.
namespace axode::python {

using namespace nb::literals;

namespace {

std::span<const double> span_of(const Numbers& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

/// The gains that are given: one number, or one for each velocity.
Numbers gains(const BoundModel& m, const char* name, ArrayLike given) {
  Numbers numbers(name, given);
  const Shape expected{m->nv()};
  if (numbers.axes() > 1 || (numbers.axes() == 1 && !numbers.ends_with(expected)))
    numbers.wrong_shape("() or " + expected.text() + ", nv numbers");
  return numbers;
}

/// An argument with a number for each velocity of one state.
Numbers one_velocity(const BoundModel& m, const char* name, nb::handle given) {
  Numbers numbers(name, {given.ptr()});
  const Shape expected{m->nv()};
  if (numbers.axes() != 1 || !numbers.ends_with(expected))
    numbers.wrong_shape(expected.text() + ", nv numbers");
  return numbers;
}

/// The reference of a controller: `q` is a trajectory, or a configuration with the velocities v and
/// accelerations a.
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
  module.def("sampled_drive", &sampled, "m"_a, "t"_a, "tau"_a, "hold"_a, "See axode.drives.Sampled.");
  module.def("pd_drive", &proportional_derivative, "m"_a, "kp"_a, "kd"_a, "q"_a, "v"_a.none(),
             "feedforward"_a.none(), "clip"_a, "See axode.drives.PD.");
  module.def("computed_torque_drive", &computed_torque, "m"_a, "kp"_a, "kd"_a, "q"_a, "v"_a.none(),
             "a"_a.none(), "See axode.drives.ComputedTorque.");
}

}  // namespace axode::python
