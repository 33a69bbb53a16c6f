#include "axode/derivatives/rates.hpp"

#include "axode/constraints/check_loops.hpp"
#include "axode/constraints/higher_order/constrained_rates.hpp"
#include "axode/constraints/higher_order/inverse_kinematics_rates.hpp"
#include "python/bindings/constraints.hpp"
#include "python/bindings/states/state_function.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"

/// Time derivatives of any order: of joint velocities, given those of a twist, and of drive forces.
namespace axode::python {

using namespace nb::literals;

namespace {

/// Several states q, v with time derivatives of v, each of which is an argument of its own in Python.
struct MotionInTime {
  MotionInTime(const States& of, std::initializer_list<Named> first, nb::args more) : states(of) {
    for (const Named& rate : first) rates.push_back(states.velocities(rate.name, rate.given));
    for (std::size_t k = 0; k < more.size(); ++k) {
      const nb::object given = more[k];
      const std::string name = "derivative " + std::to_string(k + 1) + " of a";
      rates.push_back(states.velocities(name.c_str(), {given.ptr()}));
    }
  }
  /// The velocities v and their derivatives v', v'', ... of state k, one after the other.
  std::vector<double> operator[](std::size_t k) const {
    std::vector<double> rows;
    for (const Items& rate : rates) rows.insert(rows.end(), rate[k].begin(), rate[k].end());
    return rows;
  }
  /// The number of results: the forces and their time derivatives that follow from the given rates.
  int orders() const { return static_cast<int>(rates.size()) - 1; }

  const States& states;
  std::vector<Items> rates;
};

/// A tuple with one array for each row k of the results; the array has the row k of every state.
nb::object in_parts(const NewArray& out, int parts) {
  nb::list all;
  for (int k = 0; k < parts; ++k) all.append(nb::cast(out.part(k, 1)));
  return nb::tuple(all);
}

nb::object inverse_dynamics_rates_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                                     nb::args more, LoadList loads, bool joint_losses, nb::handle drives,
                                     int threads) {
  const States states(m, q, threads);
  const MotionInTime motion(states, {{"v", v}, {"a", a}}, more);
  const AppliedLoads applied(states, loads, joint_losses);
  const int orders = motion.orders();
  const Shape shape{orders, m->nv()};
  if (m->loops().empty() && drives.is_none()) {
    return in_parts(
        each_item(states, orders * orders * linear_cost(*m), shape,
                  [&](Workspace<>&, std::size_t k, std::span<double> tau) {
                    applied.with(k, [&](const Loads<double>& now) {
                      InverseDynamicsRates<>(*m, orders - 1).evaluate(states.q(k), motion[k], tau, now);
                    });
                  }),
        orders);
  }
  const std::vector<int> at = velocities(m, drives, "drives");
  NewArray out = states.result(shape);
  states.each<LoopWorkspace<>>(orders * loop_cost(*m), [&](LoopWorkspace<>& workspace, std::size_t k) {
    const double missing = applied.with(k, [&](const Loads<double>& now) {
      return inverse_dynamics_rates(*m, workspace, states.q(k), motion[k], item(out, k, shape), at, now);
    });
    check_driven(missing, "make this motion");
  });
  states.refuse({}, out);
  return in_parts(out, orders);
}

nb::object second_order_inverse_dynamics_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike a,
                                            ArrayLike jerk, ArrayLike snap, LoadList loads, bool joint_losses,
                                            Representation representation, int threads) {
  const States states(m, q, threads);
  const MotionInTime motion(states, {{"v", v}, {"a", a}, {"jerk", jerk}, {"snap", snap}}, {});
  const AppliedLoads applied(states, loads, joint_losses);
  return with_representation(representation, [&]<class Rep>(Rep) {
    return in_parts(each_item(states, 4 * linear_cost(*m), {3, m->nv()},
                              [&](Workspace<>& workspace, std::size_t k, std::span<double> tau) {
                                applied.with(k, [&](const Loads<double>& now) {
                                  second_order_inverse_dynamics<Rep, double>(*m, workspace, states.q(k),
                                                                             motion[k], tau, now);
                                });
                              }),
                    3);
  });
}

