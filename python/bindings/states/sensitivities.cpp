#include "axode/integration/sensitivities.hpp"

#include <nanobind/stl/tuple.h>

#include <optional>

#include "axode/batch/check_states.hpp"
#include "axode/drives.hpp"
#include "axode/integration/driven/drive_sensitivities.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/named_tuple.hpp"

/// Derivatives of the motions that axode.rollout computes.
namespace axode::python {

using namespace nb::literals;

namespace {

/// Common arguments of several motions: initial states, drive forces, and the length of a step.
struct Motions {
  const BoundModel& m;
  States states;
  Items v;
  Rows tau;
  double step;

  Motions(const BoundModel& model, ArrayLike q, ArrayLike of_v, ArrayLike of_tau, double length, int threads)
      : m(model),
        states(model, q, threads),
        v(states.velocities("v", of_v)),
        tau(states, "tau", of_tau, "nv numbers for each step"),
        step(length) {
    check_step(step);
    batch::check_states(*m, states.q(), threads);
  }
  nb::ssize_t K() const { return tau.count(); }
  nb::ssize_t nv() const { return m->nv(); }
  /// An argument with `count` rows of nv numbers for each motion, one row for each state or for each step.
  Items rows(const char* name, ArrayLike given, nb::ssize_t count) const {
    return states.items(name, given, {count, nv()}, "nv numbers in each row");
  }

  /// Calls f(n, should_continue) for every motion n. f must call should_continue() now and then, which
  /// notices Ctrl-C, and must end if it returns false. If motions could not continue, throws an error at the
  /// end. The error contains `result`, the array with the results of all motions.
  template <class F> void each(double microseconds, NewArray& result, const F& f) const {
    std::vector<Solvability> found(states.count());
    states.each_long(
        microseconds * static_cast<double>(K()),
        [&](std::size_t n, const Monitor& should_continue) { found[n] = f(n, should_continue); });
    states.refuse(found, result);
  }
};

nb::object rollout_derivatives_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, double step,
                                  int threads) {
  const Motions motions(m, q, v, tau, step, threads);
  const nb::ssize_t K = motions.K(), nv = m->nv();
  const Shape shape_A{K, 2 * nv, 2 * nv}, shape_B{K, 2 * nv, nv};
  NewArray A = motions.states.result(shape_A), B = motions.states.result(shape_B);
  motions.each(12 * quadratic_cost(*m), A, [&](std::size_t n, const Monitor& should_continue) {
    Workspace<> workspace(*m);
    const std::span<const double> from = motions.states.q(n);
    std::vector<double> q_k(from.begin(), from.end()), v_k(motions.v[n].begin(), motions.v[n].end());
    std::vector<double> q_1(q_k), v_1(v_k);
    const std::span<double> A_n = item(A, n, shape_A), B_n = item(B, n, shape_B);
    std::ranges::fill(A_n, std::numeric_limits<double>::quiet_NaN());
    std::ranges::fill(B_n, std::numeric_limits<double>::quiet_NaN());
    const std::size_t width = v_k.size();
    Solvability found;
    for (std::size_t k = 0; k < static_cast<std::size_t>(K) && found.ok() && should_continue(); ++k) {
      found = step_derivatives(*m, workspace, q_k, v_k, motions.tau[n].subspan(k * width, width), step,
                               {q_1, v_1, A_n.subspan(k * 4 * width * width, 4 * width * width),
                                B_n.subspan(k * 2 * width * width, 2 * width * width)});
      q_k.swap(q_1);
      v_k.swap(v_1);
    }
    return found;
  });
  return record("RolloutDerivatives", A.array(), B.array());
}

nb::object rollout_derivatives_with_drives_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                              double step, nb::handle x, double t, int threads) {
  const Motions motions(m, q, v, tau, step, threads);
  const States& states = motions.states;
  const DriveSystem drives(*m);
  const auto nx = static_cast<nb::ssize_t>(drives.nx()),
             nu = static_cast<nb::ssize_t>(drives.inputs().size());
  std::optional<Items> given;
  if (!x.is_none()) given = states.items("x", {x.ptr()}, {nx}, "a number for each state of the drives");
  const nb::ssize_t K = motions.K(), nv = m->nv(), z = 2 * nv + nx;
  const Shape shape_q{K + 1, m->nq()}, shape_v{K + 1, nv}, shape_x{K + 1, nx}, shape_A{K, z, z},
      shape_B{K, z, nv}, shape_C{K, z, nu};
  NewArray q_out = states.result(shape_q), v_out = states.result(shape_v), x_out = states.result(shape_x);
  NewArray A = states.result(shape_A), B = states.result(shape_B), C = states.result(shape_C);
  motions.each(20 * quadratic_cost(*m), A, [&](std::size_t n, const Monitor& should_continue) {
    return rollout_derivatives_with_drives(
        *m, drives, t, states.q(n), motions.v[n], given ? (*given)[n] : std::span<const double>(),
        motions.tau[n], step,
        {item(q_out, n, shape_q), item(v_out, n, shape_v), item(x_out, n, shape_x), item(A, n, shape_A),
         item(B, n, shape_B), item(C, n, shape_C)},
        {}, runge_kutta(4), should_continue);
  });
  nb::list names, inputs;
  for (const DriveState& state : drives.states()) names.append(to_str(state.name));
  for (const std::size_t drive : drives.inputs()) inputs.append(to_str(drives.name(drive)));
  return record("DriveRolloutDerivatives", q_out.array(), v_out.array(), x_out.array(), A.array(), B.array(),
                C.array(), names, inputs);
}

