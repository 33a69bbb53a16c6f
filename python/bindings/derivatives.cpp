#include "axode/derivatives.hpp"

#include "bindings.hpp"
#include "conversions.hpp"
#include "state_function.hpp"

/// Derivatives of dynamics. The types of several results are in axode.records.
namespace axode::python {

using namespace nb::literals;

namespace {

nb::object inverse_dynamics_rates_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                                     nb::args more, LoadList loads, bool joint_losses, int threads) {
  const States states(m, q, threads);
  std::vector<Items> rates{states.velocities("v", v), states.velocities("a", a)};
  for (std::size_t k = 0; k < more.size(); ++k) {
    const nb::object given = more[k];
    const std::string name = "derivative " + std::to_string(k + 1) + " of a";
    rates.push_back(states.velocities(name.c_str(), {given.ptr()}));
  }
  const AppliedLoads applied(states, loads, joint_losses);
  const int order = static_cast<int>(rates.size()) - 2;
  const Shape shape{order + 1, m->nv()};
  const NewArray out =
      each_item(states, (order + 1) * (order + 1) * linear_cost(*m), shape,
                [&](Workspace<>&, std::size_t k, std::span<double> tau) {
                  std::vector<double> motion;
                  for (const Items& rate : rates) motion.insert(motion.end(), rate[k].begin(), rate[k].end());
                  applied.with(k, [&](const Loads<double>& now) {
                    InverseDynamicsRates<>(*m, order).evaluate(states.q(k), motion, tau, now);
                  });
                });
  nb::list parts;
  for (int k = 0; k <= order; ++k) parts.append(nb::cast(out.part(k, 1)));
  return nb::tuple(parts);
}

}  // namespace

