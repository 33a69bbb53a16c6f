#include "axode/integration.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>

#include "axode/batch.hpp"
#include "axode/batch/portions.hpp"
#include "axode/drives.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration/momenta/simulate_contact.hpp"
#include "axode/view/mesh_hull.hpp"
#include "python/bindings/contact_force.hpp"
#include "python/bindings/drives.hpp"
#include "python/bindings/states/prescribed_motion.hpp"
#include "python/bindings/states/specialised.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/long_call.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/raise.hpp"

/// Motion in time. Arguments are prepared and documented in axode.simulation.
namespace axode::python {

using namespace nb::literals;

namespace {

/// Calls a Python function f(t, q, v).
nb::object call_back(const nb::callable& f, double t, std::span<const double> q, std::span<const double> v) {
  return f(t, to_array(q), to_array(v));
}

/// Calls f(k) for every k from 0 to count - 1. Ctrl-C ends the call; other Python threads run meanwhile,
/// unless f calls back into Python.
template <class F> void each_of(std::size_t count, const F& f, bool calls_back = false) {
  LongCall call(!calls_back && count > 20);
  const batch::Monitor monitor = call.monitor();
  batch::MonitorThrottle throttle(monitor, count);
  for (std::size_t k = 0; k < count && throttle.should_continue(k); ++k) f(k);
  call.end();
}

/// A motion, and the states of it that were asked for: the ends of its steps, or states at given times.
struct BoundTrajectory {
  Trajectory motion;
  std::optional<Trajectory> samples;

