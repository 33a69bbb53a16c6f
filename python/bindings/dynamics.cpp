#include "axode/dynamics.hpp"

#include <nanobind/stl/string.h>

#include <algorithm>

#include "axode/model/building/nearest_name.hpp"
#include "python/bindings/constraints.hpp"
#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/raise.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

/// Replaces every row x of `out` by M⁻¹ x; set(k, row) writes the x of row k before. Ctrl-C ends the call.
template <class F> Array solved_rows(const MassMatrixFactor<>& factor, NewArray out, const F& set) {
  const std::size_t n = static_cast<std::size_t>(factor.nv()), rows = n == 0 ? 0 : out.all().size() / n;
  LongCall call(true);
  const batch::Monitor monitor = call.monitor();
  batch::MonitorThrottle throttle(monitor, rows);
  for (std::size_t k = 0; k < rows && throttle.should_continue(k); ++k) {
    const std::span<double> row = out.all().subspan(k * n, n);
    set(k, row);
    factor.solve(row);
  }
  call.end();
  return out.array();
}

/// Subtracts `forces`, nv numbers for each state, from tau, the drive forces of the states.
Array without(nb::handle forces, Array tau, const States& states) {
  static_cast<void>(states.velocities("forces", {forces.ptr()}));  // throws if `forces` has a wrong shape
  return {nb::steal(PyNumber_InPlaceSubtract(tau.array.ptr(), forces.ptr()))};
}

void add_equations_of_motion(nb::module_& module) {
  const StateFunctions functions(module);
  module.def(
      "inverse_dynamics",
      [f = StateFunction("inverse_dynamics")](const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                                              Algorithm algorithm, LoadList loads, bool joint_losses,
                                              int threads, nb::handle drives, nb::handle forces) {
        const Arguments all{.q = q,
                            .v = v,
                            .a = a,
                            .algorithm = algorithm,
                            .loads = loads,
                            .joint_losses = joint_losses,
                            .threads = threads};
        const bool gears = joint_losses && !m->gears().empty();  // `forces` bypass gears
        if (!drives.is_none() || (!forces.is_none() && (gears || !m->loops().empty())))
          return closed_inverse_dynamics(m, all, drives, forces);
        Array tau = f(m, all);
        return forces.is_none() ? tau : without(forces, std::move(tau), States(m, q, threads));
      },
      "m"_a, "q"_a, "v"_a, "a"_a, "representation"_a = "fast", "loads"_a = nb::none(), nb::kw_only(),
      "joint_losses"_a = false, "threads"_a = 1, "drives"_a = nb::none(), "forces"_a = nb::none(),
      documented("inverse_dynamics", R"(
tau = M(q) a + C(q, v) v + g(q) - (applied forces): the drive forces that produce the accelerations a.

Shape (nv,) or (N, nv), N m or N. `loads` are wrenches on frames, see `axode.Load`; joint_losses adds damping,
friction and losses of gears; armatures are always included. All representations give the same result; "fast" takes the least time, and
computes N states in SIMD lanes on up to `threads` cores. `forces` (nv,) or (N, nv) act in addition; springs and stops
of m are left out unless forces=axode.spring_forces(m, q, v). In a mechanism with loops, only joints that are not
passive have drive forces or, if `drives` (names of joints or numbers of velocities) is given, only these; if several
tau are possible, it is the least one. ValueError if the drives cannot produce a, and if a does not keep a loop
closed. O(n), by the recursive Newton-Euler algorithm (eqs. aVbRec2 to cWhRec).

>>> q, v, a = arm.neutral(), np.full(7, 0.5), np.ones(7)
>>> q[1] = 0.8
>>> axode.inverse_dynamics(arm, q, v, a)[:4].round(3)
array([  2.67 , -50.147,  -0.109,  14.362])
)")
          .c_str());
  functions.define<"forward_dynamics">(R"(
The accelerations a that the drive forces tau produce, the inverse of `inverse_dynamics` with the same loads.

Shape (nv,) or (N, nv). O(n) by the articulated-body algorithm. SingularError, which names the joint, if the mass
matrix is singular; its `result` has the accelerations of all other states. Springs and stops of m are left out: add
`spring_forces` to tau to include them. For a mechanism with loops at a closed state, see `assemble`, the
accelerations are those that keep the loops closed.

>>> q, v = arm.neutral(), np.full(7, 0.5)
>>> tau = axode.inverse_dynamics(arm, q, v, np.ones(7))
>>> axode.forward_dynamics(arm, q, v, tau).round(9)
array([1., 1., 1., 1., 1., 1., 1.])
)");
  module.def(
      "joint_wrenches",
      [f = StateFunction("joint_wrenches")](const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                                            Representation representation, LoadList loads, WrenchPoint at,
                                            bool joint_losses, int threads, nb::handle drives) {
        const Arguments all{.q = q,
                            .v = v,
                            .a = a,
                            .algorithm = {representation},
                            .loads = loads,
                            .joint_losses = joint_losses,
                            .at = at,
                            .threads = threads};
        return drives.is_none() ? f(m, all) : closed_joint_wrenches(m, all, drives);
      },
      "m"_a, "q"_a, "v"_a, "a"_a, "representation"_a = "body", "loads"_a = nb::none(), nb::kw_only(),
      "at"_a = "body", "joint_losses"_a = false, "threads"_a = 1, "drives"_a = nb::none(),
      documented("joint_wrenches", R"(
The wrench that each joint transmits to its body, drive and reaction together: moment (N m), then force (N).

Shape (n_bodies, 6) or (N, n_bodies, 6), row i for body i of `m.body_names`, in the representation of its frame.
Moments are about the origin of that frame or, with at="joint", about the joint's point, `Body.S_self`; spatial
wrenches are about the inertial origin in both cases. O(n). For a mechanism with loops, they are the wrenches under
the drive forces of `inverse_dynamics`, with the same argument `drives`; O(nv^3). If loops are redundant, the wrenches
belong to the least multipliers, see `constraint_wrenches`.

>>> W = axode.joint_wrenches(arm, arm.neutral(), np.zeros(7), np.zeros(7), "hybrid")
>>> W[0, 3:].round(3)
array([ 0.   ,  0.   , 258.337])
)")
          .c_str());
  functions.define<"coriolis_vector">(R"(
C(q, v) v, the drive forces of the motion without gravity, loads and accelerations: (nv,) or (N, nv). O(n).

>>> axode.coriolis_vector(arm, arm.neutral(), np.zeros(7)).any()
np.False_
)");
  functions.define<"gravity_torques">(R"(
g(q) = dU/dq, the drive forces that hold the mechanism at rest against gravity: (nv,) or (N, nv), N m or N. O(n).

>>> axode.gravity_torques(arm, np.full(7, 0.5))[1].round(3)
np.float64(-26.588)
)");
  functions.define<"generalized_loads">(R"(
Q, the sum of J^T W over the loads, with damping and friction if joint_losses is set: (nv,) or (N, nv). O(n).

>>> push = [{"frame": "flange", "representation": "hybrid", "wrench": [0, 0, 0, 10, 0, 0]}]
>>> axode.generalized_loads(arm, arm.neutral(), np.zeros(7), push)[[1, 3, 5]].round(3)
array([ 9.46, -5.26,  1.26])
)");
}

