#include "axode/kinematics.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

/// An array with a matrix of six rows for each state, whose n columns are screws that f writes.
template <class... Arguments> Array columns_of(const Arguments&... arguments) {
  return map_states(arguments...).transposed();
}

std::tuple<nb::object, Array> jacobian_columns_of(const BoundModel& m, ArrayLike q, FrameName frame,
                                                  Representation representation, ArrayLike offset) {
  const Place<> at = place(m, frame, offset);
  const States states = one_state(m, q);
  return with_representation(representation, [&]<class Rep>(Rep) {
    std::vector<JacobianColumn<Rep>> found(static_cast<std::size_t>(m->n_screws()));
    states.each(linear_cost(m), [&](auto& workspace, std::size_t) {
      found.resize(jacobian_columns<Rep>(m, workspace, states.q(0), at, found));
    });
    nb::list velocities;
    std::vector<Twist<Rep>> J;
    for (const JacobianColumn<Rep>& column : found) {
      velocities.append(column.c);
      J.push_back(column.J);
    }
    return std::tuple(nb::object(velocities), columns(std::span<const Twist<Rep>>(J)));
  });
}

Array jacobians_of(const BoundModel& m, ArrayLike q, nb::handle frames, Representation representation,
                   int threads) {
  std::vector<Place<>> places;
  if (frames.is_none()) {
    for (int f = 0; f < m->n_frames(); ++f) places.emplace_back(f);
  } else {
    if (!PyList_Check(frames.ptr()) && !PyTuple_Check(frames.ptr()))
      throw nb::value_error("frames: expected a list of names or numbers of frames");
    for (const nb::handle frame : frames)
      places.emplace_back(
          FrameName{frame.ptr()}.in(m, ("frames[" + std::to_string(places.size()) + "]").c_str()));
  }
  const Shape shape{static_cast<nb::ssize_t>(places.size()), m->nv(), 6};
  const double cost = linear_cost(m) + 0.002 * static_cast<double>(shape.size());
  return with_representation(representation, [&]<class Rep>(Rep) {
    return columns_of(m, threads, cost, shape, q, [&](auto& workspace, auto qk, auto out) {
      jacobians<Rep>(m, workspace, qk, places, screws<Twist<Rep>>(out));
    });
  });
}

Array jacobian_partials_of(const BoundModel& m, ArrayLike q, FrameName frame, Representation representation,
                           int order, ArrayLike offset, int threads) {
  const Place<> at = place(m, frame, offset);
  constexpr int largest = Shape::most - 3;  // three axes are those of states, rows and columns
  if (order < 0 || order > largest)
    throw nb::value_error(("order is " + std::to_string(order) + "; expected 0 to " +
                           std::to_string(largest) + ", as an array has at most " +
                           std::to_string(Shape::most) + " axes")
                              .c_str());
  Shape shape{m->nv(), 6};
  double size = 6.0 * m->nv();
  for (int k = 0; k < order; ++k) {
    size *= m->nv();
    shape = shape.times(m->nv());
  }
  if (size > static_cast<double>(PY_SSIZE_T_MAX / 16))
    throw nb::value_error(("order is " + std::to_string(order) + "; nv^(order + 1) columns of nv = " +
                           std::to_string(m->nv()) + " are more than an array can have")
                              .c_str());
  const double cost = linear_cost(m) + 0.02 * static_cast<double>(shape.size());
  const States states(m, q, threads);
  NewArray J = states.result(shape);
  with_representation(representation, [&]<class Rep>(Rep) {
    states.each_long(cost, [&](std::size_t k, const auto& should_continue) {
      Workspace<> workspace(*m);
      jacobian_partials<Rep>(m, workspace, states.q(k), at, order, screws<Twist<Rep>>(item(J, k, shape)),
                             should_continue);
    });
  });
  return J.transposed();
}

