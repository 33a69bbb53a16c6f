#include "python/bindings/constraints.hpp"

#include <nanobind/stl/string.h>

#include "axode/constraints/assembly.hpp"
#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/constrained_derivatives.hpp"
#include "axode/constraints/constrained_dynamics.hpp"
#include "axode/constraints/independent/independent_equations.hpp"
#include "axode/constraints/independent/independent_linearization.hpp"
#include "axode/constraints/mobility.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/raise.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {

std::vector<int> velocities(const Model& m, nb::handle given, const char* argument) {
  std::vector<int> found;
  if (given.is_none()) return found;
  const auto wrong = [&](const std::string& what) {
    throw nb::value_error((std::string(argument) + " holds " + what +
                           "; expected names of joints or numbers of velocities, 0 to " +
                           std::to_string(m.nv() - 1))
                              .c_str());
  };
  if (nb::isinstance<nb::str>(given)) wrong("one text, not a sequence");
  for (const nb::handle one : nb::iter(given)) {
    if (nb::isinstance<nb::str>(one)) {
      const Joint& joint = m.joint(m.joint_index(text_of(one)));
      if (joint.leader) wrong("joint \"" + joint.name + "\", which follows another one");
      for (int k = 0; k < joint.nv; ++k) found.push_back(joint.iv + k);
    } else {
      int c = -1;
      if (!nb::try_cast(one, c) || c < 0 || c >= m.nv()) wrong(shown(one));
      found.push_back(c);
    }
  }
  return found;
}

namespace {

using namespace nb::literals;

/// Calls f(workspace, k) for every state k of a model with loops.
template <class F> void each_closed(const States& states, const F& f) {
  states.each<LoopWorkspace<>>(loop_cost(states.model()), f);
}

/// The multipliers λ of the loops at (q, v) under the drive forces tau.
std::vector<double> multipliers(const Model& m, LoopWorkspace<>& workspace, std::span<const double> q,
                                std::span<const double> v, std::span<const double> tau,
                                const Loads<double>& loads, Solvability& found) {
  std::vector<double> a(v.size()), lambda(static_cast<std::size_t>(m.loops().rows));
  found = forward_dynamics(m, workspace, q, v, tau, a, lambda, loads);
  return lambda;
}

Array constraint_wrenches(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                          Representation representation, LoadList loads, bool joint_losses, int threads) {
  const States states(m, q, threads);
  const Items of_v = states.velocities("v", v), of_tau = states.velocities("tau", tau);
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape shape{static_cast<nb::ssize_t>(m->loops().all.size()), 6};
  NewArray out = states.result(shape);
  std::vector<Solvability> found(states.count());
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    const std::vector<double> lambda = applied.with(k, [&](const Loads<double>& now) {
      return multipliers(m, workspace, states.q(k), of_v[k], of_tau[k], now, found[k]);
    });
    with_representation(representation, [&](auto rep) {
      using Rep = decltype(rep);
      loop_wrenches<Rep>(*m, workspace, states.q(k), lambda, screws<Wrench<Rep>>(item(out, k, shape)));
    });
  });
  states.refuse(found, out);
  return out.array();
}

nb::object assembled(const BoundModel& m, ArrayLike q, nb::handle v, nb::handle hold, double tolerance,
                     int iterations) {
  const States states = one_state(m, q);
  std::optional<Items> of_v;
  if (!v.is_none()) of_v.emplace(states.velocities("v", {v.ptr()}));
  const std::vector<int> held = velocities(m, hold, "hold");
  const AssemblyResult found = states.unlocked(1000, [&](const batch::Monitor& monitor) {
    return assemble(m, states.q(0), of_v ? (*of_v)[0] : std::span<const double>(),
                    {.tolerance = tolerance, .iterations = iterations, .held = held, .monitor = [&] {
                       return monitor(0, 0);
                     }});
  });
  if (found.status != AssemblyStatus::closed)
    raise_of_assembly(to_string(*m, found), to_array(found.q), found.residual);
  return nb::make_tuple(to_array(found.q), to_array(found.v));
}