Array forward_dynamics_rates_of(const BoundModel& m, ArrayLike q, ArrayLike given_v, ArrayLike given_forces,
                                LoadList loads, bool joint_losses, int threads) {
  const States states(m, q, threads);
  const Items v = states.velocities("v", given_v);
  const Rows forces(states, "forces", given_forces, "rows of nv numbers: tau, tau', tau'', ...");
  const AppliedLoads applied(states, loads, joint_losses);
  const int orders = forces.count();
  return each_item(states, orders * quadratic_cost(*m), {orders, m->nv()},
                   [&](Workspace<>& workspace, std::size_t k, std::span<double> rates) {
                     return applied.with(k, [&](const Loads<double>& now) {
                       return forward_dynamics_rates<double>(*m, workspace, states.q(k), v[k], forces[k],
                                                             rates, now);
                     });
                   })
      .array();
}

Array inverse_kinematics_rates_of(const BoundModel& m, ArrayLike q, ArrayLike V, FrameName frame,
                                  Representation representation, ArrayLike offset, bool angular, bool linear,
                                  int threads) {
  const States states(m, q, threads);
  const Numbers given("V", V);
  if (given.axes() < 2 || given.length(given.axes() - 2) == 0 || given.length(given.axes() - 1) != 6)
    given.wrong_shape("(K, 6) or (N, K, 6), the twist and its derivatives");
  const nb::ssize_t orders = given.length(given.axes() - 2);
  const Items twists = states.items("V", V, {orders, 6}, "the twist and its derivatives");
  const Place<> at = place(m, frame, offset);
  return with_representation(representation, [&]<class Rep>(Rep) {
    return each_item(states, static_cast<double>(orders) * cubic_cost(*m), {orders, m->nv()},
                     [&](Workspace<>&, std::size_t k, std::span<double> rates) {
                       const std::span<const double> rows = twists[k];
                       std::vector<TwistRate<Rep>> wanted;
                       for (const double* x = rows.data(); x != rows.data() + rows.size(); x += 6)
                         wanted.push_back({vector_from(x), vector_from(x + 3)});
                       const TwistTarget<Rep> target{at, wanted, angular, linear};
                       const RatesReached reached =
                           inverse_kinematics_rates<Rep>(*m, states.q(k), std::span(&target, 1), rates);
                       if (reached.orders < orders)
                         throw std::invalid_argument(
                             "the joints cannot produce row " + std::to_string(reached.orders) +
                             " of V: " + to_text(reached.missing) +
                             " of it (by norm) is in directions in which they do not move the frame");
                     })
        .array();
  });
}

}  // namespace