Array jacobian_derivative_along_of(const BoundModel& m, ArrayLike q, FrameName frame, ArrayLike directions,
                                   Representation representation, ArrayLike offset, int threads) {
  const Place<> at = place(m, frame, offset);
  const States states(m, q, threads);
  const Rows rows(states, "directions", directions, "a row of nv numbers for each derivative");
  const Shape shape{m->nv(), 6};
  constexpr int short_order = 6;  // one state takes less than the 20 ms between two looks for Ctrl-C
  if (rows.count() > short_order) {
    NewArray J = states.result(shape);
    with_representation(representation, [&]<class Rep>(Rep) {
      states.each_long(
          linear_cost(m) * rows.count() * rows.count(), [&](std::size_t k, const auto& should_continue) {
            Workspace<> workspace(*m);
            jacobian_derivative_along<Rep>(m, workspace, states.q(k), at, rows.count(), rows[k],
                                           screws<Twist<Rep>>(item(J, k, shape)), should_continue);
          });
    });
    return J.transposed();
  }
  return with_representation(representation, [&]<class Rep>(Rep) {
    return each_item(states, linear_cost(m), shape,
                     [&](auto& workspace, std::size_t k, auto out) {
                       jacobian_derivative_along<Rep>(m, workspace, states.q(k), at, rows.count(), rows[k],
                                                      screws<Twist<Rep>>(out));
                     })
        .transposed();
  });
}

/// Evaluates the motion of the bodies, with its time derivatives up to an order, at every state. f(motion,
/// order, out) must write the result for one state to `out`.
template <class F>
NewArray each_motion(const States& states, const Rows& rates, const Shape& item_shape, const F& f) {
  const Model& m = states.model();
  if (rates.count() == 0) throw nb::value_error("rates is empty; expected at least one row, the velocities");
  const int orders = rates.count();
  return each_item(states, linear_cost(m) * orders * orders, item_shape.times(orders),
                   [&](auto&, std::size_t k, std::span<double> out) {
                     HigherOrderMotion<> motion(m, orders - 1);
                     motion.evaluate(states.q(k), rates[k]);
                     const std::size_t size = out.size() / static_cast<std::size_t>(orders);
                     for (int order = 0; order < orders; ++order)
                       f(motion, order, out.subspan(static_cast<std::size_t>(order) * size, size));
                   });
}

constexpr const char* rates_meaning = "rows of nv numbers: v, v', v'', ...";

Array twist_derivatives_of(const BoundModel& m, ArrayLike q, ArrayLike rates, FrameName frame,
                           Representation representation, ArrayLike offset, int threads) {
  const Place<> at = place(m, frame, offset);
  const States states(m, q, threads);
  return with_representation(representation, [&]<class Rep>(Rep) {
    return each_motion(states, Rows(states, "rates", rates, rates_meaning), {6},
                       [&](const HigherOrderMotion<>& motion, int order, std::span<double> out) {
                         screws<TwistRate<Rep>>(out)[0] = motion.twist_derivative<Rep>(at, order);
                       })
        .array();
  });
}

Array jacobian_derivatives_of(const BoundModel& m, ArrayLike q, ArrayLike rates, FrameName frame,
                              Representation representation, ArrayLike offset, int threads) {
  const Place<> at = place(m, frame, offset);
  const States states(m, q, threads);
  return with_representation(representation, [&]<class Rep>(Rep) {
    return each_motion(states, Rows(states, "rates", rates, rates_meaning), {m->nv(), 6},
                       [&](const HigherOrderMotion<>& motion, int order, std::span<double> out) {
                         motion.jacobian_derivative<Rep>(at, order, screws<TwistRate<Rep>>(out));
                       })
        .transposed();
  });
}

nb::object entry(const nb::dict& from, const char* key, nb::object otherwise) {
  return from.contains(key) ? nb::object(from[key]) : otherwise;
}

std::vector<PoseTarget> pose_targets(const Model& m, nb::handle targets) {
  if (!PyList_Check(targets.ptr()) && !PyTuple_Check(targets.ptr()))
    throw nb::value_error("targets: expected a list of dicts with the keys frame and pose");
  std::vector<PoseTarget> found;
  for (const nb::handle target : targets) {
    const std::string where = "targets[" + std::to_string(found.size()) + "]";
    const nb::dict from = entries_of(
        target, where,
        std::array<std::string_view, 5>{"frame", "pose", "offset", "angular_weight", "linear_weight"},
        {"frame", "pose"});
    const nb::object frame = from["frame"], pose = from["pose"];
    const Numbers C(where + ".pose", {pose.ptr()});
    if (C.axes() != 2 || !C.ends_with({4, 4})) C.wrong_shape("(4, 4)");
    found.push_back({place(m, {frame.ptr()}, {entry(from, "offset", nb::none()).ptr()}),
                     pose_from(where + ".pose", C.data()),
                     number(where + ".angular_weight", entry(from, "angular_weight", nb::float_(1.0))),
                     number(where + ".linear_weight", entry(from, "linear_weight", nb::float_(1.0)))});
  }
  return found;
}