void add_matrices(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"mass_matrix">(R"(
M(q), the generalized mass matrix, armature included: (nv, nv) or (N, nv, nv), symmetric.

The composite-body algorithm takes O(n d) for depth d; all representations give the same result.

>>> M = axode.mass_matrix(arm, arm.neutral())
>>> bool((M == M.T).all())
True
)");
  functions.define<"inverse_mass_matrix">(R"(
The inverse of M(q), (nv, nv) or (N, nv, nv), by the articulated-body algorithm. O(n^2).

SingularError if M is singular.

>>> M, W = axode.mass_matrix(arm, arm.neutral()), axode.inverse_mass_matrix(arm, arm.neutral())
>>> np.allclose(M @ W, np.eye(7))
True
)");
  functions.define<"coriolis_matrix">(R"(
C(q, v) with C v = `coriolis_vector`: (nv, nv) or (N, nv, nv). O(n d).

"paper": the paper's C (eq. CMat); M' - 2C is not skew. "skew": the paper's C', for which M' - 2C is skew. "spatial":
the same matrix as "skew", computed from spatial twists. "christoffel": C_ij = sum of Gamma_ijk v_k; M' - 2C is skew.

>>> v = np.ones(7)
>>> C = axode.coriolis_matrix(arm, arm.neutral(), v, form="skew")
>>> np.allclose(C @ v, axode.coriolis_vector(arm, arm.neutral(), v))
True
)");
  functions.define<"christoffel">(R"(
Christoffel symbols of the first kind, Gamma[i, j, k]: (nv, nv, nv) or (N, nv, nv, nv) (eq. Gamma, corrected).

They are symmetric in j and k, except for velocities of one joint with several degrees of freedom. O(n d^2).

>>> Gamma, v = axode.christoffel(arm, np.full(7, 0.3)), np.ones(7)
>>> np.allclose(Gamma @ v @ v, axode.coriolis_vector(arm, np.full(7, 0.3), v))
True
)");
  functions.define<"mass_matrix_partials">(R"(
The partial derivatives of M, entry [k] = dM/dq_k along q (+) e_k: (nv, nv, nv) or (N, nv, nv, nv). O(n d^2).

>>> axode.mass_matrix_partials(arm, arm.neutral()).shape
(7, 7, 7)
)");
  functions.define<"inverse_mass_matrix_partials">(R"(
The partial derivatives of the inverse of M, -M^-1 dM/dq_k M^-1, in the order of `mass_matrix_partials`. O(n^4).

>>> axode.inverse_mass_matrix_partials(arm, arm.neutral()).shape
(7, 7, 7)
)");
  nb::class_<MassMatrixFactor<>>(module, "MassMatrixFactor", R"(
The factors of M = L^T D L. L is lower triangular with a unit diagonal; as in M, only entries of velocities on one
path are non-zero.

MassMatrixFactor(m, M) factorises a mass matrix (nv, nv) of the model m; O(n d^2). SingularError if it is singular.

>>> M = axode.mass_matrix(arm, arm.neutral())
>>> factor = axode.MassMatrixFactor(arm, M)
>>> np.allclose(M @ factor.solve(np.ones(7)), 1)
True
)")
      .def(
          "__init__",
          [](MassMatrixFactor<>* self, const BoundModel& m, ArrayLike M) {
            const Numbers matrix("M", M);
            if (matrix.axes() != 2 || !matrix.ends_with({m->nv(), m->nv()}))
              matrix.wrong_shape(Shape{m->nv(), m->nv()}.text() + ", nv by nv");
            MassMatrixFactor<> factor(m);
            const Solvability found = [&] {
              const nb::gil_scoped_release others_run;
              return factor.factorize({matrix.data(), static_cast<std::size_t>(matrix.size())});
            }();
            if (!found.ok())
              raise_of_states(found.not_finite ? "NotFiniteError" : "SingularError", to_string(*m, found),
                              {0}, {nb::object(nb::none())});
            new (self) MassMatrixFactor<>(std::move(factor));
          },
          "m"_a, "M"_a)
      .def(
          "solve",
          [](const MassMatrixFactor<>& factor, ArrayLike given) {
            const Numbers x("x", given);
            const nb::ssize_t n = factor.nv();
            if (x.axes() < 1 || x.axes() > 2 || !x.ends_with({n}))
              x.wrong_shape(Shape{n}.text() + " or (N, " + std::to_string(n) + ")");
            return solved_rows(factor, NewArray(x.axes() == 1 ? Shape{n} : Shape{x.length(0), n}),
                               [&](std::size_t k, std::span<double> row) {
                                 std::copy_n(x.data() + k * row.size(), row.size(), row.data());
                               });
          },
          "x"_a, "M^-1 x for x of shape (nv,), or for each row of (N, nv). O(n d).")
      .def(
          "inverse",
          [](const MassMatrixFactor<>& factor) {
            return solved_rows(factor, NewArray({factor.nv(), factor.nv()}),
                               [](std::size_t k, std::span<double> row) {
                                 std::fill(row.begin(), row.end(), 0);
                                 row[k] = 1;
                               });
          },
          "M^-1, (nv, nv). O(n^2 d).")
      .def_prop_ro(
          "L",
          [](const MassMatrixFactor<>& factor) {
            const int n = factor.nv();
            NewArray out({n, n});
            for (int c = 0; c < n; ++c)
              for (int p = 0; p < n; ++p) out.data()[c * n + p] = factor.L(c, p);
            return out.array();
          },
          "Unit lower triangular, (nv, nv).")
      .def_prop_ro(
          "D",
          [](const MassMatrixFactor<>& factor) {
            NewArray out({factor.nv()});
            for (int c = 0; c < factor.nv(); ++c) out.data()[c] = factor.D(c);
            return out.array();
          },
          "The diagonal, (nv,).")
      .def("__repr__", [](const MassMatrixFactor<>& factor) {
        return "MassMatrixFactor(nv = " + std::to_string(factor.nv()) + ")";
      });
}