nb::list to_list(const std::vector<int>& numbers) {
  nb::list list;
  for (const int number : numbers) list.append(number);
  return list;
}

nb::object mobility_of(const BoundModel& m, ArrayLike q) {
  const States states = one_state(m, q);
  const LoopMobility found = states.released(1000, [&] { return loop_mobility(m, states.q(0)); });
  nb::list redundant;
  for (const RedundantRow& row : found.redundant)
    redundant.append(
        record("RedundantRow", row.row, to_str(row.loop), to_str(row.wrench), to_array(row.dependency)));
  return record("LoopMobility", found.degrees_of_freedom, found.rank, redundant,
                to_str(to_string(found.mobility)), to_array(found.kernel), to_list(found.indeterminate));
}

nb::object independent_equations_of(const BoundModel& m, ArrayLike q, ArrayLike v, nb::handle independent,
                                    LoadList loads, bool joint_losses) {
  const States states = one_state(m, q);
  const Items of_v = states.velocities("v", v);
  const AppliedLoads applied(states, loads, joint_losses);
  const std::vector<int> chosen = velocities(m, independent, "independent");
  const IndependentEquations found = applied.with(0, [&](const Loads<double>& now) {
    return independent_equations(m, states.q(0), of_v[0], chosen, now);
  });
  return record("IndependentEquations", to_list(found.velocities), to_array(found.M), to_array(found.h),
                to_array(found.N), to_array(found.c));
}

nb::object independent_linearization_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                        nb::handle independent, LoadList loads, bool joint_losses) {
  const States states = one_state(m, q);
  const Items of_v = states.velocities("v", v), of_tau = states.velocities("tau", tau);
  const AppliedLoads applied(states, loads, joint_losses);
  const std::vector<int> chosen = velocities(m, independent, "independent");
  const IndependentLinearization found = applied.with(0, [&](const Loads<double>& now) {
    return independent_linearization(m, states.q(0), of_v[0], of_tau[0], chosen, now);
  });
  const Shape square{static_cast<int>(found.A.rows()), static_cast<int>(found.A.rows())};
  NewArray A = states.result(square);
  as_eigen(item(A, 0, square)) = found.A.transpose().reshaped();  // arrays are stored row by row
  states.refuse({found.solvability}, A);
  return record("IndependentLinearization", to_list(found.velocities), A.array(), to_array(found.B),
                to_array(found.N), to_array(found.D));
}

Array impact_of(const BoundModel& m, ArrayLike q, ArrayLike v, double restitution, int threads) {
  const States states(m, q, threads);
  const Items of_v = states.velocities("v", v);
  const Shape shape{m->nv()};
  NewArray out = states.result(shape);
  std::vector<Solvability> found(states.count());
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    found[k] = impact(*m, workspace, states.q(k), of_v[k], restitution, item(out, k, shape));
  });
  states.refuse(found, out);
  return out.array();
}

/// An array with the results f(workspace, q, out) for every state, each an item of the given shape.
template <class F> Array of_q(const BoundModel& m, ArrayLike q, int threads, const Shape& shape, const F& f) {
  const States states(m, q, threads);
  NewArray out = states.result(shape);
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    f(workspace, states.q(k), item(out, k, shape));
  });
  return out.array();
}

}  // namespace