nb::object inverse_kinematics_of(const BoundModel& m, nb::handle given, ArrayLike q0, double tolerance,
                                 int iterations, int restarts, std::uint64_t seed, bool keep_limits,
                                 nb::handle posture) {
  const std::vector<PoseTarget> targets = pose_targets(m, given);
  const States states = one_state(m, q0, "q0");
  InverseKinematicsOptions options{tolerance, iterations, restarts, seed, keep_limits};
  std::optional<Items> near;
  if (!posture.is_none()) {
    near.emplace(states.configurations("posture", {posture.ptr()}));
    options.posture = (*near)[0];
  }
  const auto found = states.unlocked(1000, [&](const batch::Monitor& monitor) {
    options.monitor = [&] { return monitor(0, 0); };
    return inverse_kinematics(m, targets, states.q(0), options);
  });
  return record("InverseKinematics", to_str(to_string(found.status)), to_array(found.q), found.residual,
                found.iterations, found.restarts);
}

}  // namespace

void add_kinematics(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"poses">(R"(
The pose C_i of every frame in the inertial frame (eqs. POEX, aVbRec2).

Shape (n_frames, 4, 4), or (N, n_frames, 4, 4) for q of shape (N, nq), in the order of `m.frame_names`; positions in
m. O(n).

>>> C = axode.poses(arm, arm.neutral())
>>> C[arm.frame_index("flange"), :3, 3]
array([0.   , 0.   , 1.306])
)");
  functions.define<"pose">(R"(
The pose C of a frame in the inertial frame: (4, 4), or (N, 4, 4) for q of shape (N, nq); positions in m. O(n).

`offset` is a point (3,) or pose (4, 4) in the frame.

>>> axode.pose(arm, arm.neutral(), "flange")[:3, 3]
array([0.   , 0.   , 1.306])
)");
  functions.define<"twists">(R"(
The twist V_i of every frame: angular (rad/s), then linear (m/s) (eqs. VbRec, Vsrec, VhRec).

Shape (n_frames, 6) or (N, n_frames, 6), in the order of `m.frame_names`.
body: axes of the frame, about its origin. spatial: inertial axes, about the inertial origin. hybrid: inertial axes,
about the frame's origin. mixed: angular part in the frame's axes, linear part in inertial axes. O(n).

>>> V = axode.twists(arm, arm.neutral(), np.ones(7), "hybrid")
>>> V.shape
(10, 6)
)");
  functions.define<"accelerations">(R"(
The time derivative V'_i of the components of the twist of every frame, rad/s^2 and m/s^2 (eqs. cVbRec2, dVsRec,
dVhRec2).

Shape (n_frames, 6) or (N, n_frames, 6), in the order of `m.frame_names`. Hybrid and mixed rates contain the classical
acceleration r'' of the frame's origin; body-fixed and spatial rates do not. Gravity is not included. O(n).

>>> dV = axode.accelerations(arm, arm.neutral(), np.zeros(7), np.ones(7), "hybrid")
>>> dV[arm.frame_index("flange")].round(3)
array([0.   , 1.   , 4.   , 0.546, 0.   , 0.   ])
)");
  functions.define<"jacobian">(R"(
The Jacobian J of a frame, V = J v, shape (6, nv) or (N, 6, nv), angular rows first (eqs. JbX, JsX, Jh, JhJb).

`offset` is a point (3,) or a pose (4, 4) given in the frame, m; J is then the Jacobian of the offset frame. O(n).

>>> J = axode.jacobian(arm, arm.neutral(), "flange", "hybrid")
>>> J[:, 0]
array([0., 0., 1., 0., 0., 0.])
)");
  module.def("jacobians", &jacobians_of, "m"_a, "q"_a, "frames"_a = nb::none(), "representation"_a = "body",
             nb::kw_only(), "threads"_a = 1,
             nb::sig("def jacobians(m: Model, q: numpy.typing.ArrayLike, frames: "
                     "collections.abc.Sequence[str | int] | None = None, representation: "
                     "typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', *, threads: int = 1) -> "
                     "numpy.typing.NDArray[numpy.float64]"),
             R"(
The Jacobians of many frames in one call: shape (K, 6, nv), or (N, K, 6, nv) for q of shape (N, nq).

`frames` is a list of their names or numbers; if it is left out, it is all frames in the order of `m.frame_names`.
Poses and joint screws are computed once; hence this takes much less time than calling `jacobian` for each frame.
O(n), and O(path length) for each frame.

>>> J = axode.jacobians(arm, arm.neutral(), ["link 2", "flange"], "hybrid")
>>> J.shape
(2, 6, 7)
>>> np.allclose(J[1], axode.jacobian(arm, arm.neutral(), "flange", "hybrid"))
True
)");
  functions.define<"jacobian_rate">(R"(
The time derivative J' of the Jacobian of a frame: V' = J a + J' v. Shape (6, nv) or (N, 6, nv).

`offset` is that of `jacobian`. O(n).

>>> dJ = axode.jacobian_rate(arm, arm.neutral(), np.zeros(7), "flange")
>>> float(abs(dJ).max())
0.0
)");
  module.def("jacobian_partials", &jacobian_partials_of, "m"_a, "q"_a, "frame"_a, "representation"_a = "body",
             "order"_a = 1, nb::kw_only(), "offset"_a = nb::none(), "threads"_a = 1, R"(
The partial derivatives of the Jacobian of a frame, of any order, in closed form (eqs. der1, nthorder, Jhder).

Shape (nv, ..., nv, 6, nv), one axis for each derivative, the outermost first: entry [k, :, j] of the first order is the
derivative of column j along direction e_k, d/de J(q (+) e e_k). For N states, there is another axis in front; an array has
at most 32 axes.

>>> dJ = axode.jacobian_partials(arm, arm.neutral(), "flange", "spatial")
>>> dJ.shape
(7, 6, 7)
)");
  module.def("jacobian_derivative_along", &jacobian_derivative_along_of, "m"_a, "q"_a, "frame"_a,
             "directions"_a, "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(),
             "threads"_a = 1, R"(
The partial derivatives contracted with one direction for each order, D_uk ... D_u1 J: shape (6, nv) or (N, 6, nv).

`directions` has shape (k, nv), u1 (taken first) in row 0, or (N, k, nv), for any k. The tensor of `jacobian_partials` is
never built; the cost grows with 3^k, or with the square of the length of each run of equal consecutive directions: two
runs of 500 take minutes. Ctrl-C ends the call.

>>> axode.jacobian_derivative_along(arm, arm.neutral(), "flange", [np.ones(7), np.ones(7)]).shape
(6, 7)
)");
  functions.define<"relative_jacobian">(R"(
The Jacobian of the motion of a frame as an observer at rest in the frame `base` sees it, (6, nv) or (N, 6, nv).

The base takes the role of the inertial frame. `offset` and `base_offset` are points or poses in the two frames, as in
`jacobian`.

>>> J = axode.relative_jacobian(arm, arm.neutral(), "flange", "link 6")
>>> np.flatnonzero(abs(J).max(axis=0))
array([6])
)");
  module.def("jacobian_columns", &jacobian_columns_of, "m"_a, "q"_a, "frame"_a, "representation"_a = "body",
             nb::kw_only(), "offset"_a = nb::none(),
             nb::sig("def jacobian_columns(m: Model, q: numpy.typing.ArrayLike, frame: str | int, "
                     "representation: typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', *, "
                     "offset: numpy.typing.ArrayLike | None = None) -> tuple[list[int], "
                     "numpy.typing.NDArray[numpy.float64]]"),
             R"(
(velocities, columns): those columns of a Jacobian that belong to joints on the path from the frame to the ground, (6,
k), with the indices of their velocities.

If joints are coupled, several columns may have the same velocity; they add up. The function takes one state only.
O(path length).

>>> axode.jacobian_columns(arm, arm.neutral(), "link 2")[0]
[1, 0]
)");
  functions.define<"joint_screws">(R"(
The instantaneous screws J_i^s of all joints, in inertial axes about the inertial origin (eqs. JsX, bVsRec).

Shape (6, n) or (N, 6, n) with a column for each degree of freedom, in the model's order, coupled joints included. O(n).

>>> axode.joint_screws(arm, arm.neutral())[:, 0]
array([0., 0., 1., 0., 0., 0.])
)");
  functions.define<"center_of_mass">(R"(
The center of mass of all moving bodies in the inertial frame, shape (3,) or (N, 3), m. O(n).

ValueError for a massless model.

>>> axode.center_of_mass(arm, arm.neutral()).shape
(3,)
)");
  functions.define<"center_of_mass_jacobian">(R"(
The Jacobian J of the center of mass, r_com' = J v, in inertial axes, shape (3, nv) or (N, 3, nv), m. O(n).

>>> axode.center_of_mass_jacobian(arm, arm.neutral()).shape
(3, 7)
)");
  functions.define<"centroidal_momentum_matrix">(R"(
The centroidal momentum matrix A: A v is the momentum about the center of mass, in inertial axes, angular rows first:
(6, nv) or (N, 6, nv). O(n).

>>> A = axode.centroidal_momentum_matrix(arm, arm.neutral())
>>> np.allclose(A @ np.ones(7), axode.centroidal_momentum(arm, arm.neutral(), np.ones(7)))
True
)");
  functions.define<"centroidal_momentum_matrix_rate">(R"(
The time derivative of the centroidal momentum matrix, (6, nv) or (N, 6, nv). O(n).

>>> axode.centroidal_momentum_matrix_rate(arm, arm.neutral(), np.ones(7)).shape
(6, 7)
)");
  module.def("twist_derivatives", &twist_derivatives_of, "m"_a, "q"_a, "rates"_a, "frame"_a,
             "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(), "threads"_a = 1, R"(
The twist of a frame and its time derivatives: row k is the k-th derivative of the components, shape (K, 6).

`rates` has K rows of nv numbers, v, v', v'', ..., or (N, K, nv) for N states, whose result is (N, K, 6). Classical jerk
and snap of the frame's origin are the linear parts of rows 2 and 3 in hybrid representation. O(n K^2).

>>> rates = np.zeros((3, 7))
>>> rates[2, 1] = 1.0
>>> axode.twist_derivatives(arm, arm.neutral(), rates, "flange", "hybrid")[2].round(3)
array([0.   , 1.   , 0.   , 0.946, 0.   , 0.   ])
)");
  module.def("jacobian_derivatives", &jacobian_derivatives_of, "m"_a, "q"_a, "rates"_a, "frame"_a,
             "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(), "threads"_a = 1, R"(
The Jacobian of a frame and its time derivatives up to an order, shape (K, 6, nv) or (N, K, 6, nv).

`rates` are those of `twist_derivatives`; entry k of the result needs rows 0 to k - 1. O(n K^2).

>>> axode.jacobian_derivatives(arm, arm.neutral(), np.ones((4, 7)), "flange").shape
(4, 6, 7)
)");
  module.def(
      "inverse_kinematics", &inverse_kinematics_of, "m"_a, "targets"_a, "q0"_a, nb::kw_only(),
      "tolerance"_a = 1e-9, "iterations"_a = 60, "restarts"_a = 40, "seed"_a = 1, "limits"_a = true,
      "posture"_a = nb::none(),
      nb::sig(
          "def inverse_kinematics(m: Model, targets: collections.abc.Sequence[axode.Target], "
          "q0: numpy.typing.ArrayLike, *, tolerance: float = 1e-9, iterations: int = 60, restarts: int = 40, "
          "seed: int = 1, limits: bool = True, posture: numpy.typing.ArrayLike | None = None) -> "
          "axode.InverseKinematics"),
      R"(
A configuration in which frames have given poses, by damped least squares on SE(3), starting from q0 and then from
random configurations.

`targets` is a list of `axode.Target`. The error of a target is log(C^-1 C_target), rad and m, scaled by its weights;
a weight of 0 leaves a part free. `limits` keeps joints within their limits; `posture` is a configuration near which
the joints stay as far as the targets leave them free. The result has a status, "solved", "stalled" or
"iteration_limit", and q.

>>> goal = axode.poses(arm, np.full(7, 0.3))[arm.frame_index("flange")]
>>> found = axode.inverse_kinematics(arm, [{"frame": "flange", "pose": goal}], arm.neutral())
>>> found.status
'solved'
)");
}

}  // namespace axode::python
