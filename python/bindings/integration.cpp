#include "axode/integration.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <optional>

#include "axode/batch.hpp"
#include "axode/batch/portions.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/view/mesh_hull.hpp"
#include "python/bindings/drives.hpp"
#include "python/bindings/states/prescribed_motion.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/trajectory.hpp"

/// Motion in time. Arguments are prepared and documented in the Python module axode.simulation.
namespace axode::python {

using namespace nb::literals;

namespace {

/// Calls a Python function f(t, q, v) with arrays and returns its result.
nb::object call_back(const nb::callable& f, double t, std::span<const double> q, std::span<const double> v) {
  return f(t, to_array(q), to_array(v));
}

/// The value that belongs to a word in a table of words and values.
template <class Value, std::size_t N>
const Value& chosen(const char* argument, nb::handle given,
                    const std::array<std::pair<std::string_view, Value>, N>& table) {
  std::array<std::string_view, N> words;
  for (std::size_t k = 0; k < N; ++k) words[k] = table[k].first;
  return table[choose(argument, given, words)].second;
}

BoundTrajectory simulate_of(const BoundModel& m, ArrayLike q, ArrayLike v, double until, nb::handle method,
                            nb::handle coordinates, nb::handle local_coordinates, nb::handle step,
                            double rtol, double atol, double spectral_radius, nb::handle tau,
                            nb::handle loads, bool joint_losses, nb::handle times, nb::handle given_events,
                            nb::handle motions, nb::handle x, nb::handle progress) {
  const States states = one_state(m, q);
  const Items velocities = states.velocities("v", v);
  const nb::list events = nb::borrow<nb::list>(given_events);
  SimulationOptions options;
  options.joint_losses = joint_losses;
  options.motions = motions_from(motions);
  if (!x.is_none()) {
    const Numbers given("x", {x.ptr()});
    if (given.axes() != 1) given.wrong_shape("(nx,), the states of the drives");
    options.x.assign(given.data(), given.data() + given.size());
  }
  const auto add_loads = [&states](LoadList given, std::vector<AppliedWrench<>>& all) {
    AppliedLoads(states, given, false).with(0, [&](const Loads<double>& now) {
      all.insert(all.end(), now.wrenches.begin(), now.wrenches.end());
      return 0;
    });
  };
  bool calls_back = !progress.is_none() || events.size() > 0 || !options.motions.empty();
  if (nb::isinstance<nb::callable>(loads)) {
    calls_back = true;
    options.computed_loads = [add_loads, f = nb::borrow<nb::callable>(loads)](
                                 double t, std::span<const double> q_t, std::span<const double> v_t,
                                 std::vector<AppliedWrench<>>& all) {
      const nb::object result = call_back(f, t, q_t, v_t);
      add_loads({result.ptr()}, all);
    };
  } else {
    add_loads({loads.ptr()}, options.loads);
  }

  std::optional<Items> constant;
  if (nb::isinstance<BoundDrive>(tau)) {
    const BoundDrive& drive = nb::cast<BoundDrive&>(tau);
    check_drive(m, drive);
    options.drive = drive.drive;
  } else if (nb::isinstance<nb::callable>(tau)) {
    calls_back = true;
    options.drive = [&m, f = nb::borrow<nb::callable>(tau)](double t, std::span<const double> q_t,
                                                            std::span<const double> v_t,
                                                            std::span<double> out) {
      const nb::object result = call_back(f, t, q_t, v_t);
      const Numbers numbers("tau(t, q, v)", {result.ptr()});
      const Shape expected{m->nv()};
      if (numbers.axes() != 1 || !numbers.ends_with(expected))
        numbers.wrong_shape(expected.text() + ", nv numbers");
      std::copy_n(numbers.data(), out.size(), out.begin());
    };
  } else if (!tau.is_none()) {
    constant.emplace(states.velocities("tau", {tau.ptr()}));
    options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> out) {
      std::ranges::copy((*constant)[0], out.begin());
    };
  }
  for (std::size_t k = 0; k < events.size(); ++k) {
    const nb::object given = events[k];
    if (!nb::isinstance<nb::callable>(given))
      throw nb::value_error(("events[" + std::to_string(k) +
                             "]: expected a function (t, q, v) -> number, got " + type_of(given))
                                .c_str());
    const auto attribute = [&](const char* name) {
      return nb::hasattr(given, name) ? nb::object(given.attr(name)) : nb::object(nb::int_(0));
    };
    options.events.push_back(
        {.value = [f = nb::borrow<nb::callable>(given), name = "events[" + std::to_string(k) + "](t, q, v)"](
                      double t, std::span<const double> q_t,
                      std::span<const double> v_t) { return number(name, call_back(f, t, q_t, v_t)); },
         .direction = static_cast<int>(number("direction", attribute("direction"))),
         .terminal = nb::cast<bool>(nb::bool_(attribute("terminal")))});
  }

