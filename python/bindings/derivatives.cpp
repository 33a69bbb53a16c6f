#include "axode/derivatives.hpp"
#include "axode/constraints/equilibrium.hpp"
#include "axode/table/check_counts.hpp"
#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"

/// Derivatives of dynamics. The types of results that have several parts are in axode.records.
namespace axode::python {

using namespace nb::literals;

namespace {

nb::object motion_vjp_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a, FrameName frame,
                         ArrayLike w, Representation representation, ArrayLike offset, int threads) {
  const States states(m, q, threads);
  const Items of_v = states.velocities("v", v), of_a = states.velocities("a", a),
              weights = states.items("w", w, {3, 6}, "weights of X, V and dV");
  const Place<> at = place(m, frame, offset);
  const Shape shape{3, m->nv()};
  const NewArray out = with_representation(representation, [&]<class Rep>(Rep) {
    return each_item(states, linear_cost(*m), shape,
                     [&](Workspace<>& workspace, std::size_t k, std::span<double> gradient) {
                       const auto w_X = screws<Wrench<BodyFixed>>(weights[k].first(6));
                       const auto w_V = screws<Wrench<Rep>>(weights[k].last(12));
                       const std::size_t nv = gradient.size() / 3;
                       motion_vjp<Rep, double>(
                           *m, workspace, states.q(k), of_v[k], of_a[k], at, {w_X[0], w_V[0], w_V[1]},
                           {gradient.first(nv), gradient.subspan(nv, nv), gradient.last(nv)});
                     });
  });
  return record("InverseDynamicsDerivatives", out.part(0, 1), out.part(1, 1), out.part(2, 1));
}

nb::object linearize_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, LoadList loads,
                        bool joint_losses, int threads) {
  catalog::check_counts<"linearize">(*m);
  const States states(m, q, threads);
  const Items of_v = states.velocities("v", v), of_tau = states.velocities("tau", tau);
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape square{2 * m->nv(), 2 * m->nv()}, tall{2 * m->nv(), m->nv()};
  NewArray A = states.result(square), B = states.result(tall);
  std::vector<Solvability> found(states.count());
  states.each(quadratic_cost(*m), [&](Workspace<>& workspace, std::size_t k) {
    found[k] = applied.with(k, [&](const Loads<double>& now) {
      return linearize(*m, workspace, states.q(k), of_v[k], of_tau[k], {item(A, k, square), item(B, k, tall)},
                       now);
    });
  });
  states.refuse(found, A);
  states.refuse(found, B);
  return record("Linearization", A.array(), B.array());
}

nb::object equilibrium_of(const BoundModel& m, ArrayLike q0, nb::handle tau, LoadList loads, double tolerance,
                          int iterations) {
  const States states = one_state(m, q0, "q0");
  std::optional<Items> drives;
  if (!tau.is_none()) drives.emplace(states.velocities("tau", {tau.ptr()}));
  const AppliedLoads applied(states, loads, false);
  const EquilibriumResult found = states.released(1000, [&] {
    return applied.with(0, [&](const Loads<double>& now) {
      return equilibrium(*m, states.q(0), drives ? (*drives)[0] : std::span<const double>(), now,
                         {tolerance, iterations});
    });
  });
  return record("Equilibrium", to_str(to_string(found.status)), to_array(found.q), found.residual,
                found.iterations);
}

}  // namespace