Array closed_inverse_dynamics(const BoundModel& m, const Arguments& given, nb::handle drives,
                              nb::handle forces) {
  const States states(m, given.q, given.threads);
  const Items v = states.velocities("v", given.v), a = states.velocities("a", given.a);
  std::optional<Items> besides;
  if (!forces.is_none()) besides.emplace(states.velocities("forces", {forces.ptr()}));
  const AppliedLoads applied(states, given.loads, given.joint_losses);
  const std::vector<int> at = velocities(m, drives, "drives");
  const Shape shape{m->nv()};
  NewArray out = states.result(shape);
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    const double left = applied.with(k, [&](const Loads<double>& now) {
      return inverse_dynamics(*m, workspace, states.q(k), v[k], a[k], item(out, k, shape), {}, at, now,
                              besides ? (*besides)[k] : std::span<const double>());
    });
    check_driven(left, "make these accelerations");
  });
  states.refuse({}, out);
  return out.array();
}

Array closed_joint_wrenches(const BoundModel& m, const Arguments& given, nb::handle drives) {
  const States states(m, given.q, given.threads);
  const Items v = states.velocities("v", given.v), a = states.velocities("a", given.a);
  const AppliedLoads applied(states, given.loads, given.joint_losses);
  const std::vector<int> at = velocities(m, drives, "drives");
  const Shape shape{m->n_bodies(), 6};
  NewArray out = states.result(shape);
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    const double missing = applied.with(k, [&](const Loads<double>& now) {
      return with_representation(*given.algorithm.representation, [&]<class Rep>(Rep) {
        return joint_wrenches<Rep>(*m, workspace, states.q(k), v[k], a[k],
                                   screws<Wrench<Rep>>(item(out, k, shape)), at, now, given.at);
      });
    });
    check_driven(missing, "make these accelerations");
  });
  states.refuse({}, out);
  return out.array();
}

namespace {

nb::object multiplier_derivatives(const BoundModel& m, ArrayLike q, ArrayLike given_v, ArrayLike given_tau,
                                  LoadList loads, bool joint_losses, int threads) {
  const States states(m, q, threads);
  const Items v = states.velocities("v", given_v), tau = states.velocities("tau", given_tau);
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape shape{m->loops().rows, m->nv()};
  NewArray by_q = states.result(shape), by_v = states.result(shape), by_tau = states.result(shape);
  std::vector<Solvability> found(states.count());
  each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
    const std::size_t entries = v[k].size() * v[k].size();
    std::vector<double> of_a(3 * entries);
    const std::span<double> a(of_a);
    found[k] = applied.with(k, [&](const Loads<double>& now) {
      return forward_dynamics_derivatives(
          *m, workspace, states.q(k), v[k], tau[k],
          {a.first(entries), a.subspan(entries, entries), a.last(entries), item(by_q, k, shape),
           item(by_v, k, shape), item(by_tau, k, shape)},
          now);
    });
  });
  for (NewArray* out : {&by_q, &by_v, &by_tau}) states.refuse(found, *out);
  return record("ForwardDynamicsDerivatives", by_q.array(), by_v.array(), by_tau.array());
}

}  // namespace