  std::optional<Numbers> sample_times;
  if (!times.is_none()) {
    sample_times.emplace("times", ArrayLike{times.ptr()});
    if (sample_times->axes() != 1) sample_times->wrong_shape("(N,), increasing from 0 to until");
    for (nb::ssize_t k = 0; k < sample_times->size(); ++k) {
      const double t = sample_times->data()[k];
      if (t < 0 || t > until || (k > 0 && !(t > sample_times->data()[k - 1])))
        throw nb::value_error(("times[" + std::to_string(k) + "] is " + to_text(t) +
                               "; times must increase, from 0 to until = " + to_text(until))
                                  .c_str());
    }
  }
  nb::object usual;
  if (method.is_none()) {
    const std::string_view name = usual_method(*m);
    usual = nb::str(name.data(), name.size());
    method = usual;
  }
  const Method& way = chosen("method", method, methods);
  if (!way.adapts && step.is_none() && way.usual_step == 0)
    throw nb::value_error(
        ("step: method '" + text_of(method) + "' takes fixed steps; expected their length in s").c_str());
  options.coordinates = chosen("coordinates", coordinates, coordinate_kinds);
  options.local_coordinates = chosen("local_coordinates", local_coordinates, local_coordinate_kinds);

  const double length = step.is_none() ? way.usual_step : number("step", step);
  if (!step.is_none()) check_step(length);

  LongCall call(!calls_back);
  double now = 0;
  const batch::Monitor tell = [&, look = call.monitor()](std::size_t, std::size_t) {
    if (!progress.is_none()) progress(now);
    return look(0, 0);
  };
  batch::MonitorThrottle throttle(tell, 0);
  options.monitor = [&](double t) {
    now = t;
    return throttle.should_continue(0);
  };
  const std::span<const double> q_0 = states.q(0), v_0 = velocities[0];
  std::optional<ContactShapes> shapes;
  if (way.touches) shapes.emplace(*m, hull_of_mesh);
  BoundTrajectory found{way.simulate({*m,
                                      q_0,
                                      v_0,
                                      until,
                                      length,
                                      {.relative = rtol, .absolute = atol},
                                      spectral_radius,
                                      options,
                                      shapes ? &*shapes : nullptr}),
                        {}};
  call.end();
  if (sample_times)
    found.sample({sample_times->data(), static_cast<std::size_t>(sample_times->size())}, options.drive,
                 calls_back);
  return found;
}

}  // namespace

void add_integration(nb::module_& module) {
  add_trajectory(module);
  module.def("simulate_motion", &simulate_of, "m"_a, "q"_a, "v"_a, "until"_a, "method"_a.none(),
             "coordinates"_a, "local_coordinates"_a, "step"_a.none(), "rtol"_a, "atol"_a, "spectral_radius"_a,
             "tau"_a.none(), "loads"_a.none(), "joint_losses"_a, "times"_a.none(), "events"_a,
             "motions"_a.none(), "x"_a.none(), "progress"_a.none(), "See axode.simulate.");
}

}  // namespace axode::python
