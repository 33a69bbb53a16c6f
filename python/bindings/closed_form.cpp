#include "axode/dynamics/closed_form/closed_form.hpp"

#include "axode/kinematics/higher_order/product_of_exponentials.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/one_state.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

Array inertia_matrix_of(const BoundModel& m, ArrayLike q, Representation representation) {
  const States state = one_state(m, q);
  return to_array(with_representation(
      representation, [&](auto rep) { return closed_form::inertia_matrix<decltype(rep)>(m, state.q()); }));
}

Array mass_matrix_of(const BoundModel& m, ArrayLike q, Representation representation) {
  const States state = one_state(m, q);
  return to_array(state.released(cubic_cost(m), [&] {
    return with_representation(
        representation, [&](auto rep) { return closed_form::mass_matrix<decltype(rep)>(m, state.q()); });
  }));
}

/// An array of the poses of the ground and of all bodies, which f(m, q) computes.
Array poses_of_bodies(const BoundModel& m, ArrayLike q, const auto& f) {
  const States state = one_state(m, q);
  check_configuration(*m, state.q());
  const std::vector<SE3<>> C = f(*m, state.q().data());
  NewArray out({m->n_bodies() + 1, 4, 4});
  for (std::size_t i = 0; i < C.size(); ++i) write(C[i], out.data() + 16 * i);
  return out.array();
}

/// The vector f(q, v, a, loads) as an array, after the arguments have been checked.
template <class F>
Array equations(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a, LoadList given, bool joint_losses,
                const F& f) {
  const States state = one_state(m, q);
  const Items velocities = state.velocities("v", v), accelerations = state.velocities("a", a);
  const AppliedLoads loads(state, given, joint_losses);
  return to_array(state.released(cubic_cost(m), [&] {
    return loads.with(0, [&](const Loads<double>& applied) {
      return f(state.q(), velocities.all(), accelerations.all(), applied);
    });
  }));
}

Array projection_equations_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                              Representation representation, LoadList loads, bool joint_losses) {
  return equations(m, q, v, a, loads, joint_losses, [&](auto... arguments) {
    return with_representation(representation, [&](auto rep) {
      return closed_form::projection_equations<decltype(rep)>(m, arguments...);
    });
  });
}

Array momentum_balance_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a, LoadList loads,
                          bool joint_losses) {
  return equations(m, q, v, a, loads, joint_losses,
                   [&](auto... arguments) { return closed_form::momentum_balance(m, arguments...); });
}

Array lagrange_equations_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a, LoadList loads,
                            bool joint_losses) {
  return equations(m, q, v, a, loads, joint_losses,
                   [&](auto... arguments) { return closed_form::lagrange_equations(m, arguments...); });
}

Array coriolis_matrix_of(const BoundModel& m, ArrayLike q, ArrayLike v, CoriolisForm form) {
  const States state = one_state(m, q);
  const Items velocities = state.velocities("v", v);
  return to_array(state.released(
      cubic_cost(m), [&] { return closed_form::coriolis_matrix(m, state.q(), velocities.all(), form); }));
}

Array christoffel_of(const BoundModel& m, ArrayLike q) {
  const States state = one_state(m, q);
  const std::vector<double> Gamma =
      state.released(cubic_cost(m), [&] { return closed_form::christoffel(m, state.q()); });
  NewArray out({m->nv(), m->nv(), m->nv()});
  put(Gamma, out.all());
  return out.array();
}

}  // namespace