void add_constraints(nb::module_& module) {
  module.def(
      "loop_residual",
      [](const BoundModel& m, ArrayLike q, int threads) {
        return of_q(m, q, threads, {m->loops().residuals},
                    [&](auto& workspace, auto q_k, auto out) { loop_residual(*m, workspace, q_k, out); });
      },
      "m"_a, "q"_a, nb::kw_only(), "threads"_a = 1, R"(
The residuals of the loops of m, rad and m: (k,) or (N, k). They are 0 if the loops are closed, along all motions of
the loop joints.

Each loop has as many residuals as its joint takes away degrees of freedom: angles about x and y, then distances along
x, y, z of its frame on the second body. A rolling wheel or sphere has one residual, its distance from the plane.
O(n).

>>> axode.loop_residual(fourbar, fourbar.neutral()).round(12) + 0.0
array([0., 0., 0., 0., 0.])
)");
  module.def(
      "loop_jacobian",
      [](const BoundModel& m, ArrayLike q, int threads) {
        return of_q(m, q, threads, {m->loops().rows, m->nv()},
                    [&](auto& workspace, auto q_k, auto out) { loop_jacobian(*m, workspace, q_k, out); });
      },
      "m"_a, "q"_a, nb::kw_only(), "threads"_a = 1, R"(
The matrix A(q) with A v = 0 for the velocities that the loops allow: (rows, nv) or (N, rows, nv). O(n + rows *
depth).

A row is the power of one wrench of a loop on the twist of the second body relative to the first.

>>> axode.loop_jacobian(fourbar, fourbar.neutral()).shape
(5, 3)
)");
  module.def(
      "loop_residual_jacobian",
      [](const BoundModel& m, ArrayLike q, int threads) {
        return of_q(m, q, threads, {m->loops().residuals, m->nv()}, [&](auto& workspace, auto q_k, auto out) {
          loop_residual_jacobian(*m, workspace, q_k, out);
        });
      },
      "m"_a, "q"_a, nb::kw_only(), "threads"_a = 1, R"(
The derivative R(q) of `loop_residual` along velocities, whether the loops are closed or not: (k, nv) or (N, k, nv).
O(n + k * depth).

If the loops are closed, it consists of the rows of `loop_jacobian` that have a residual; tangential rows of rolling
contacts have none.

>>> q = np.array([0.3, 0.1, 0.2])
>>> ahead, back = (axode.loop_residual(fourbar, q + h * np.eye(3)[0]) for h in (1e-6, -1e-6))
>>> bool(np.allclose(axode.loop_residual_jacobian(fourbar, q)[:, 0], (ahead - back) / 2e-6))
True
)");
  module.def(
      "loop_hessian_product",
      [](const BoundModel& m, ArrayLike q, ArrayLike multipliers, ArrayLike w, int threads) {
        const States states(m, q, threads);
        const Items of_lambda = states.items("multipliers", multipliers, {m->loops().residuals},
                                             "a number for each residual"),
                    of_w = states.velocities("w", w);
        const Shape shape{m->nv()};
        NewArray out = states.result(shape);
        each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
          loop_hessian_product(*m, workspace, states.q(k), of_lambda[k], of_w[k], item(out, k, shape));
        });
        return out.array();
      },
      "m"_a, "q"_a, "multipliers"_a, "w"_a, nb::kw_only(), "threads"_a = 1, R"(
The rate of R(q)^T multipliers as q moves with the velocity w: (nv,) or (N, nv). O(n + k * depth).

R is `loop_residual_jacobian`, and there is a multiplier for each of its rows. If every velocity is the rate of a
coordinate, the result is the product of the Hessian of multipliers . loop_residual(q) with w.

>>> q, mu, w = np.array([0.3, 0.1, 0.2]), np.arange(5.0), np.array([1.0, -2.0, 0.5])
>>> ahead, back = (axode.loop_residual_jacobian(fourbar, q + h * w).T @ mu for h in (1e-6, -1e-6))
>>> bool(np.allclose(axode.loop_hessian_product(fourbar, q, mu, w), (ahead - back) / 2e-6))
True
)");
  module.def(
      "loop_multipliers",
      [](const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, LoadList loads, bool joint_losses,
         int threads) {
        const States states(m, q, threads);
        const Items of_v = states.velocities("v", v), of_tau = states.velocities("tau", tau);
        const AppliedLoads applied(states, loads, joint_losses);
        const Shape shape{m->loops().rows};
        NewArray out = states.result(shape);
        std::vector<Solvability> found(states.count());
        each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
          const std::vector<double> lambda = applied.with(k, [&](const Loads<double>& now) {
            return multipliers(m, workspace, states.q(k), of_v[k], of_tau[k], now, found[k]);
          });
          std::ranges::copy(lambda, item(out, k, shape).begin());
        });
        states.refuse(found, out);
        return out.array();
      },
      "m"_a, "q"_a, "v"_a, "tau"_a, "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
      "threads"_a = 1, R"(
Lagrange's multipliers of the rows of `loop_jacobian` in M a + h - A^T lambda = tau: (rows,) or (N, rows).

