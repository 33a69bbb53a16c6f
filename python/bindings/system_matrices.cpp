#include "axode/kinematics/system_matrices.hpp"

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

Array dense(const SystemMatrix& matrix) { return to_array(Eigen::MatrixXd(matrix)); }

/// The numbers of an argument that has the twists or twist rates of all bodies, stacked in one vector.
Eigen::VectorXd stacked(const Model& model, const char* name, ArrayLike given) {
  const Numbers numbers(name, given);
  const Shape expected{6 * model.n_bodies()};
  if (numbers.axes() != 1 || !numbers.ends_with(expected))
    numbers.wrong_shape(expected.text() + ", six numbers for each of the " +
                        std::to_string(model.n_bodies()) + " moving bodies");
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), numbers.size());
}

nb::object system_matrices_of(const BoundModel& m, ArrayLike q, Representation representation) {
  const States state = one_state(m, q);
  const SystemMatrices found = state.released(quadratic_cost(m), [&] {
    return with_representation(representation,
                               [&](auto rep) { return system_matrices<decltype(rep)>(m, state.q()); });
  });
  return named_tuple("axode.closed_form", "SystemMatrices", dense(found.A), dense(found.D), dense(found.X));
}

nb::object spatial_factors_of(const BoundModel& m, ArrayLike q) {
  const States state = one_state(m, q);
  const SpatialFactors found =
      state.released(quadratic_cost(m), [&] { return spatial_factors(m, state.q()); });
  return named_tuple("axode.closed_form", "SpatialFactors", dense(found.A_s), dense(found.Y_s),
                     dense(found.A_sb));
}

Array a_matrix_of(const BoundModel& m, ArrayLike v) {
  const Numbers velocities("v", v);
  const Shape expected{m->nv()};
  if (velocities.axes() != 1 || !velocities.ends_with(expected))
    velocities.wrong_shape(expected.text() + ", nv numbers");
  return dense(a_matrix(m, {velocities.data(), static_cast<std::size_t>(velocities.size())}));
}

Array system_twist_of(const BoundModel& m, ArrayLike q, ArrayLike v, Representation representation) {
  const States state = one_state(m, q);
  const Items velocities = state.velocities("v", v);
  return to_array(with_representation(
      representation, [&](auto rep) { return system_twist<decltype(rep)>(m, state.q(), velocities.all()); }));
}

Array system_acceleration_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                             Representation representation) {
  const States state = one_state(m, q);
  const Items velocities = state.velocities("v", v), accelerations = state.velocities("a", a);
  return to_array(with_representation(representation, [&](auto rep) {
    return system_acceleration<decltype(rep)>(m, state.q(), velocities.all(), accelerations.all());
  }));
}

Array joint_velocities_of(const BoundModel& m, ArrayLike q, ArrayLike V, Representation representation) {
  const States state = one_state(m, q);
  const Eigen::VectorXd twists = stacked(m, "V", V);
  return to_array(with_representation(
      representation, [&](auto rep) { return joint_velocities<decltype(rep)>(m, state.q(), twists); }));
}

Array joint_accelerations_of(const BoundModel& m, ArrayLike q, ArrayLike V, ArrayLike dV,
                             Representation representation) {
  const States state = one_state(m, q);
  const Eigen::VectorXd twists = stacked(m, "V", V), rates = stacked(m, "dV", dV);
  return to_array(with_representation(representation, [&](auto rep) {
    return joint_accelerations<decltype(rep)>(m, state.q(), twists, rates);
  }));
}

}  // namespace