void add_derivatives(nb::module_& module) {
  using A = Arguments;
  const StateFunctions functions(module);
  functions.of_loaded<&A::q, &A::v, &A::a>("inverse_dynamics_derivatives", "InverseDynamicsDerivatives", R"(
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
  functions.of_loaded<&A::q, &A::v, &A::a, &A::dq, &A::dv, &A::da>("inverse_dynamics_jvp", nullptr, R"(
What a direction (dq, dv, da) does to the forces of `inverse_dynamics`: (nv,) or (N, nv). O(n), without a matrix.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.inverse_dynamics_derivatives(arm, q, v, a)
>>> np.allclose(axode.inverse_dynamics_jvp(arm, q, v, a, w, w, w), d.q @ w + d.v @ w + d.a @ w)
True
)");
  functions.of_loaded<&A::q, &A::v, &A::a, &A::w>("inverse_dynamics_vjp", "InverseDynamicsDerivatives", R"(
(q, v, a): the gradient of w . tau of `inverse_dynamics`, (nv,) or (N, nv) each. O(n), without a matrix.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> np.allclose(axode.inverse_dynamics_vjp(arm, q, v, a, w).q, w @ axode.inverse_dynamics_derivatives(arm, q, v, a).q)
True
)");
  functions.of_loaded<&A::q, &A::v, &A::a, &A::w>("inverse_dynamics_hessian", "InverseDynamicsHessian", R"(
(qq, qv, vv, aq): second partial derivatives of w . tau of `inverse_dynamics`, (nv, nv) or (N, nv, nv) each.

Entry [k, l] is the derivative along k of that along l. On a joint with several velocities the displacement k of q comes
first, q (+) e_k (+) e_l; elsewhere qq is symmetric. O(n d).

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> h = axode.inverse_dynamics_hessian(arm, q, v, a, w)
>>> np.allclose(h.qq, h.qq.T)
True
)");
  functions.of_loaded<&A::q, &A::v, &A::tau>("forward_dynamics_derivatives", "ForwardDynamicsDerivatives", R"(
(q, v, tau): the partial derivatives of `forward_dynamics`, matrices (nv, nv) or (N, nv, nv), [component, direction].

Terms as in `inverse_dynamics_derivatives`; the derivative by tau is the inverse mass matrix. O(n) for each column.
SingularError where M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(d.tau @ axode.mass_matrix(arm, q), np.eye(7))
True
)");
  functions.of_loaded<&A::q, &A::v, &A::tau, &A::dq, &A::dv, &A::dtau>("forward_dynamics_jvp", nullptr, R"(
What a direction (dq, dv, dtau) does to the accelerations of `forward_dynamics`: (nv,) or (N, nv). O(n), without a matrix.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(axode.forward_dynamics_jvp(arm, q, v, tau, w, w, w), d.q @ w + d.v @ w + d.tau @ w)
True
)");
  functions.of_loaded<&A::q, &A::v, &A::tau, &A::w>("forward_dynamics_vjp", "ForwardDynamicsDerivatives", R"(
(q, v, tau): the gradient of w . a of `forward_dynamics`, (nv,) or (N, nv) each. O(n), without a matrix.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> d = axode.forward_dynamics_derivatives(arm, q, v, tau)
>>> np.allclose(axode.forward_dynamics_vjp(arm, q, v, tau, w).v, w @ d.v)
True
)");
  functions.of_loaded<&A::q, &A::v, &A::tau, &A::w>("forward_dynamics_hessian", "ForwardDynamicsHessian", R"(
(qq, qv, vv, tauq): second partial derivatives of w . a of `forward_dynamics`, (nv, nv) or (N, nv, nv) each.

Entries as in `inverse_dynamics_hessian`. O(n^2 d). SingularError where M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> h = axode.forward_dynamics_hessian(arm, q, v, tau, w)
>>> np.allclose(h.vv, h.vv.T)
True
)");
  functions.of<&A::q, &A::v, &A::a>("inverse_dynamics_second_derivatives", "InverseDynamicsHessian", R"(
(qq, qv, vv, aq): second partial derivatives of `inverse_dynamics` without loads, (nv, nv, nv) or (N, nv, nv, nv) each.

Entry [i, k, l] is the derivative along k of that of tau[i] along l, see `inverse_dynamics_hessian`, which is what to call
where components are only weighed. O(n d^2), and the zeros.

>>> q, v, a, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> second = axode.inverse_dynamics_second_derivatives(arm, q, v, a)
>>> np.allclose(np.tensordot(w, second.qq, 1), axode.inverse_dynamics_hessian(arm, q, v, a, w).qq)
True
)");
  functions.of<&A::q, &A::v, &A::tau>("forward_dynamics_second_derivatives", "ForwardDynamicsHessian", R"(
(qq, qv, vv, tauq): second partial derivatives of `forward_dynamics` without loads, (nv, nv, nv) or (N, nv, nv, nv) each.

Entries as in `inverse_dynamics_second_derivatives`. O(n^3 d). SingularError where M is singular.

>>> q, v, tau, w = np.full(7, 0.3), np.ones(7), np.zeros(7), np.arange(7.0)
>>> second = axode.forward_dynamics_second_derivatives(arm, q, v, tau)
>>> np.allclose(np.tensordot(w, second.vv, 1), axode.forward_dynamics_hessian(arm, q, v, tau, w).vv)
True
)");
  module.def(
      "inverse_dynamics_rates", &inverse_dynamics_rates_of, "m"_a, "q"_a, "v"_a, "a"_a, "more"_a,
      "loads"_a = nb::none(), "joint_losses"_a = false, "threads"_a = 1,
      nb::sig("def inverse_dynamics_rates(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "a: numpy.typing.ArrayLike, *more: numpy.typing.ArrayLike, "
              "loads: collections.abc.Sequence[axode.Load] | None = None, joint_losses: bool = False, "
              "threads: int = 1) -> tuple[numpy.typing.NDArray[numpy.float64], ...]"),
      R"(
(tau, tau', tau'', ...): the drive forces of a motion and their time derivatives, (nv,) or (N, nv) each.

`more` are jerk, snap, ..., the derivatives of a; each gives one more result. Loads are constant in the representation in
which they are given. O(n k^2) for k results.

>>> q, v, a, jerk = np.full(7, 0.3), np.ones(7), np.zeros(7), np.ones(7)
>>> tau, rate = axode.inverse_dynamics_rates(arm, q, v, a, jerk)
>>> d = axode.inverse_dynamics_derivatives(arm, q, v, a)
>>> np.allclose(rate, d.q @ v + d.v @ a + d.a @ jerk)
True
)");
}

}  // namespace axode::python