They are forces (N) and couples (N m) in the frames of the loops; `constraint_wrenches` gives them in any
representation. If rows are redundant, the multipliers are the least possible ones.

>>> q, nothing = fourbar.neutral(), np.zeros(3)
>>> reaction = axode.loop_jacobian(fourbar, q).T @ axode.loop_multipliers(fourbar, q, nothing, nothing)
>>> a = axode.forward_dynamics(fourbar, q, nothing, nothing)
>>> bool(np.allclose(axode.mass_matrix(fourbar, q) @ a + axode.gravity_torques(fourbar, q), reaction))
True
)");
  module.def(
      "loop_multiplier_derivatives", &multiplier_derivatives, "m"_a, "q"_a, "v"_a, "tau"_a,
      "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1,
      nb::sig("def loop_multiplier_derivatives(m: Model, q: numpy.typing.ArrayLike, v: "
              "numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike, loads: typing.Any = None, *, "
              "joint_losses: bool = False, threads: int = 1) -> axode.records.ForwardDynamicsDerivatives"),
      R"(
Derivatives of the multipliers of loops by configuration, velocities and forces, each (rows, nv) or (N, rows, nv).

A row that depends on the rows before it gets the multiplier 0, and its derivatives are 0 as well.

>>> d = axode.loop_multiplier_derivatives(fourbar, fourbar.neutral(), np.zeros(3), np.zeros(3))
>>> d.tau.shape
(5, 3)
)");
  module.def(
      "loop_bias",
      [](const BoundModel& m, ArrayLike q, ArrayLike v, int threads) {
        const States states(m, q, threads);
        const Items of_v = states.velocities("v", v);
        const Shape shape{m->loops().rows};
        NewArray out = states.result(shape);
        each_closed(states, [&](LoopWorkspace<>& workspace, std::size_t k) {
          loop_bias(*m, workspace, states.q(k), of_v[k], item(out, k, shape));
        });
        return out.array();
      },
      "m"_a, "q"_a, "v"_a, nb::kw_only(), "threads"_a = 1, R"(
The vector gamma(q, v) of (A v)' = A a + gamma: (rows,) or (N, rows). O(n).

>>> axode.loop_bias(fourbar, fourbar.neutral(), np.zeros(3)).any()
np.False_
)");
  module.def(
      "assemble", &assembled, "m"_a, "q"_a, "v"_a = nb::none(), nb::kw_only(), "hold"_a = nb::none(),
      "tolerance"_a = 1e-12, "iterations"_a = 200,
      nb::sig(
          "def assemble(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike | None = None, *, "
          "hold: collections.abc.Iterable[str | int] | None = None, tolerance: float = 1e-12, iterations: "
          "int = 200) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]"),
      R"(
(q, v): a configuration near a guess with the loops of m closed, and velocities that keep them closed (0 if no v is
given).

The method is that of Levenberg and Marquardt on the group of configurations. The velocities are those after an impact
that closes the loops. `hold` names joints, or numbers of velocities, that do not move. AssemblyError says which loop
remains open and by how much, and whether the guess is singular, as a stretched mechanism is; from another guess the
loops may close. `tolerance` is relative to the size of the mechanism; a residual that stops decreasing at the
rounding of its terms counts as closed.

>>> q, v = axode.assemble(fourbar, [0.3, 0.0, 0.0], [1.0, 0.0, 0.0], hold=["crank_joint"])
>>> q[0], bool(np.abs(axode.loop_residual(fourbar, q)).max() < 1e-11)
(np.float64(0.3), True)
)");
  module.def("loop_mobility", &mobility_of, "m"_a, "q"_a,
             nb::sig("def loop_mobility(m: Model, q: numpy.typing.ArrayLike) -> axode.records.LoopMobility"),
             R"(
Degrees of freedom, rank and redundant rows of the loops at a closed q (nq,), see `LoopMobility`.

>>> found = axode.loop_mobility(fourbar, fourbar.neutral())
>>> found.degrees_of_freedom, found.rank, [row.wrench.split(" through")[0] for row in found.redundant]
(1, 2, ['couple about (1, 0, 0)', 'couple about (0, 1, 0)', 'force along (0, 0, 1)'])
)");
  module.def(
      "independent_equations", &independent_equations_of, "m"_a, "q"_a, "v"_a, "independent"_a = nb::none(),
      "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
      nb::sig("def independent_equations(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "independent: collections.abc.Iterable[str | int] | None = None, loads: typing.Any = None, *, "
              "joint_losses: bool = False) -> axode.records.IndependentEquations"),
      R"(
Mass matrix and forces of a mechanism with loops in independent velocities, see `IndependentEquations`.

The loops must be closed at q and stay closed with v. `independent` names joints, or numbers of velocities, as many as
there are degrees of freedom; if it is left out, the velocities that determine the others best are chosen. ValueError
if they do not determine the others at q.

>>> q, v = axode.assemble(fourbar, [0.3, 0.0, 0.0], [1.0, 0.0, 0.0], hold=["crank_joint"])
>>> crank = axode.independent_equations(fourbar, q, v, ["crank_joint"])
>>> crank.M.shape, bool(np.allclose(crank.N @ v[:1], v))
((1, 1), True)
)");
  module.def(
      "independent_linearization", &independent_linearization_of, "m"_a, "q"_a, "v"_a, "tau"_a,
      "independent"_a = nb::none(), "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
      nb::sig("def independent_linearization(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "tau: numpy.typing.ArrayLike, independent: collections.abc.Iterable[str | int] | None = None, "
              "loads: typing.Any = None, *, joint_losses: bool = False) -> "
              "axode.records.IndependentLinearization"),
      R"(
The linear system of small motions of a mechanism with loops in k independent velocities, see
`IndependentLinearization`.

`linearize` does the same for a tree. q, v and `independent` are those of `independent_equations`. Springs, dampers
and stops of the model act. At an equilibrium the eigenvalues of A are those of the small oscillations, whichever
velocities are chosen. SingularError if the mass matrix is singular. ValueError for a mechanism with drives that have
states.

>>> rods = axode.load(axode.robots / "bricard.toml")
>>> q, still = axode.equilibrium(rods, rods.neutral()).q, np.zeros(rods.nv)
>>> small = axode.independent_linearization(rods, q, still, still)
>>> np.abs(np.linalg.eigvals(small.A)).round(3)  # the one frequency that it has, rad/s
array([1.241, 1.241])
)");
  module.def("impact", &impact_of, "m"_a, "q"_a, "v"_a, "restitution"_a = 0.0, nb::kw_only(), "threads"_a = 1,
             R"(
The velocities v+ after an impact that closes the loops, A v+ = -restitution A v: (nv,) or (N, nv). Of all such velocities they are the nearest to v in the norm of the kinetic energy.

>>> v = axode.impact(fourbar, fourbar.neutral(), [1.0, 0.0, 0.0])
>>> (axode.loop_jacobian(fourbar, fourbar.neutral()) @ v).round(12) + 0.0
array([0., 0., 0., 0., 0.])
)");
  module.def("constraint_wrenches", &constraint_wrenches, "m"_a, "q"_a, "v"_a, "tau"_a,
             "representation"_a = "body", "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
             "threads"_a = 1, R"(
The wrenches of the loops on their second bodies under the drive forces tau: (n_loops, 6) or (N, n_loops, 6).

They are in a representation of the frame of the second body, moment (N m) before force (N). If rows are redundant,
the wrenches are those of the least multipliers. Couplings exert forces on joints; their wrenches are 0.

>>> W = axode.constraint_wrenches(fourbar, fourbar.neutral(), np.zeros(3), np.zeros(3), "spatial")
>>> W.shape
(1, 6)
)");
}

}  // namespace axode::python