void add_system_matrices(nb::module_& closed_form) {
  closed_form.def("system_matrices", &system_matrices_of, "m"_a, "q"_a, "representation"_a = "body",
                  nb::sig("def system_matrices(m: axode.Model, q: numpy.typing.ArrayLike, representation: "
                          "typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body') -> "
                          "axode.closed_form.SystemMatrices"),
                  R"(
(A, D, X): the matrices of V = A X v, the twists of all bodies, with A = (I - D)^-1 (eqs. VbAX, JbSys).

D (6n, 6n) has the transformation of the predecessor's twist in the block (i, predecessor of i), A (6n, 6n) the products
along the paths, X (6n, nv) the joint screws. In spatial representation D has identities, and X the instantaneous
joint screws.

>>> A, D, X = axode.closed_form.system_matrices(arm, arm.random())
>>> np.allclose(A @ (np.eye(42) - D), np.eye(42))
True
)");
  closed_form.def("spatial_factors", &spatial_factors_of, "m"_a, "q"_a,
                  nb::sig("def spatial_factors(m: axode.Model, q: numpy.typing.ArrayLike) -> "
                          "axode.closed_form.SpatialFactors"),
                  R"(
(A_s, Y_s, A_sb): the matrices of the other factorisations of the spatial Jacobian, J^s = A_s Y_s = A_sb X^b (eq.
JbSys).

A_s and A_sb have the shape (6n, 6n); Y_s (6n, nv) has the joint screws in the inertial frame at q = 0, which are
constant.

>>> q = arm.random()
>>> A_s, Y_s, A_sb = axode.closed_form.spatial_factors(arm, q)
>>> np.allclose(A_s @ Y_s, A_sb @ axode.closed_form.system_matrices(arm, q).X)
True
)");
  closed_form.def("a_matrix", &a_matrix_of, "m"_a, "v"_a, R"(
The matrix a^b = diag(ad_{X_i v_i}), (6n, 6n), from v (nv,): the rate of J^b is -A^b a^b D^b J^b (eqs. ab, u:Jb_dot
matrix).

>>> axode.closed_form.a_matrix(arm, np.ones(7)).shape
(42, 42)
)");
  closed_form.def(
      "b_matrix", [](const BoundModel& m, ArrayLike V) { return dense(b_matrix(m, stacked(m, "V", V))); },
      "m"_a, "V"_a,
      R"(
The matrix b = diag(ad_{V_1}, ..., ad_{V_n}), (6n, 6n), from stacked body-fixed or spatial twists V (6n,) (eqs. bb,
bs).

>>> V = axode.closed_form.system_twist(arm, arm.random(), np.ones(7))
>>> np.allclose(axode.closed_form.b_matrix(arm, V)[:6, :6], axode.lie.ad(V[:6]))
True
)");
  closed_form.def("system_twist", &system_twist_of, "m"_a, "q"_a, "v"_a, "representation"_a = "body", R"(
The twists V = J v of all moving bodies, stacked: (6n,), rad/s and m/s.

q has shape (nq,), v (nv,).

>>> q, v = arm.random(), np.ones(7)
>>> A, D, X = axode.closed_form.system_matrices(arm, q)
>>> np.allclose(axode.closed_form.system_twist(arm, q, v), A @ X @ v)
True
)");
  closed_form.def("system_acceleration", &system_acceleration_of, "m"_a, "q"_a, "v"_a, "a"_a,
                  "representation"_a = "body", R"(
The time derivatives V' of the twists of all moving bodies, stacked: (6n,), rad/s^2 and m/s^2, without gravity.

q has shape (nq,), v and a (nv,).

>>> axode.closed_form.system_acceleration(arm, arm.random(), np.ones(7), np.ones(7), "hybrid").shape
(42,)
)");
  closed_form.def("joint_velocities", &joint_velocities_of, "m"_a, "q"_a, "V"_a, "representation"_a = "body",
                  R"(
The velocities v (nv,) that belong to the twists V (6n,) of all bodies: (X^T X)^-1 X^T (I - D) V.

If no v gives V, the result is the least-squares solution. q has shape (nq,).

>>> q = arm.random()
>>> V = axode.closed_form.system_twist(arm, q, np.ones(7))
>>> axode.closed_form.joint_velocities(arm, q, V).round(9)
array([1., 1., 1., 1., 1., 1., 1.])
)");
  closed_form.def("joint_accelerations", &joint_accelerations_of, "m"_a, "q"_a, "V"_a, "dV"_a,
                  "representation"_a = "body", R"(
The accelerations a (nv,) that belong to the twists V and their rates dV (6n,) of all bodies (eq. solqddot1).

If no a gives dV, the result is the least-squares solution. q has shape (nq,).

>>> q, v, a = arm.random(), np.ones(7), np.full(7, 2.0)
>>> V, dV = axode.closed_form.system_twist(arm, q, v), axode.closed_form.system_acceleration(arm, q, v, a)
>>> axode.closed_form.joint_accelerations(arm, q, V, dV).round(9)
array([2., 2., 2., 2., 2., 2., 2.])
)");
}

}  // namespace axode::python