void add_closed_form(nb::module_& module) {
  module.def(
      "poses_by_body_screws",
      [](const BoundModel& m, ArrayLike q) { return poses_of_bodies(m, q, &poses_by_body_screws<double>); },
      "m"_a, "q"_a, R"(
C_i = B_1 exp(X_1 q_1) ... B_i exp(X_i q_i) of the ground and all bodies, (n_bodies + 1, 4, 4); q (nq,); m (eq. POEX).

>>> q = arm.random()
>>> np.allclose(axode.closed_form.poses_by_body_screws(arm, q), axode.poses(arm, q)[:arm.n_bodies + 1])
True
)");
  module.def(
      "poses_by_spatial_screws",
      [](const BoundModel& m, ArrayLike q) {
        return poses_of_bodies(m, q, &poses_by_spatial_screws<double>);
      },
      "m"_a, "q"_a, R"(
C_i = exp(Y_1 q_1) ... exp(Y_i q_i) A_i of the ground and all bodies, (n_bodies + 1, 4, 4); q (nq,); m (eq. POEY).

>>> q = arm.random()
>>> np.allclose(axode.closed_form.poses_by_spatial_screws(arm, q), axode.poses(arm, q)[:arm.n_bodies + 1])
True
)");
  module.def("inertia_matrix", &inertia_matrix_of, "m"_a, "q"_a, "representation"_a = "body", R"(
M = diag(M_1, ..., M_n), (6n, 6n): the inertia matrices of the moving bodies at q (nq,), in kg m^2, kg m and kg.

>>> np.array_equal(axode.closed_form.inertia_matrix(arm, arm.neutral())[:6, :6], arm.body("link 1").M)
True
)");
  module.def("projection_equations", &projection_equations_of, "m"_a, "q"_a, "v"_a, "a"_a,
             "representation"_a = "body", "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false, R"(
tau = J^T (M_i V'_i - ad_V^T M_i V_i - W_i^app), the Euler-Jourdain (projection, Kane) equations: (nv,) (eq. PE).

N m or N. Gravity is an applied wrench. q has shape (nq,), v and a (nv,); loads and joint_losses are those of
`axode.inverse_dynamics`, which gives the same result in O(n).

>>> q, v, a = arm.random(), np.ones(7), np.ones(7)
>>> tau = axode.closed_form.projection_equations(arm, q, v, a, "hybrid")
>>> np.allclose(tau, axode.inverse_dynamics(arm, q, v, a))
True
)");
  module.def("momentum_balance", &momentum_balance_of, "m"_a, "q"_a, "v"_a, "a"_a, "loads"_a = nb::none(),
             nb::kw_only(), "joint_losses"_a = false, R"(
tau = (J^s)^T (Pi'_i - W_i^app), the projected balance of spatial momentum: (nv,), N m or N (eq. PEs).

q has shape (nq,), v and a (nv,); loads and joint_losses as in `axode.inverse_dynamics`.

>>> q, v, a = arm.random(), np.ones(7), np.ones(7)
>>> np.allclose(axode.closed_form.momentum_balance(arm, q, v, a), axode.inverse_dynamics(arm, q, v, a))
True
)");
  module.def("mass_matrix", &mass_matrix_of, "m"_a, "q"_a, "representation"_a = "body", R"(
The mass matrix J^T M J plus the armatures: (nv, nv) at q (nq,), kg m^2, kg m, kg (eq. MLE). It is the same in all
representations.

>>> M = axode.closed_form.mass_matrix(arm, arm.random())
>>> np.allclose(M, M.T)
True
)");
  module.def("coriolis_matrix", &coriolis_matrix_of, "m"_a, "q"_a, "v"_a, "form"_a = "paper", R"(
A matrix C for which C v are the Coriolis and centrifugal forces: (nv, nv), by the formula of `form` (eq. CMat).

paper: -J^T (M A a + b^T M) J; skew: -J^T (M A a + b^T M - M b) J, for which M' - 2C is skew; spatial: the same matrix
in spatial twists; christoffel: the sum of Gamma_ijk v_k. q has shape (nq,), v (nv,).

>>> q, v = arm.random(), np.ones(7)
>>> C, D = (axode.closed_form.coriolis_matrix(arm, q, v, form) for form in ("paper", "skew"))
>>> np.allclose(C @ v, D @ v), np.allclose(C, D)
(True, False)
)");
  module.def("lagrange_equations", &lagrange_equations_of, "m"_a, "q"_a, "v"_a, "a"_a, "loads"_a = nb::none(),
             nb::kw_only(), "joint_losses"_a = false, R"(
tau = M a + C v + dU/dq - Q, Lagrange's equations with the paper's C: (nv,), N m or N (eq. LE).

q has shape (nq,), v and a (nv,); loads and joint_losses as in `axode.inverse_dynamics`.

>>> q, v, a = arm.random(), np.ones(7), np.ones(7)
>>> np.allclose(axode.closed_form.lagrange_equations(arm, q, v, a), axode.inverse_dynamics(arm, q, v, a))
True
)");
  module.def("christoffel", &christoffel_of, "m"_a, "q"_a, R"(
Gamma_ijk, the Christoffel symbols of the first kind with Binet's inertia tensor: (nv, nv, nv) (eq. GammaBinet).

Gamma @ v is the Christoffel form of C, at q (nq,). O(n^4). ValueError if a joint has several degrees of freedom.

>>> q, v = arm.random(), np.ones(7)
>>> C = axode.closed_form.coriolis_matrix(arm, q, v, "christoffel")
>>> np.allclose(axode.closed_form.christoffel(arm, q) @ v, C)
True
)");
}

}  // namespace axode::python
