#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <tuple>

#include "axode/integration/references/profiles.hpp"
#include "axode/integration/references/sampled_trajectory.hpp"
#include "axode/integration/references/straight_path.hpp"
#include "python/bindings/states/prescribed_motion.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/trajectory.hpp"

/// Motions that drives follow. Profiles are documented in the Python module axode.drives.
namespace axode::python {

using namespace nb::literals;

namespace {

std::span<const double> all_of(const Numbers& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}

/// The times of a trajectory, which must be an array with one axis.
Numbers sample_times(ArrayLike t) {
  Numbers times("t", t);
  if (times.axes() != 1) times.wrong_shape("(K,)");
  return times;
}

/// The numbers of an argument that has a row of `width` numbers for each time; empty if the argument is None.
std::vector<double> rows_at(const Numbers& times, const char* name, nb::handle given, int width,
                            const char* meaning) {
  if (given.is_none()) return {};
  const Numbers rows(name, {given.ptr()});
  const Shape expected{times.size(), width};
  if (rows.axes() != 2 || !rows.ends_with(expected))
    rows.wrong_shape(expected.text() + ", " + meaning + " numbers for each time");
  return {rows.data(), rows.data() + rows.size()};
}

nb::object from_samples(const BoundModel& m, ArrayLike t, nb::handle q, nb::handle v, nb::handle a) {
  const Numbers times = sample_times(t);
  const std::vector<double> all_q = rows_at(times, "q", q, m->nq(), "nq"),
                            all_v = rows_at(times, "v", v, m->nv(), "nv"),
                            all_a = rows_at(times, "a", a, m->nv(), "nv");
  return bound_trajectory([&] {
    const nb::gil_scoped_release released;
    return trajectory_from_samples(*m, all_of(times), all_q, all_v, all_a);
  }());
}

nb::object from_functions(const BoundModel& m, ArrayLike t, nb::handle motions, nb::handle q) {
  const Numbers times = sample_times(t);
  std::vector<double> rest;
  if (!q.is_none()) {
    const States state = one_state(m, {q.ptr()});
    rest.assign(state.q(0).begin(), state.q(0).end());
  }
  return bound_trajectory(trajectory_from_functions(*m, all_of(times), motions_from(motions), rest));
}

/// Limits of velocities or their derivatives: one number for all, or one for each; empty if None is given.
std::vector<double> limits_of(const Model& m, const char* name, nb::handle given) {
  if (given.is_none()) return {};
  const Numbers limits(name, {given.ptr()}, Infinities::allowed);
  const Shape expected{m.nv()};
  if (limits.axes() > 1 || (limits.axes() == 1 && !limits.ends_with(expected)))
    limits.wrong_shape("() or " + expected.text() + ", nv numbers");
  return {limits.data(), limits.data() + limits.size()};
}

template <Trajectory (*profile)(const Model&, std::span<const double>, std::span<const double>,
                                const ProfileLimits&)>
nb::object profile_of(const BoundModel& m, ArrayLike start, ArrayLike goal, nb::handle acceleration,
                      nb::handle velocity) {
  const States from = one_state(m, start, "start"), to = one_state(m, goal, "goal");
  const std::vector<double> a = limits_of(m, "acceleration", acceleration),
                            v = limits_of(m, "velocity", velocity);
  return bound_trajectory(profile(*m, from.q(0), to.q(0), {.acceleration = a, .velocity = v}));
}

StraightPath path_between(const BoundModel& m, ArrayLike start, ArrayLike goal) {
  const States from = one_state(m, start, "start"), to = one_state(m, goal, "goal");
  return {*m, from.q(0), to.q(0)};
}

/// Makes the trajectory on which the joints move along a path in joint coordinates, on which every joint
/// follows its geodesic from start to goal. function(t) must return three lists with one number for each
/// joint that moves: how far the joint has gone along its path at time t (s), in rad or m, and the first two
/// time derivatives of this distance.
nb::object follow(const StraightPath& of, const std::vector<double>& jumps, double duration,
                  const nb::callable& function) {
  return bound_trajectory(of.follow(jumps, duration, [&](double t, int, std::span<MotionValue> distances) {
    const auto [s, ds, dds] =
        nb::cast<std::tuple<std::vector<double>, std::vector<double>, std::vector<double>>>(function(t));
    for (std::size_t j = 0; j < distances.size(); ++j) distances[j] = {s.at(j), ds.at(j), dds.at(j)};
  }));
}

}  // namespace

void add_references(nb::module_& module) {
  const nb::object trajectory = module.attr("Trajectory");
  nb::cpp_function_def(
      &from_samples, nb::scope(trajectory), nb::name("from_samples"), "m"_a, "t"_a, "q"_a, "v"_a = nb::none(),
      "a"_a = nb::none(),
      nb::sig("def from_samples(m: Model, t: numpy.typing.ArrayLike, q: numpy.typing.ArrayLike, "
              "v: numpy.typing.ArrayLike | None = None, a: numpy.typing.ArrayLike | None = None) -> "
              "Trajectory"),
      R"(
The motion through configurations q (K, nq) at times t (K,), s, which must increase, for drives that follow it.

If v (K, nv) is left out, a joint of one velocity follows the spline of degree 5 through its samples, as a motion of the
kind `samples` in a drawing does; its angle counts whole turns. The velocities and accelerations of a spherical, planar or free joint are those of a
polynomial through six neighbouring samples on the group; the joint turns by less than half a turn between two samples.
If a (K, nv) is left out, it is the derivative of splines through v. `at` interpolates: its v is the derivative of its q,
and errors are of order h^6 in q and h^5 in v. tau is 0.

ValueError for fewer than two times, times that do not increase, wrong shapes, a without v, numbers that are not finite,
and quaternions that are not of unit norm.

>>> t = np.linspace(0, 1, 21)
>>> wave = axode.Trajectory.from_samples(arm, t, np.outer(np.sin(t), np.ones(7)))
>>> q, v = wave.at(0.33)
>>> bool(np.allclose(q, np.sin(0.33))), bool(np.allclose(v, np.cos(0.33), atol=1e-6))
(True, True)
)");
  nb::cpp_function_def(
      &from_functions, nb::scope(trajectory), nb::name("from_functions"), "m"_a, "t"_a, "motions"_a,
      "q"_a = nb::none(),
      nb::sig("def from_functions(m: Model, t: numpy.typing.ArrayLike, motions: collections.abc.Mapping[str, "
              "collections.abc.Callable[[float], numpy.typing.ArrayLike]], q: numpy.typing.ArrayLike | None "
              "= None) -> Trajectory"),
      R"(
The motion in which joints of one velocity follow functions of time, with states at times t (K,), s, for drives.

motions: functions t -> (s, ds, dds) by the names of joints, in addition to the motions of the drawing; the derivatives
must be exact. All other joints rest at q (nq,); if it is left out, at the initial state of the mechanism. Between the
states q is interpolated with an error of order h^6. Loops are not closed. For a function of time that gives whole
configurations use `from_samples`.

ValueError as for `from_samples`, for rods, coupled joints and joints of several velocities, and for a second motion of a
joint.

>>> swing = {"A2": lambda t: (0.5 * np.sin(t), 0.5 * np.cos(t), -0.5 * np.sin(t))}
>>> motion = axode.Trajectory.from_functions(arm, np.linspace(0, 3, 31), swing)
>>> q, v = motion.at(1.03)
>>> bool(np.isclose(q[1], 0.5 * np.sin(1.03))), bool(q[0] == 0)
(True, True)
)");
  module.def("quintic_profile", &profile_of<quintic_profile>, "m"_a, "start"_a, "goal"_a, "acceleration"_a,
             "velocity"_a.none(),
             nb::sig("def quintic_profile(m: Model, start: numpy.typing.ArrayLike, goal: "
                     "numpy.typing.ArrayLike, acceleration: numpy.typing.ArrayLike, velocity: "
                     "numpy.typing.ArrayLike | None) -> Trajectory"),
             "See axode.drives.quintic_profile.");
  module.def("trapezoidal_profile", &profile_of<trapezoidal_profile>, "m"_a, "start"_a, "goal"_a,
             "acceleration"_a, "velocity"_a.none(),
             nb::sig("def trapezoidal_profile(m: Model, start: numpy.typing.ArrayLike, goal: "
                     "numpy.typing.ArrayLike, acceleration: numpy.typing.ArrayLike, velocity: "
                     "numpy.typing.ArrayLike | None) -> Trajectory"),
             "See axode.drives.trapezoidal_profile.");
  nb::class_<StraightPath>(module, "StraightPath", "The geodesics of the joints between two configurations.")
      .def_prop_ro(
          "lengths",
          [](const StraightPath& of) {
            std::vector<double> lengths;
            for (const StraightPath::Joint& joint : of.joints()) lengths.push_back(joint.length);
            return lengths;
          },
          "The lengths of the joints that move, rad or m.")
      .def(
          "limits",
          [](const StraightPath& of, const std::string& name, nb::handle given) {
            return of.limits(name.c_str(), limits_of(of.model(), name.c_str(), given));
          },
          "name"_a, "given"_a,
          nb::sig("def limits(self, name: str, given: numpy.typing.ArrayLike) -> list[float]"),
          "The largest derivative of each distance.")
      .def(
          "velocity_limits",
          [](const StraightPath& of, nb::handle given) {
            return of.velocity_limits(limits_of(of.model(), "velocity", given));
          },
          "given"_a.none(),
          nb::sig("def velocity_limits(self, given: numpy.typing.ArrayLike | None) -> list[float]"),
          "The largest rate of each distance.")
      .def("follow", &follow, "jumps"_a, "duration"_a, "function"_a,
           nb::sig("def follow(self, jumps: collections.abc.Sequence[float], duration: float, "
                   "function: collections.abc.Callable[[float], tuple[list[float], "
                   "list[float], list[float]]]) -> Trajectory"),
           "The Trajectory with the distances that function(t) returns, with their rates and accelerations.");
  module.def("straight_path", &path_between, "m"_a, "start"_a, "goal"_a,
             "The path for a profile of axode.drives.");
}

}  // namespace axode::python