  const Trajectory& shown() const { return samples ? *samples : motion; }
  /// Interpolates the states at the given times, as far as these are not after the end of the motion.
  void sample(std::span<const double> times, const Drive& drive, bool calls_back) {
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
};

/// A member of Trajectory that returns numbers row by row, nv or nq in each row.
using RowsOf = std::span<const double> (Trajectory::*)() const;
Array rows(const BoundTrajectory& of, RowsOf which, int width) {
  const Trajectory& shown = of.shown();
  NewArray out({static_cast<nb::ssize_t>(shown.size()), width});
  std::ranges::copy((shown.*which)(), out.all().begin());
  return out.array();
}
Array rows(const BoundTrajectory& of, RowsOf which) { return rows(of, which, of.motion.model().nv()); }
/// Calls f(workspace, q, v, numbers) for every state of a motion. f writes the numbers of the state, an array
/// of this shape.
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

/// The points of contact at each time.
nb::list contacts_of(const BoundTrajectory& of) {
  const Trajectory& shown = of.shown();
  nb::list all;
  for (std::size_t k = 0; k < shown.size(); ++k)
    all.append(contact_list(of.motion.contact_shapes, shown.contacts(k)));
  return all;
}

/// The sum of the forces of contacts on a collision shape or, if no shape has this name, on a body.
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

std::vector<std::string> drive_states(const BoundTrajectory& of) {
  return {of.motion.drive_states().begin(), of.motion.drive_states().end()};
}

/// The motion as a DataFrame of pandas, with a row for each time and a named column for each number of a
/// state.
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

/// The value in a table that belongs to a word.
template <class Value, std::size_t N>
const Value& chosen(const char* argument, nb::handle given,
                    const std::array<std::pair<std::string_view, Value>, N>& table) {
  std::array<std::string_view, N> words;
  for (std::size_t k = 0; k < N; ++k) words[k] = table[k].first;
  return table[choose(argument, given, words)].second;
}

void check_drive(const BoundModel& m, const BoundDrive& drive) {
  if (drive.model.nq() != m->nq() || drive.model.nv() != m->nv())
    throw nb::value_error(
        ("tau: a drive of model \"" + drive.model.name() + "\", which has other velocities").c_str());
}

BoundTrajectory simulate_of(const BoundModel& m, ArrayLike q, ArrayLike v, double until, nb::handle method,
                            nb::handle coordinates, nb::handle local_coordinates, nb::handle step,
                            double rtol, double atol, double spectral_radius, nb::handle tau,
                            nb::handle loads, bool joint_losses, nb::handle times, nb::handle given_events,
                            nb::handle motions, nb::handle progress) {
  const States states = one_state(m, q);
  const Items velocities = states.velocities("v", v);
  const nb::list events = nb::borrow<nb::list>(given_events);
  SimulationOptions options;
  options.joint_losses = joint_losses;
  options.motions = motions_from(motions);
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
        throw nb::value_error(("times[" + std::to_string(k) + "] is " + std::to_string(t) +
                               "; times must increase, from 0 to until = " + std::to_string(until))
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
  const bool contact = text_of(method) == "contact";
  BoundTrajectory found{
      contact ? simulate_contact(*m, ContactShapes(*m, hull_of_mesh), q_0, v_0, until, length, options)
              : way.simulate({*m,
                              q_0,
                              v_0,
                              until,
                              length,
                              {.relative = rtol, .absolute = atol},
                              spectral_radius,
                              options}),
      {}};
  call.end();
  if (sample_times)
    found.sample({sample_times->data(), static_cast<std::size_t>(sample_times->size())}, options.drive,
                 calls_back);
  return found;
}

/// The K steps of all motions: their length, and the forces or the drive under which they move.
struct Steps {
  std::span<const double> v, tau;
  const Drive* drive;
  nb::ssize_t K;
  double length;
  bool joint_losses;
};
template <class S, class M>
batch::Outcome roll(const M& model, const Steps& steps, int threads, std::span<const S> q,
                    std::span<const S> v, std::span<const S> tau, std::span<S> q_out, std::span<S> v_out,
                    const batch::Monitor& monitor) {
  if (steps.drive)
    return batch::rollout<S>(model, q, v, *steps.drive, static_cast<std::size_t>(steps.K), steps.length,
                             q_out, v_out, runge_kutta(4), threads, monitor, steps.joint_losses);
  return batch::rollout<S>(model, q, v, tau, steps.length, q_out, v_out, runge_kutta(4), threads, monitor,
                           steps.joint_losses);
}
/// Computes the motions by the model, or by code that was compiled for it, in the precision of that code.
batch::Outcome roll(const States& states, const BoundSpecialised* compiled, const Steps& steps,
                    std::span<double> q_out, std::span<double> v_out, const batch::Monitor& monitor) {
  const auto in_double = [&](const auto& model) {
    return roll<double>(model, steps, states.threads(), states.q(), steps.v, steps.tau, q_out, v_out,
                        monitor);
  };
  if (!compiled) return in_double(states.model());
  if (!compiled->is_single()) return in_double(std::get<Specialised<double>>(compiled->functions()));
  const auto cast = [](std::span<const double> x) { return std::vector<float>(x.begin(), x.end()); };
  std::vector<float> q(q_out.size()), v(v_out.size());
  const batch::Outcome outcome =
      roll<float>(std::get<Specialised<float>>(compiled->functions()), steps, states.threads(),
                  cast(states.q()), cast(steps.v), cast(steps.tau), q, v, monitor);
  std::ranges::copy(q, q_out.begin());
  std::ranges::copy(v, v_out.begin());
  return outcome;
}

std::tuple<Array, Array> motions_of(const States& states, const BoundSpecialised* compiled,
                                    const Steps& steps) {
  const nb::ssize_t K = steps.K;
  if (compiled) compiled->check({"forward_dynamics"});
  const int nq = states.model().nq(), nv = states.model().nv();
  const Shape shape_v{K + 1, nv};
  NewArray q_out = states.result({K + 1, nq}), v_out = states.result(shape_v);
  const batch::Outcome outcome =
      states.unlocked(100.0 * static_cast<double>(K), [&](const batch::Monitor& monitor) {
        return roll(states, compiled, steps, q_out.all(), v_out.all(), monitor);
      });
  if (outcome.loops_open) {
    std::vector<std::size_t> torn;
    for (std::size_t n = outcome.first; n < states.count(); ++n)
      if (!all_finite(item(v_out, n, shape_v))) torn.push_back(n);
    raise_of_states("SingularError",
                    (states.many() ? "state " + std::to_string(outcome.first) + ": " : std::string()) +
                        "the loops cannot be kept closed; a shorter step may help",
                    torn, q_out.array());
  }
  if (!outcome.ok()) {
    std::vector<Solvability> found(states.count());
    for (std::size_t n = outcome.first; n < found.size(); ++n)
      if (!all_finite(item(v_out, n, shape_v))) found[n] = outcome.solvability;
    states.refuse(found, q_out);
  }
  Array q = q_out.array(), v = v_out.array();
  if (compiled && compiled->is_single())
    for (Array* x : {&q, &v}) x->array = x->array.attr("astype")("float32");
  return {q, v};
}

std::tuple<Array, Array> rollout_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, double step,
                                    const BoundSpecialised* compiled, int threads, bool joint_losses) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  const Numbers forces("tau", tau);
  const int axis = states.many() ? 1 : 0;  // the axis of the steps
  const nb::ssize_t K = forces.axes() == axis + 2 ? forces.length(axis) : 0;
  const Shape one{K, m->nv()},
      expected = states.many() ? one.times(static_cast<nb::ssize_t>(states.count())) : one;
  if (forces.axes() != axis + 2 || !forces.ends_with(expected))
    forces.wrong_shape(std::string(states.many() ? "(" + std::to_string(states.count()) + ", K, " : "(K, ") +
                       std::to_string(m->nv()) + "), nv numbers for each step");
  return motions_of(states, compiled,
                    {velocities.all(),
                     {forces.data(), static_cast<std::size_t>(forces.size())},
                     nullptr,
                     K,
                     step,
                     joint_losses});
}

std::tuple<Array, Array> driven_rollout_of(const BoundModel& m, ArrayLike q, ArrayLike v,
                                           const BoundDrive& drive, nb::ssize_t K, double step,
                                           const BoundSpecialised* compiled, int threads, bool joint_losses) {
  const States states(m, q, threads);
  const Items velocities = states.velocities("v", v);
  check_drive(m, drive);
  return motions_of(states, compiled, {velocities.all(), {}, &drive.drive, K, step, joint_losses});
}

enum class Reconstruction { munthe_kaas, cayley, magnus, apart };
constexpr std::array<std::pair<std::string_view, Reconstruction>, 4> reconstructions{
    {{"munthe_kaas", Reconstruction::munthe_kaas},
     {"cayley", Reconstruction::cayley},
     {"magnus", Reconstruction::magnus},
     {"apart", Reconstruction::apart}}};

/// Times at which a method of reconstruction reads the twist, as parts of a step.
std::vector<double> stage_times(int order, nb::handle method) {
  if (chosen("method", method, reconstructions) != Reconstruction::magnus) return runge_kutta(order).c;
  if (order != 4) throw nb::value_error("order: Magnus' method is of order 4");
  return {magnus_points.begin(), magnus_points.end()};
}

Array reconstruct_of(ArrayLike C0, ArrayLike twists, ArrayLike times, Representation representation,
                     int order, nb::handle given_method) {
  const Numbers start("C0", C0), V("twist", twists), t("times", times);
  if (start.axes() != 2 || !start.ends_with({4, 4})) start.wrong_shape("(4, 4), a pose");
  const Reconstruction way = chosen("method", given_method, reconstructions);
  const std::size_t stages = stage_times(order, given_method).size(), N = static_cast<std::size_t>(t.size());
  const Shape expected{static_cast<nb::ssize_t>(N > 0 ? N - 1 : 0), static_cast<nb::ssize_t>(stages), 6};
  if (V.axes() != 3 || !V.ends_with(expected)) V.wrong_shape(expected.text());
  std::size_t asked = 0;
  const auto next = [&]<class Rep>(Rep) {
    const double* x = V.data() + 6 * asked++;
    return Twist<Rep>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
  };
  const std::span<const double> at(t.data(), N);
  const SE3<> C = pose_from("C0", start.data());
  const auto by = [&]<class Rep>(Rep rep) {
    const auto twist = [&](double) { return next(rep); };
    if (way == Reconstruction::magnus) return reconstruct_magnus<Rep>(C, twist, at);
    const Tableau& method = runge_kutta(order);
    if (way == Reconstruction::apart) return reconstruct_apart<Rep>(C, twist, at, method);
    return reconstruct<Rep>(
        C, twist, at, method,
        way == Reconstruction::cayley ? LocalCoordinates::cayley : LocalCoordinates::exponential);
  };
  std::vector<SE3<>> found;
  if (representation == Representation::body)
    found = by(BodyFixed{});
  else if (representation == Representation::spatial)
    found = by(Spatial{});
  else
    throw nb::value_error("representation must be 'body' or 'spatial' to integrate a twist to a pose");
  NewArray out({static_cast<nb::ssize_t>(N), 4, 4});
  for (std::size_t k = 0; k < N; ++k) write(found[k], out.data() + 16 * k);
  return out.array();
}

}  // namespace

const Trajectory* motion_in(nb::handle given) {
  return nb::isinstance<BoundTrajectory>(given) ? &nb::cast<BoundTrajectory&>(given).motion : nullptr;
}

const Trajectory* shown_in(nb::handle given) {
  return nb::isinstance<BoundTrajectory>(given) ? &nb::cast<BoundTrajectory&>(given).shown() : nullptr;
}

void add_integration(nb::module_& module) {
  nb::class_<BoundTrajectory>(module, "Trajectory",
                              R"(
A motion from `simulate`: its states at the ends of its steps, or at the given times, with interpolation in between.

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
          "evaluations", [](const BoundTrajectory& x) { return x.motion.evaluations; }, "Of accelerations.")
      .def_prop_ro(
          "certificates", [](const BoundTrajectory& x) { return to_array(x.motion.certificates); },
          "How exactly the laws of contact hold in each step, 1e-12 being rounding; empty without contact.")
      .def_prop_ro("contacts", &contacts_of,
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
  module.def("simulate_motion", &simulate_of, "m"_a, "q"_a, "v"_a, "until"_a, "method"_a.none(),
             "coordinates"_a, "local_coordinates"_a, "step"_a.none(), "rtol"_a, "atol"_a, "spectral_radius"_a,
             "tau"_a.none(), "loads"_a.none(), "joint_losses"_a, "times"_a.none(), "events"_a,
             "motions"_a.none(), "progress"_a.none(), "See axode.simulate.");
  module.def("rollout_under", &rollout_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "compiled"_a = nb::none(),
             nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false, "See axode.rollout.");
  module.def("rollout_driven", &driven_rollout_of, "m"_a, "q"_a, "v"_a, "drive"_a, "steps"_a, "step"_a,
             "compiled"_a = nb::none(), nb::kw_only(), "threads"_a = 1, "joint_losses"_a = false,
             "See axode.rollout.");
  module.def("reconstruct_poses", &reconstruct_of, "C0"_a, "twists"_a, "times"_a, "representation"_a,
             "order"_a, "method"_a, "See axode.reconstruct.");
  module.def(
      "stage_times", [](int order, nb::handle method) { return to_array(stage_times(order, method)); },
      "order"_a, "method"_a, "Stage times of a method as parts of a step, from 0 to 1.");
}

}  // namespace axode::python