void add_rates(nb::module_& module) {
  module.def(
      "inverse_dynamics_rates", &inverse_dynamics_rates_of, "m"_a, "q"_a, "v"_a, "a"_a, "more"_a,
      "loads"_a = nb::none(), "joint_losses"_a = false, "drives"_a = nb::none(), "threads"_a = 1,
      nb::sig("def inverse_dynamics_rates(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "a: numpy.typing.ArrayLike, *more: numpy.typing.ArrayLike, "
              "loads: collections.abc.Sequence[axode.Load] | None = None, joint_losses: bool = False, "
              "drives: collections.abc.Sequence[str | int] | None = None, "
              "threads: int = 1) -> tuple[numpy.typing.NDArray[numpy.float64], ...]"),
      R"(
(tau, tau', tau'', ...): the drive forces of a motion and their time derivatives, (nv,) or (N, nv) each.

`more` are jerk, snap, ..., the derivatives of a; each gives one more result. Loads are constant in the representation in
which they are given. O(n k^2) for k results. Loops are counted, with `drives` as in `inverse_dynamics`;
`inverse_kinematics_rates` finds motions that keep them closed.

>>> q, v, a, jerk = np.full(7, 0.3), np.ones(7), np.zeros(7), np.ones(7)
>>> tau, rate = axode.inverse_dynamics_rates(arm, q, v, a, jerk)
>>> d = axode.inverse_dynamics_derivatives(arm, q, v, a)
>>> np.allclose(rate, d.q @ v + d.v @ a + d.a @ jerk)
True
)");
  module.def(
      "second_order_inverse_dynamics", &second_order_inverse_dynamics_of, "m"_a, "q"_a, "v"_a, "a"_a,
      "jerk"_a, "snap"_a, "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false,
      "representation"_a = "body", "threads"_a = 1,
      nb::sig("def second_order_inverse_dynamics(m: Model, q: numpy.typing.ArrayLike, "
              "v: numpy.typing.ArrayLike, a: numpy.typing.ArrayLike, jerk: numpy.typing.ArrayLike, "
              "snap: numpy.typing.ArrayLike, loads: collections.abc.Sequence[axode.Load] | None = None, *, "
              "joint_losses: bool = False, "
              "representation: typing.Literal['body', 'spatial', 'hybrid', 'mixed'] = 'body', "
              "threads: int = 1) -> tuple[numpy.typing.NDArray[numpy.float64], ...]"),
      R"(
(tau, tau', tau''), as `inverse_dynamics_rates` gives them, by Newton-Euler recursions that are differentiated twice.

The recursion is that of a `representation`; the results are equal. O(n).

>>> motion = np.full(7, 0.3), np.ones(7), np.zeros(7), np.ones(7), np.zeros(7)
>>> np.allclose(axode.second_order_inverse_dynamics(arm, *motion), axode.inverse_dynamics_rates(arm, *motion))
True
)");
  module.def(
      "forward_dynamics_rates", &forward_dynamics_rates_of, "m"_a, "q"_a, "v"_a, "forces"_a,
      "loads"_a = nb::none(), nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1,
      nb::sig("def forward_dynamics_rates(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "forces: numpy.typing.ArrayLike, loads: collections.abc.Sequence[axode.Load] | None = None, *, "
              "joint_losses: bool = False, threads: int = 1) -> numpy.typing.NDArray[numpy.float64]"),
      R"(
The accelerations and their time derivatives a, a', ... that drive forces tau, tau', ... make: (K, nv) to (K, nv).

The inverse of `inverse_dynamics_rates`. `forces` may be (N, K, nv), for N states. O(n K^3). Loops are refused.

>>> q, v, a, jerk = np.full(7, 0.3), np.ones(7), np.zeros(7), np.ones(7)
>>> forces = axode.inverse_dynamics_rates(arm, q, v, a, jerk)
>>> np.allclose(axode.forward_dynamics_rates(arm, q, v, forces), [a, jerk])
True
)");
  module.def("inverse_kinematics_rates", &inverse_kinematics_rates_of, "m"_a, "q"_a, "V"_a, "frame"_a,
             "representation"_a = "body", nb::kw_only(), "offset"_a = nb::none(), "angular"_a = true,
             "linear"_a = true, "threads"_a = 1, R"(
The velocities and their time derivatives v, v', v'', ... for which a frame has the twist V and its derivatives V', V'', ....

V is (K, 6) or (N, K, 6), the twist in a representation and the derivatives of its components, as `twist_derivatives`
gives them; the result is (K, nv) or (N, K, nv). `angular` or `linear` is False if that part of V does not matter. Of
several solutions each row is the one of least norm. Loops are counted. ValueError if the joints cannot make this motion.

>>> rates = np.random.default_rng(0).normal(size=(5, 7))
>>> V = axode.twist_derivatives(arm, np.full(7, 0.3), rates, "flange")
>>> found = axode.inverse_kinematics_rates(arm, np.full(7, 0.3), V, "flange")
>>> np.allclose(axode.twist_derivatives(arm, np.full(7, 0.3), found, "flange"), V)
True
)");
}

}  // namespace axode::python