void add_derivatives(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"inverse_dynamics_derivatives">(R"(
(q, v, a): the partial derivatives of `inverse_dynamics`, matrices (nv, nv) or (N, nv, nv), [component, direction].

Directions of q are those of q (+) eps e_k, see `Model.integrate`; the derivative by a is the mass matrix. The components of
loads are constant in the representation in which they are given. joint_losses adds damping; Coulomb friction adds
nothing, and has no derivative at v = 0. O(n d) on paths of d velocities.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> step = 1e-5 * np.ones(7)
>>> difference = axode.inverse_dynamics(arm, q + step, v, a) - axode.inverse_dynamics(arm, q - step, v, a)
>>> np.allclose(2 * axode.inverse_dynamics_derivatives(arm, q, v, a).q @ step, difference, atol=1e-12)
True
)");
  functions.define<"inverse_dynamics_jvp">(R"(
The derivative of `inverse_dynamics` along a direction (dq, dv, da): (nv,) or (N, nv). O(n), without a matrix.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.inverse_dynamics_derivatives(arm, q, v, a)
>>> np.allclose(axode.inverse_dynamics_jvp(arm, q, v, a, w, w, w), d.q @ w + d.v @ w + d.a @ w)
True
)");
  functions.define<"inverse_dynamics_vjp">(R"(
(q, v, a): the gradient of w . tau of `inverse_dynamics`, (nv,) or (N, nv) each. O(n), without a matrix.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> np.allclose(axode.inverse_dynamics_vjp(arm, q, v, a, w).q, w @ axode.inverse_dynamics_derivatives(arm, q, v, a).q)
True
)");
  functions.define<"inverse_dynamics_hessian">(R"(
(qq, qv, vv, aq): second partial derivatives of w . tau of `inverse_dynamics`, (nv, nv) or (N, nv, nv) each.

Entry [k, l] is the derivative along k of the derivative along l. For a joint with several velocities the displacement
k of q comes first, q (+) e_k (+) e_l; elsewhere qq is symmetric. O(n d).

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> h = axode.inverse_dynamics_hessian(arm, q, v, a, w)
>>> np.allclose(h.qq, h.qq.T)
True
)");
  functions.define<"forward_dynamics_derivatives">(R"(
(q, v, tau): the partial derivatives of `forward_dynamics`, matrices (nv, nv) or (N, nv, nv), [component, direction].

The terms are those of `inverse_dynamics_derivatives`; the derivative by tau is the inverse mass matrix. O(n) for each
column. SingularError if M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(d.tau @ axode.mass_matrix(arm, q), np.eye(7))
True
)");
  functions.define<"forward_dynamics_jvp">(R"(
The derivative of `forward_dynamics` along a direction (dq, dv, dtau): (nv,) or (N, nv). O(n), without a matrix.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(axode.forward_dynamics_jvp(arm, q, v, tau, w, w, w), d.q @ w + d.v @ w + d.tau @ w)
True
)");
  functions.define<"forward_dynamics_vjp">(R"(
(q, v, tau): the gradient of w . a of `forward_dynamics`, (nv,) or (N, nv) each. O(n), without a matrix.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(axode.forward_dynamics_vjp(arm, q, v, tau, w).v, w @ d.v)
True
)");
  functions.define<"forward_dynamics_hessian">(R"(
(qq, qv, vv, tauq): second partial derivatives of w . a of `forward_dynamics`, (nv, nv) or (N, nv, nv) each.

The entries are ordered as in `inverse_dynamics_hessian`. O(n^2 d). SingularError if M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> h = axode.forward_dynamics_hessian(arm, q, v, tau, w)
>>> np.allclose(h.vv, h.vv.T)
True
)");
  functions.define<"inverse_dynamics_second_derivatives">(R"(
(qq, qv, vv, aq): second partial derivatives of `inverse_dynamics` without loads, (nv, nv, nv) or (N, nv, nv, nv) each.

Entry [i, k, l] is the derivative along k of the derivative of tau[i] along l. `inverse_dynamics_hessian` is faster if
only a weighted sum of the components is needed. O(n d^2), and the time to write the zeros.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> second = axode.inverse_dynamics_second_derivatives(arm, q, v, a)
>>> np.allclose(np.tensordot(w, second.qq, 1), axode.inverse_dynamics_hessian(arm, q, v, a, w).qq)
True
)");
  functions.define<"forward_dynamics_second_derivatives">(R"(
(qq, qv, vv, tauq): second partial derivatives of `forward_dynamics` without loads, (nv, nv, nv) or (N, nv, nv, nv) each.

The entries are ordered as in `inverse_dynamics_second_derivatives`. O(n^3 d). SingularError if M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> second = axode.forward_dynamics_second_derivatives(arm, q, v, tau)
>>> np.allclose(np.tensordot(w, second.vv, 1), axode.forward_dynamics_hessian(arm, q, v, tau, w).vv)
True
)");
  functions.define<"momentum_form_derivatives">(R"(
(v_q, v_p, dp_q, dp_p): the partial derivatives of `momentum_form`, matrices (nv, nv) or (N, nv, nv), [component, direction].

The derivatives by tau are 0 and 1. v_p is the inverse mass matrix; if every joint has one velocity, and without
joint_losses, dp_p is -v_q^T. The terms are those of `inverse_dynamics_derivatives`. O(n) for each column.
SingularError if M is singular.

>>> q, p = np.full(7, 0.3), np.ones(7)
>>> d = axode.momentum_form_derivatives(arm, q, p)
>>> np.allclose(d.dp_p, -d.v_q.T), np.allclose(d.dp_q, d.dp_q.T)
(True, True)
)");
  functions.define<"gravity_derivatives">(R"(
The partial derivatives of `gravity_torques`, (nv, nv) or (N, nv, nv), [component, direction]. O(n d).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> step = 1e-5 * v
>>> difference = axode.gravity_torques(arm, q + step) - axode.gravity_torques(arm, q - step)
>>> np.allclose(2 * axode.gravity_derivatives(arm, q) @ step, difference, atol=1e-12)
True
)");
  functions.define<"coriolis_derivatives">(R"(
(q, v): the partial derivatives of `coriolis_vector`, matrices (nv, nv) or (N, nv, nv), [component, direction]. O(n d).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> d = axode.coriolis_derivatives(arm, q, v)
>>> np.allclose(d.v @ v, 2 * axode.coriolis_vector(arm, q, v))
True
)");
  functions.define<"generalized_load_derivatives">(R"(
(q, v): the partial derivatives of `generalized_loads`, matrices (nv, nv) or (N, nv, nv), [component, direction]. O(n d).

The derivative by v is that of damping only. The derivative of the forces by a component of a load is J^T, see
`jacobian`; that of the accelerations is M^-1 J^T, see `impulse_response`.

>>> weight = axode.Load(frame="flange", representation="hybrid", wrench=[0, 0, 0, 0, 0, -50])
>>> axode.generalized_load_derivatives(arm, np.zeros(7), np.zeros(7), [weight]).q[1, 1].round(3)
np.float64(47.3)
)");
  functions.define<"spring_force_derivatives">(R"(
(q, v): the partial derivatives of `spring_forces`, matrices (nv, nv) or (N, nv, nv), [component, direction].

>>> drawing = arm.to_dict()
>>> drawing["body"][1]["joint"]["spring"] = {"stiffness": 100.0}
>>> d = axode.spring_force_derivatives(axode.Model.from_dict(drawing), np.zeros(7), np.zeros(7))
>>> float(d.q[0, 0])
-100.0
)");
  functions.define<"kinetic_energy_gradient">(R"(
(q, v): the gradient of `kinetic_energy`, (nv,) or (N, nv) each; by v these are the momenta. O(n).

>>> q, v = np.full(7, 0.3), np.ones(7)
>>> np.allclose(axode.kinetic_energy_gradient(arm, q, v).v, axode.momenta(arm, q, v))
True
)");
  functions.define<"inverse_dynamics_geometry_derivatives">(R"(
The partial derivatives of `inverse_dynamics` by geometric parameters: (nv, n_bodies, 6) or (N, nv, n_bodies, 6).

Entry [:, i, u] belongs to the u-th unit screw (angular x y z, linear x y z) in the frame that body i of
`m.body_names` has while its joint is at zero: everything that the joint moves is displaced along this screw before
the joint moves. Inertias, the screw of the joint and the components of loads do not change. O(n d).

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.inverse_dynamics_geometry_derivatives(arm, q, v, a)
>>> d.shape
(7, 7, 6)
)");
  functions.define<"forward_dynamics_geometry_derivatives">(R"(
The partial derivatives of `forward_dynamics` by geometric parameters: (nv, n_bodies, 6) or (N, nv, n_bodies, 6).

The parameters are those of `inverse_dynamics_geometry_derivatives`. O(n) for each of them. SingularError if M is
singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> a = axode.forward_dynamics(arm, q, v, tau)
>>> d = axode.inverse_dynamics_geometry_derivatives(arm, q, v, a)
>>> forward = axode.forward_dynamics_geometry_derivatives(arm, q, v, tau)
>>> np.allclose(np.tensordot(axode.mass_matrix(arm, q), forward, 1), -d)
True
)");
  functions.define<"inverse_dynamics_geometry_vjp">(R"(
The gradient of w . tau of `inverse_dynamics` by geometric parameters: (n_bodies, 6) or (N, n_bodies, 6). O(n).

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.inverse_dynamics_geometry_derivatives(arm, q, v, a)
>>> np.allclose(axode.inverse_dynamics_geometry_vjp(arm, q, v, a, w), np.tensordot(w, d, 1))
True
)");
  functions.define<"forward_dynamics_geometry_vjp">(R"(
The gradient of w . a of `forward_dynamics` by geometric parameters: (n_bodies, 6) or (N, n_bodies, 6). O(n).

SingularError where M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_geometry_derivatives(arm, q, v, tau)
>>> np.allclose(axode.forward_dynamics_geometry_vjp(arm, q, v, tau, w), np.tensordot(w, d, 1))
True
)");
  functions.define<"frame_geometry_jacobian">(R"(
How a frame is displaced by geometric parameters: body-fixed twists, (6, n_bodies, 6) or (N, 6, n_bodies, 6).

Entry [:, i, u] is C^-1 dC by parameter u of body i, see `inverse_dynamics_geometry_derivatives`; it is 0 for bodies
that do not carry the frame. `offset` is a point (3,) or pose (4, 4) in the frame. O(d).

>>> J = axode.frame_geometry_jacobian(arm, np.full(7, 0.3), "flange")
>>> J.shape
(6, 7, 6)
)");
  functions.define<"jacobian_geometry_derivatives">(R"(
The derivatives of a frame's body-fixed `jacobian` by geometric parameters: (n_bodies, 6, 6, nv), or with N in front.

Entry [i, u] is the matrix for parameter u of body i, see `frame_geometry_jacobian`. O(d^2).

>>> axode.jacobian_geometry_derivatives(arm, np.full(7, 0.3), "flange").shape
(7, 6, 6, 7)
)");
  functions.define<"motion_derivatives">(R"(
(V_q, V_v, dV_q, dV_v): partial derivatives of a frame's twist and of its rate, (6, nv) or (N, 6, nv) each.

V is an entry of `twists` and dV one of `accelerations`, in the same representation. V_v is the Jacobian, and also the
derivative of dV by a. O(n).

>>> q, v, a = np.full(7, 0.3), np.ones(7), np.zeros(7)
>>> d = axode.motion_derivatives(arm, q, v, a, "flange", "hybrid")
>>> np.allclose(d.V_v, axode.jacobian(arm, q, "flange", "hybrid"))
True
)");
  functions.define<"motion_jvp">(R"(
(X, V, dV): the changes of the motion of a frame along a direction (dq, dv, da), (6,) or (N, 6) each. O(n), without a
matrix.

X is the displacement of its pose, C exp(eps X); V and dV are the changes of its twist and of the rate of its twist in
the given representation.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.motion_derivatives(arm, q, v, a, "flange", "hybrid")
>>> change = axode.motion_jvp(arm, q, v, a, "flange", w, w, w, "hybrid")
>>> np.allclose(change.V, d.V_q @ w + d.V_v @ w)
True
)");
  module.def("motion_vjp", &motion_vjp_of, "m"_a, "q"_a, "v"_a, "a"_a, "frame"_a, "w"_a,
             "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(), "threads"_a = 1,
             nb::sig("def motion_vjp(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
                     "a: numpy.typing.ArrayLike, frame: str | int, w: numpy.typing.ArrayLike, "
                     "representation: typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', *, "
                     "offset: numpy.typing.ArrayLike | None = None, threads: int = 1) -> "
                     "axode.InverseDynamicsDerivatives"),
             R"(
(q, v, a): the gradient of a weighted sum of the results of `motion_jvp`, (nv,) or (N, nv) each. O(n), without a
matrix.

w has the weights of X, V and dV in its rows, (3, 6) or (N, 3, 6).

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(18.0).reshape(3, 6)
>>> d = axode.motion_derivatives(arm, q, v, a, "flange", "hybrid")
>>> np.allclose(axode.motion_vjp(arm, q, v, a, "flange", w, "hybrid").a, w[2] @ d.V_v)
True
)");
  module.def(
      "linearize", &linearize_of, "m"_a, "q"_a, "v"_a, "tau"_a, "loads"_a = nb::none(), nb::kw_only(),
      "joint_losses"_a = false, "threads"_a = 1,
      nb::sig("def linearize(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "tau: numpy.typing.ArrayLike, loads: collections.abc.Sequence[axode.Load] | None = None, "
              "*, joint_losses: bool = False, threads: int = 1) -> axode.Linearization"),
      R"(
(A, B): small deviations x from the motion through the state change as x' = A x + B dtau.

A has shape (2 nv, 2 nv), B (2 nv, nv), or with N in front. The first half of x are displacements delta, q (+) delta
as in `Model.integrate`, rad and m; the second half are changes of v. A = [[-ad_v, 1], [da/dq, da/dv]] and B = [[0],
[da/dtau]] with the derivatives of `forward_dynamics`; ad_v is the bracket of each joint's motions (eq. ScrewProd), 0
at rest and for joints with one velocity. If v and the accelerations are 0, it is the linear system about an
equilibrium; otherwise it holds at this instant only. Springs, dampers and stops of the model act, as in `simulate`;
loads and joint_losses act as in `forward_dynamics_derivatives`. O(n) for each column. SingularError, with A, if the
mass matrix is singular. ValueError for a mechanism with drives that have states, which A would have to contain.

>>> pendulum = axode.load(axode.robots / "double_pendulum.toml")
>>> A, B = axode.linearize(pendulum, [0, 0], [0, 0], [0, 0])
>>> np.unique(np.abs(np.linalg.eigvals(A)).round(4))  # its two natural frequencies, rad/s
array([2.6801, 7.1887])
)");
  module.def("equilibrium", &equilibrium_of, "m"_a, "q0"_a, "tau"_a = nb::none(), "loads"_a = nb::none(),
             nb::kw_only(), "tolerance"_a = 1e-9, "iterations"_a = 100,
             nb::sig("def equilibrium(m: Model, q0: numpy.typing.ArrayLike, "
                     "tau: numpy.typing.ArrayLike | None = None, "
                     "loads: collections.abc.Sequence[axode.Load] | None = None, *, tolerance: float = 1e-9, "
                     "iterations: int = 100) -> axode.Equilibrium"),
             R"(
A configuration near q0, shape (nq,), that stays at rest under the loads and the drive forces tau, which are 0 if they
are left out.

There the gravity torques minus the loads equal tau plus the forces of springs, stops and loops (eq. LE), to
`tolerance`, N m and N; loops are closed. The method is Newton's with the exact derivative by q. Equilibria may be
stable or unstable; limits of joints are ignored, and so is friction, which would hold further configurations at rest.
The status of the result is "solved", "stalled" (probably there is no equilibrium near q0), "iteration_limit", or
"open" (the loops do not close near q0). The result also has q and the norm of the unbalanced forces there. O(n^3) for
each iteration.

>>> pendulum = axode.load(axode.robots / "double_pendulum.toml")
>>> found = axode.equilibrium(pendulum, [3, 0.2])
>>> found.status, found.q.round(6) + 0
('solved', array([3.141593, 0.      ]))
)");
}

}  // namespace axode::python