/// The index of a spring that is given by its name or index.
int spring_index(const Model& m, nb::handle given) {
  const std::vector<Spring>& springs = m.springs().elements;
  int k = -1;
  if (!nb::isinstance<nb::str>(given)) {
    if (!nb::try_cast(given, k))
      throw nb::value_error(("spring is " + shown(given) + "; expected its name or number").c_str());
    return k;
  }
  const std::string name = text_of(given);
  const auto found = std::ranges::find(springs, name, &Spring::name);
  if (found == springs.end())
    throw UnknownName("model \"" + m.name() + "\" has no spring \"" + name + '"' +
                      did_you_mean(name, springs, [](const Spring& spring) { return spring.name; }));
  return static_cast<int>(found - springs.begin());
}

nb::object spring_coordinate_of(const BoundModel& m, ArrayLike q, nb::handle spring, int threads) {
  const States states(m, q, threads);
  const int number = spring_index(m, spring);
  const Shape one{}, row{m->nv()};
  NewArray coordinate = states.result(one), gradient = states.result(row);
  states.each(linear_cost(m), [&](Workspace<>& workspace, std::size_t k) {
    item(coordinate, k, one)[0] =
        spring_coordinate<double>(m, workspace, number, states.q(k), item(gradient, k, row));
  });
  states.refuse({}, coordinate);
  return record("SpringCoordinate", coordinate.array(), gradient.array());
}