std::tuple<Array, Array> rollout_jvp_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                        double step, ArrayLike dq, ArrayLike dv, ArrayLike dtau,
                                        int threads) {
  const Motions motions(m, q, v, tau, step, threads);
  const Items of_q = motions.states.velocities("dq", dq), of_v = motions.states.velocities("dv", dv),
              of_tau = motions.rows("dtau", dtau, motions.K());
  const Shape shape{motions.K() + 1, m->nv()};
  NewArray q_out = motions.states.result(shape), v_out = motions.states.result(shape);
  motions.each(15 * linear_cost(*m), v_out, [&](std::size_t n, const Monitor& should_continue) {
    return rollout_jvp(*m, motions.states.q(n), motions.v[n], motions.tau[n], step, of_q[n], of_v[n],
                       of_tau[n], item(q_out, n, shape), item(v_out, n, shape), {}, runge_kutta(4),
                       should_continue);
  });
  return {q_out.array(), v_out.array()};
}

nb::object rollout_vjp_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, double step,
                          ArrayLike w_q, ArrayLike w_v, int threads) {
  const Motions motions(m, q, v, tau, step, threads);
  const Items of_q = motions.rows("w_q", w_q, motions.K() + 1),
              of_v = motions.rows("w_v", w_v, motions.K() + 1);
  const Shape one{m->nv()}, steps{motions.K(), m->nv()}, bodies{m->n_bodies(), 6};
  NewArray by_q = motions.states.result(one), by_v = motions.states.result(one);
  NewArray by_tau = motions.states.result(steps), geometry = motions.states.result(bodies);
  motions.each(20 * linear_cost(*m), by_q, [&](std::size_t n, const Monitor& should_continue) {
    return rollout_vjp(
        *m, motions.states.q(n), motions.v[n], motions.tau[n], step, of_q[n], of_v[n],
        {item(by_q, n, one), item(by_v, n, one), item(by_tau, n, steps), item(geometry, n, bodies)}, {},
        runge_kutta(4), should_continue);
  });
  return record("RolloutGradient", by_q.array(), by_v.array(), by_tau.array(), geometry.array());
}

}  // namespace