void add_energies(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"kinetic_energy">(R"(
The kinetic energy T = v^T M v / 2 of bodies and armatures, J: a number, or (N,). O(n).

>>> float(axode.kinetic_energy(arm, arm.neutral(), np.zeros(7)))
0.0
)");
  functions.define<"potential_energy">(R"(
The potential energy U of gravity, 0 for masses at the inertial origin, J: a number, or (N,). O(n).

>>> U = axode.potential_energy(arm, arm.neutral())
>>> bool(np.isclose(U, 9.81 * arm.total_mass * axode.center_of_mass(arm, arm.neutral())[2]))
True
)");
  functions.define<"spring_forces">(R"(
The generalized forces of springs, dampers and stops, (nv,) or (N, nv), N m for angles and N for lengths. O(n).

They act in `simulate` and `rollout`. `forward_dynamics` and the other functions leave them out, unless you add these
forces to tau.

>>> drawing = arm.to_dict()
>>> drawing["body"][1]["joint"]["spring"] = {"stiffness": 100.0, "rest": 0.2}
>>> float(axode.spring_forces(axode.Model.from_dict(drawing), np.zeros(7), np.zeros(7))[0])
20.0
)");
  functions.define<"elastic_energy">(R"(
The energy of springs and stops, J: a number, or (N,). At rest, its gradient is -`spring_forces`. O(n).

>>> float(axode.elastic_energy(arm, np.ones(7)))
0.0
)");
  module.def("spring_coordinate", &spring_coordinate_of, "m"_a, "q"_a, "spring"_a, nb::kw_only(),
             "threads"_a = 1,
             nb::sig("def spring_coordinate(m: Model, q: numpy.typing.ArrayLike, spring: str | int, *, "
                     "threads: int = 1) -> axode.records.SpringCoordinate"),
             R"(
(coordinate, gradient): the length or angle x of a spring, m or rad, a number or (N,), and dx/dq, (nv,) or (N, nv).

`spring` is the name of a spring of the drawing that is not that of a joint, or its number. The entries of the gradient are
the moment arms of its force with the opposite sign: a tension F has the generalized forces -F dx/dq (eq. (D16.1)).
KeyError for an unknown name; ValueError for a bushing, which has no coordinate. O(depth) for each segment.

>>> drawing = arm.to_dict() | {"spring": [{"name": "wire", "between": ["ground", "flange"], "stiffness": 50.0}]}
>>> wired = axode.Model.from_dict(drawing)
>>> x, gradient = axode.spring_coordinate(wired, np.full(7, 0.3), "wire")
>>> tension = -gradient * 50.0 * x  # its force, because its rest length is 0
>>> bool(np.allclose(tension, axode.spring_forces(wired, np.full(7, 0.3), np.zeros(7))))
True
)");
  module.def(
      "load_powers",
      [f = StateFunction("load_powers")](const BoundModel& m, ArrayLike q, ArrayLike v, LoadList loads,
                                         int threads) {
        return f(m, {.q = q, .v = v, .loads = loads, .threads = threads});
      },
      "m"_a, "q"_a, "v"_a, "loads"_a, nb::kw_only(), "threads"_a = 1,
      documented("load_powers", R"(
The power of every load, W: shape (number of loads,) or (N, number of loads). O(n).

>>> push = [{"frame": "flange", "representation": "hybrid", "wrench": [0, 0, 0, 10, 0, 0]}]
>>> axode.load_powers(arm, arm.neutral(), np.zeros(7), push)
array([0.])
)")
          .c_str());
  functions.define<"centroidal_inertia">(R"(
The inertia matrix of the whole mechanism about its center of mass, in inertial axes, as if the joints were locked.

Shape (6, 6) or (N, 6, 6). Armatures are not part of it. O(n).

>>> M = axode.centroidal_inertia(arm, arm.neutral())
>>> bool(np.isclose(M[5, 5], arm.total_mass))
True
)");
}

void add_operational_space(nb::module_& module) {
  const StateFunctions functions(module);
  module.def(
      "impulse_response",
      [f = StateFunction("impulse_response")](const BoundModel& m, ArrayLike q, FrameName frame,
                                              Representation representation, ArrayLike offset, int threads) {
        return f.in_rows(
            m, {.q = q, .algorithm = {representation}, .place = place(m, frame, offset), .threads = threads});
      },
      "m"_a, "q"_a, "frame"_a, "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(),
      "threads"_a = 1,
      documented("impulse_response", R"(
M^-1 J^T of a frame, (nv, 6) or (N, nv, 6): the jump of the velocities under a unit of impulse on the frame. O(n).

`offset` is that of `jacobian`. SingularError if M is singular.

>>> axode.impulse_response(arm, arm.neutral(), "flange").shape
(7, 6)
)")
          .c_str());
  functions.define<"inverse_operational_space_inertia">(R"(
J M^-1 J^T of a frame, (6, 6) or (N, 6, 6): it maps an impulse on the frame to the jump of its twist. Its rank is the
number of directions in which the frame can move.

>>> np.linalg.matrix_rank(axode.inverse_operational_space_inertia(arm, np.full(7, 0.5), "flange"))
np.int64(6)
)");
  functions.define<"operational_space_inertia">(R"(
The operational-space inertia (J M^-1 J^T)^-1 of a frame, (6, 6) or (N, 6, 6): its apparent inertia against a wrench.

It is NaN if the frame cannot move, or nearly cannot, in all six directions: always if it has fewer than six axes, and
in singular configurations. In these cases `inverse_operational_space_inertia` shows how the frame can move.
SingularError if M is singular.

>>> bool(np.isfinite(axode.operational_space_inertia(arm, np.full(7, 0.5), "flange")).all())
True
)");
}

void add_regressors(nb::module_& module) {
  const StateFunctions functions(module);
  functions.define<"regressor">(R"(
The regressor Y with Y pi = M a + C v + g for the inertial parameters pi: (nv, 10 n_bodies) or (N, nv, 10 n_bodies).

`Model.parameters` has the parameters pi. Armature, losses and loads are not included. O(n d).

>>> q, v, a = np.full(7, 0.3), np.ones(7), np.ones(7)
>>> Y = axode.regressor(arm, q, v, a)
>>> np.allclose(Y @ arm.parameters, axode.inverse_dynamics(arm, q, v, a))
True
)");
  functions.define<"kinetic_energy_regressor">(R"(
The row y for which y pi is the kinetic energy of the bodies, J: (10 n_bodies,) or (N, 10 n_bodies). O(n).

>>> axode.kinetic_energy_regressor(arm, arm.neutral(), np.ones(7)).shape
(70,)
)");
  functions.define<"potential_energy_regressor">(R"(
The row y for which y pi is the potential energy of gravity, J: (10 n_bodies,) or (N, 10 n_bodies). O(n).

>>> axode.potential_energy_regressor(arm, arm.neutral()).shape
(70,)
)");
}

}  // namespace

void add_dynamics(nb::module_& module) {
  add_equations_of_motion(module);
  add_matrices(module);
  add_energies(module);
  add_operational_space(module);
  add_regressors(module);
}

}  // namespace axode::python