void add_sensitivities(nb::module_& module) {
  module.def(
      "rollout_derivatives", &rollout_derivatives_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, nb::kw_only(),
      "threads"_a = 1,
      nb::sig("def rollout_derivatives(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "tau: numpy.typing.ArrayLike, step: float, *, threads: int = 1) "
              "-> axode.RolloutDerivatives"),
      R"(
(A, B) of every step of `rollout`: x_{k+1} = A_k x_k + B_k dtau_k for small deviations x = (dq, dv).

A has shape (K, 2 nv, 2 nv), B (K, 2 nv, nv), with another axis N in front for N motions. They are the exact
derivatives of the numerical steps; deviations of q are left-trivialised, q (+) dq as in `Model.integrate`. To compute
one step from each of N states, let K be 1. A step takes O(n^2) and products of matrices. SingularError or
NotFiniteError, with A, if a motion cannot continue; its later entries are NaN.

>>> A, B = axode.rollout_derivatives(arm, np.zeros(7), np.zeros(7), np.ones((20, 7)), 1e-3)
>>> A.shape, B.shape
((20, 14, 14), (20, 14, 7))
)");
  module.def("rollout_derivatives_with_drives", &rollout_derivatives_with_drives_of, "m"_a, "q"_a, "v"_a,
             "tau"_a, "step"_a, "x"_a = nb::none(), "t"_a = 0.0, nb::kw_only(), "threads"_a = 1,
             nb::sig("def rollout_derivatives_with_drives(m: Model, q: numpy.typing.ArrayLike, "
                     "v: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, step: float, "
                     "x: numpy.typing.ArrayLike | None = None, t: float = 0.0, *, threads: int = 1) "
                     "-> axode.records.DriveRolloutDerivatives"),
             R"(
The motion of `rollout` with drives, and how every step depends on its start: z_{k+1} = A_k z_k + B_k dtau_k + C_k du_k, see `DriveRolloutDerivatives`.

z = (dq, dv, dx) are small deviations, those of q left-trivialised, q (+) dq as in `Model.integrate`; du changes the inputs that
are functions of time. q is (nq,) or (N, nq), tau (K, nv) or (N, K, nv), and x (nx,) or (N, nx) the states of the drives at the
time t (s) at which the motion starts; if x is left out, the drives choose it. These are the exact derivatives of the numerical
steps. Where a drive reaches a limit or changes to another branch of its law, they are those of the branches that are taken, and
count that the time at which this happens depends on the state (eq. (D17.20)). ValueError for loops, prescribed motions and
couplings with play. SingularError or NotFiniteError, with A, if a motion cannot continue; its results
are NaN.

>>> wheel = axode.Builder("wheel", gravity=[0, 0, 0]).body(
...     "wheel", joint={"name": "axle", "kind": "revolute", "axis": "z", "point": [0, 0, 0]}, mass=1, com=[0, 0, 0],
...     inertia=[0.01, 0.01, 0.02]).drive("dc_motor", "axle", name="motor", resistance=1, inductance=0.01,
...                                       torque_constant=0.1, current_limit=5, input=12).build()
>>> steps = axode.rollout_derivatives_with_drives(wheel, [0], [0], np.zeros((20, 1)), 1e-3)
>>> steps.A.shape, steps.C.shape, steps.states, steps.inputs
((20, 3, 3), (20, 3, 1), ['motor.current'], ['motor'])
>>> steps.x[[1, 19], 0].round(6), steps.C[[1, 19], 2, 0].round(6) + 0  # the input counts until the limit is reached
(array([1.14194, 5.     ]), array([0.095162, 0.      ]))
)");
  module.def("rollout_jvp", &rollout_jvp_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "dq"_a, "dv"_a, "dtau"_a,
             nb::kw_only(), "threads"_a = 1, R"(
(dq, dv): the deviations of all states of `rollout` if its initial state deviates by dq and dv, and its drive forces
by dtau.

dq and dv have shape (nv,) or (N, nv), dtau that of tau, the results (K + 1, nv) or (N, K + 1, nv). Deviations are
those of `rollout_derivatives`, computed without its matrices. O(n) for each step. SingularError or NotFiniteError if
a motion cannot continue; its results are NaN.

>>> q, v, tau, w = np.zeros(7), np.zeros(7), np.ones((20, 7)), np.arange(7.0)
>>> dq, dv = axode.rollout_jvp(arm, q, v, tau, 1e-3, w, w, np.zeros((20, 7)))
>>> A, B = axode.rollout_derivatives(arm, q, v, tau, 1e-3)
>>> np.allclose(np.append(dq[1], dv[1]), A[0] @ np.append(w, w))
True
)");
  module.def("rollout_vjp", &rollout_vjp_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "w_q"_a, "w_v"_a,
             nb::kw_only(), "threads"_a = 1,
             nb::sig("def rollout_vjp(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
                     "tau: numpy.typing.ArrayLike, step: float, w_q: numpy.typing.ArrayLike, "
                     "w_v: numpy.typing.ArrayLike, *, threads: int = 1) -> axode.RolloutGradient"),
             R"(
(q, v, tau, geometry): the gradients of a weighted sum over all states of `rollout`, the sum of w_q . dq + w_v . dv.

w_q and w_v have shape (K + 1, nv) or (N, K + 1, nv); deviations are those of `rollout_derivatives`. The gradients by
the initial q and v are (nv,), that by tau is (K, nv), and that by the geometric parameters of
`forward_dynamics_geometry_vjp` is (n_bodies, 6), each with another axis N in front for N motions. O(n) for each step,
without matrices; only the states are stored. SingularError or NotFiniteError, with the gradient by q, if a motion
cannot continue; its results are NaN.

>>> q, v, tau, step = np.zeros(7), np.zeros(7), np.ones((20, 7)), 1e-3
>>> last = np.zeros((21, 7))
>>> last[-1, 2] = 1  # the angle of the third joint at the end
>>> gradient = axode.rollout_vjp(arm, q, v, tau, step, last, np.zeros((21, 7)))
>>> dq, dv = axode.rollout_jvp(arm, q, v, tau, step, np.ones(7), np.ones(7), tau)
>>> np.allclose(np.sum(gradient.q + gradient.v) + np.sum(gradient.tau), dq[-1, 2])
True
)");
}

}  // namespace axode::python
