#include "axode/constraints/embedding/task_space.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <mutex>

#include "axode/constraints/embedding/platform_placement.hpp"
#include "axode/constraints/embedding/task_rates.hpp"
#include "axode/constraints/embedding/task_singularities.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/raise.hpp"

/// Parallel manipulators in their task space.
namespace axode::python {

using namespace nb::literals;

namespace {

/// A task space that Python holds. It has as many TaskSpace objects as threads have used it at the same time.
class BoundTaskSpace {
 public:
  BoundTaskSpace(const BoundModel& m, const States& at, std::string platform)
      : model_(*m), q_(at.q().begin(), at.q().end()), platform_(std::move(platform)) {
    idle_.push_back(make());
  }

  const BoundModel& model() const { return model_; }
  /// Returns a TaskSpace that no other thread uses until the returned pointer is destroyed.
  std::shared_ptr<TaskSpace> take() {
    std::unique_ptr<TaskSpace> space;
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        space = std::move(idle_.back());
        idle_.pop_back();
      }
    }
    if (!space) space = make();
    return {space.release(), [this](TaskSpace* used) {
              const std::lock_guard lock(mutex_);
              idle_.emplace_back(used);
            }};
  }
  int freedom() { return take()->freedom(); }

  /// Calls f(space, k) for every state k, with a TaskSpace `space` that no other thread uses, and returns
  /// `result`, to which f writes. If f returned a failure of a state, throws SingularError or NotFiniteError,
  /// which contain the result.
  template <class F> Array each(const States& states, NewArray result, const F& f) {
    std::vector<TaskVerdict> found(states.count());
    states.unlocked(cost(), [&](const batch::Monitor& monitor) {
      return batch::in_portions(states.count(), 1, states.threads(), monitor, [&]() -> batch::Work {
        return [&, space = take()](std::size_t k, std::size_t) {
          states.run(k, [&] { found[k] = f(*space, k); });
        };
      });
    });
    refuse(states, found, result);
    return result.array();
  }
  void refuse(const States& states, const std::vector<TaskVerdict>& found, NewArray& result) {
    std::vector<std::size_t> refused;
    for (std::size_t k = 0; k < found.size(); ++k)
      if (!found[k].ok()) refused.push_back(k);
    if (refused.empty()) return;
    const TaskVerdict& first = found[refused.front()];
    states.raise(first.kind == TaskVerdict::Kind::not_finite ? "NotFiniteError" : "SingularError",
                 to_string(*take(), first), refused, result);
  }
  double cost() const { return 0.3 * model_->nv(); }  // in µs

 private:
  std::unique_ptr<TaskSpace> make() const { return std::make_unique<TaskSpace>(*model_, q_, platform_); }

  BoundModel model_;
  std::vector<double> q_;
  std::string platform_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<TaskSpace>> idle_;
};

/// An argument that has a number for each task velocity of every state.
Items of_task(BoundTaskSpace& space, const States& states, const char* name, ArrayLike given) {
  return states.items(name, given, {space.freedom()}, "a number for each task velocity");
}

Array velocities_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given, int threads) {
  const States states(space.model(), q, threads);
  const Items V = of_task(space, states, "V", given);
  const Shape shape{states.model().nv()};
  NewArray v = states.result(shape);
  return space.each(states, v, [&](TaskSpace& on, std::size_t k) {
    return on.velocities(states.q(k), V[k], item(v, k, shape));
  });
}

Array accelerations_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given_v, ArrayLike given_dV,
                       int threads) {
  const States states(space.model(), q, threads);
  const Items v = states.velocities("v", given_v), dV = of_task(space, states, "dV", given_dV);
  const Shape shape{states.model().nv()};
  NewArray a = states.result(shape);
  return space.each(states, a, [&](TaskSpace& on, std::size_t k) {
    return on.accelerations(states.q(k), v[k], dV[k], item(a, k, shape));
  });
}

Array inverse_dynamics_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given_v, ArrayLike given_dV,
                          LoadList loads, bool joint_losses, int threads) {
  const States states(space.model(), q, threads);
  const Items v = states.velocities("v", given_v), dV = of_task(space, states, "dV", given_dV);
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape shape{states.model().nv()};
  NewArray tau = states.result(shape);
  return space.each(states, tau, [&](TaskSpace& on, std::size_t k) {
    return applied.with(k, [&](const Loads<double>& now) {
      return on.inverse_dynamics(states.q(k), v[k], dV[k], item(tau, k, shape), now);
    });
  });
}

Array forward_dynamics_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given_v, ArrayLike given_tau,
                          LoadList loads, bool joint_losses, int threads) {
  const States states(space.model(), q, threads);
  const Items v = states.velocities("v", given_v), tau = states.velocities("tau", given_tau);
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape shape{space.freedom()};
  NewArray dV = states.result(shape);
  return space.each(states, dV, [&](TaskSpace& on, std::size_t k) {
    return applied.with(k, [&](const Loads<double>& now) {
      return on.forward_dynamics(states.q(k), v[k], tau[k], item(dV, k, shape), {}, now);
    });
  });
}

nb::object equations_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given_v, LoadList loads,
                        bool joint_losses) {
  const States states = one_state(space.model(), q);
  const Items v = states.velocities("v", given_v);
  const AppliedLoads applied(states, loads, joint_losses);
  const TaskEquations found = applied.with(
      0, [&](const Loads<double>& now) { return space.take()->equations(states.q(0), v[0], now); });
  NewArray M = states.result({space.freedom(), space.freedom()});
  std::ranges::fill(M.all(), std::numeric_limits<double>::quiet_NaN());
  space.refuse(states, {found.verdict}, M);
  return record("TaskEquations", to_array(found.M), to_array(found.h), to_array(found.J), found.drives,
                to_array(found.F), to_array(found.c));
}

std::tuple<Array, Array> rates_of(BoundTaskSpace& space, ArrayLike q, ArrayLike given, LoadList loads,
                                  bool joint_losses, int threads) {
  const States states(space.model(), q, threads);
  const nb::ssize_t f = space.freedom(), nv = states.model().nv();
  const Numbers numbers("rates", given);
  const int axis = states.many() ? 1 : 0;  // the axis of the derivatives
  if (numbers.axes() != axis + 2 || numbers.length(axis) < 2)
    numbers.wrong_shape(std::string(states.many() ? "(N, K + 1, " : "(K + 1, ") + std::to_string(f) +
                        "), rows V, V', ... of the task velocities and K derivatives, at least one");
  const nb::ssize_t K = numbers.length(axis) - 1;
  const Items rates = states.items("rates", given, {K + 1, f}, "rows of the task velocities");
  const AppliedLoads applied(states, loads, joint_losses);
  const Shape of_forces{K, nv}, of_motion{K + 1, nv};
  NewArray tau = states.result(of_forces), motion = states.result(of_motion);
  Array forces = space.each(states, tau, [&](TaskSpace& on, std::size_t k) {
    return applied.with(k, [&](const Loads<double>& now) {
      return inverse_dynamics_rates(on, states.q(k), rates[k], item(tau, k, of_forces),
                                    item(motion, k, of_motion), now);
    });
  });
  return {forces, motion.array()};
}

Array place_platform_of(BoundTaskSpace& space, ArrayLike given, ArrayLike q) {
  const States states = one_state(space.model(), q);
  const Numbers C("C", given);
  if (C.axes() != 2 || !C.ends_with({4, 4})) C.wrong_shape("(4, 4), a pose");
  NewArray placed = states.result({states.model().nq()});
  std::ranges::copy(states.q(0), placed.all().begin());
  const std::shared_ptr<TaskSpace> on = space.take();
  const PlatformPlacement found = place_platform(*on, pose_from("C", C.data()), placed.all());
  if (!found.reached) raise_of_assembly(to_string(*on, found), placed.array(), found.residual);
  return placed.array();
}

nb::list singularities_of(BoundTaskSpace& space, ArrayLike q, double within) {
  const States states = one_state(space.model(), q);
  nb::list all;
  for (const TaskSingularity& found : singularities(*space.take(), states.q(0), within)) {
    constexpr std::array types{"limb", "drives", "constraint"};
    NewArray twist(Shape{6});
    write_screw(found.twist, twist.data());
    nb::list joints;
    for (const std::string& name : found.joints) joints.append(to_str(name));
    all.append(record("TaskSingularity", types[static_cast<std::size_t>(found.type)],
                      found.limb < 0 ? nb::object(nb::none()) : nb::object(nb::int_(found.limb)),
                      found.distance, twist.array(), joints, to_str(found.sentence)));
  }
  return all;
}

std::vector<std::vector<int>> limbs_of(BoundTaskSpace& space) {
  const std::shared_ptr<TaskSpace> on = space.take();
  std::vector<std::vector<int>> all;
  for (int l = 0; l < on->limbs(); ++l) all.push_back(on->limb(l));
  return all;
}

nb::object platform_of(BoundTaskSpace& space) {
  const int body = space.take()->platform();
  if (body == 0) return nb::none();
  return to_str(space.model()->body(body).name);
}

}  // namespace

void add_task_space(nb::module_& module) {
  nb::class_<BoundTaskSpace>(module, "TaskSpace", R"(
A parallel manipulator in its task space: a platform that is carried by limbs, each of which is resolved by itself.

The task velocities V (freedom,) are components of the body-fixed twist of the platform (rad/s, m/s), as many as it has
freedoms, followed by joint velocities that the platform does not determine: those of a rod that spins between two balls,
or of an arm on the platform. Without a platform all of them are joint velocities; `names` says what they are.

TaskSpace(m, q, platform) determines the limbs and their mobility at a configuration q (nq,) with closed loops, which should
not be singular. `platform` names a body whose joint is on the ground; if it is left out, it is the body for which
eliminations cost least. ValueError for open loops, a body that another one carries, a mechanism without loops, prescribed
motions, and ranks that rounding leaves open; KeyError for an unknown body.

Methods take one state or N states, whose loops are closed and stay closed with v, as `place_platform` and `velocities`
compute them; N states may run on `threads` threads. They cost O(limbs) for limbs of bounded size. Springs act only if
`spring_forces` are added to tau. SingularError says what is singular: the joints of a limb (type 1), the drives (type 2),
the constraints of the platform, or the mass matrix; `singularities` has more. The equations are derived in
docs/derivations/constraint-embedding.md.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> space
TaskSpace of "platform" with 6 limbs: platform.omega_x, platform.omega_y, platform.omega_z, platform.v_x, platform.v_y, platform.v_z
)")
      .def(
          "__init__",
          [](BoundTaskSpace* self, const BoundModel& m, ArrayLike q, std::optional<std::string> platform) {
            new (self) BoundTaskSpace(m, one_state(m, q), platform.value_or(""));
          },
          "m"_a, "q"_a, "platform"_a = nb::none())
      .def_prop_ro("platform", &platform_of, nb::sig("def platform(self) -> str | None"),
                   "The name of the platform, or None.")
      .def_prop_ro("freedom", &BoundTaskSpace::freedom, "The number of task velocities.")
      .def_prop_ro(
          "names", [](BoundTaskSpace& space) { return space.take()->names(); },
          "The names of the task velocities: \"platform.omega_x\" to \"platform.v_z\", or those of joint "
          "velocities.")
      .def_prop_ro("limbs", &limbs_of,
                   "The indices of the velocities of each limb. The last limb has no loops if joints move "
                   "independently.")
      .def("velocities", &velocities_of, "q"_a, "V"_a, nb::kw_only(), "threads"_a = 1, R"(
The velocities v = F V of all joints from task velocities V (freedom,): (nv,) or (N, nv). Eq. (D18.6).

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> v = space.velocities(gough.neutral(), [0, 0, 0.3, 0.1, 0, 0])
>>> v.shape, bool(np.abs(axode.loop_jacobian(gough, gough.neutral()) @ v).max() < 1e-9)
((24,), True)
)")
      .def("accelerations", &accelerations_of, "q"_a, "v"_a, "dV"_a, nb::kw_only(), "threads"_a = 1, R"(
The accelerations a = F dV + c of all joints from the rates dV (freedom,) of the task velocities: (nv,) or (N, nv). Eq. (D18.10).

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> v = space.velocities(gough.neutral(), [0, 0, 0.3, 0.1, 0, 0])
>>> space.accelerations(gough.neutral(), v, np.zeros(6)).shape
(24,)
)")
      .def("inverse_dynamics", &inverse_dynamics_of, "q"_a, "v"_a, "dV"_a, "loads"_a = nb::none(),
           nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1, R"(
The drive forces tau that make the rates dV (freedom,) of the task velocities: (nv,) or (N, nv), N m or N. Eq. (D18.9).

They are 0 in passive joints; if there are more drives than needed, tau is the least one. `loads` and joint_losses are those
of `axode.inverse_dynamics`.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> tau = space.inverse_dynamics(gough.neutral(), np.zeros(24), np.zeros(6))
>>> bool(np.allclose(tau, axode.inverse_dynamics(gough, gough.neutral(), np.zeros(24), np.zeros(24))))
True
)")
      .def("forward_dynamics", &forward_dynamics_of, "q"_a, "v"_a, "tau"_a, "loads"_a = nb::none(),
           nb::kw_only(), "joint_losses"_a = false, "threads"_a = 1, R"(
The rates dV of the task velocities under joint forces tau (nv,): (freedom,) or (N, freedom). Eq. (D18.11).

tau may have forces in passive joints, too. `accelerations` of dV are those of `axode.forward_dynamics`.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> dV = space.forward_dynamics(gough.neutral(), np.zeros(24), np.zeros(24))
>>> dV.shape, float(dV[5].round(1))  # it falls, drawn by its legs
((6,), -10.2)
)")
      .def("equations", &equations_of, "q"_a, "v"_a, "loads"_a = nb::none(), nb::kw_only(),
           "joint_losses"_a = false,
           nb::sig("def equations(self, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, loads: "
                   "collections.abc.Sequence[axode.Load] | None = None, *, joint_losses: bool = False) -> "
                   "axode.records.TaskEquations"),
           R"(
The matrices of the equations of motion in task velocities, of one state: M dV + h = J^T u, see `TaskEquations`.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> M, h, J, drives, F, c = space.equations(gough.neutral(), np.zeros(24))
>>> u = np.linalg.solve(J.T, h)  # they hold the platform
>>> bool(np.allclose(u, axode.inverse_dynamics(gough, gough.neutral(), np.zeros(24), np.zeros(24))[drives]))
True
)")
      .def("inverse_dynamics_rates", &rates_of, "q"_a, "rates"_a, "loads"_a = nb::none(), nb::kw_only(),
           "joint_losses"_a = false, "threads"_a = 1, R"(
(tau, motion): the drive forces and their time derivatives, and v, a, ... of all joints, from V, dV, ... in the rows of rates.

rates (K + 1, freedom) or (N, K + 1, freedom) has the task velocities and their first K derivatives, K from 1 to 7. tau has
the shape (K, nv), rows tau, tau', ...; motion (K + 1, nv) has the rows v, v', ... The drives must be as many as the freedoms.
O(K^2 nv) (eqs. (D18.13), (D18.14)).

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> tau, motion = space.inverse_dynamics_rates(gough.neutral(), np.ones((4, 6)))
>>> tau.shape, motion.shape
((3, 24), (4, 24))
)")
      .def("place_platform", &place_platform_of, "C"_a, "q"_a, R"(
Inverse kinematics: the configuration (nq,) in which the body frame of the platform has the pose C (4, 4) in the inertial frame.

Every limb closes itself by Newton's method on its own joints, beginning at q (nq,), in the assembly mode of q if the pose is
not far. Joint velocities that the platform does not determine stay as they are, and limits of coordinates are ignored.
AssemblyError, with the last q, says which limb does not reach the pose. ValueError if there is no platform.
Eq. (D18.12), O(limbs) an iteration.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space = axode.TaskSpace(gough, gough.neutral())
>>> C = axode.lie.exp([0.1, 0, 0.2, 0, 0, 0.1])
>>> q = space.place_platform(C, gough.neutral())
>>> bool(np.allclose(axode.pose(gough, q, "platform"), C)), bool(np.abs(axode.loop_residual(gough, q)).max() < 1e-9)
(True, True)
)")
      .def("singularities", &singularities_of, "q"_a, "within"_a = 1e-3,
           nb::sig("def singularities(self, q: numpy.typing.ArrayLike, within: float = 0.001) -> "
                   "list[axode.records.TaskSingularity]"),
           R"(
The singularities near a configuration q (nq,), nearer than `within` (0 to 1): a list of `TaskSingularity`.

Lengths are measured in the mean distance of the loop joints on the platform from their centre, so that distances have no
unit. A singularity of a limb and one of the drives together are of type 3. ValueError for open loops and without a platform.

>>> gough = axode.load(axode.robots / "gough.toml")
>>> space, q = axode.TaskSpace(gough, gough.neutral()), gough.neutral()
>>> for angle in 0.5, 1.0, np.pi / 2:  # Fichter's singularity
...     q = space.place_platform(axode.lie.exp([0, 0, angle, 0, 0, 0]), q)
>>> [found] = space.singularities(q)
>>> found.type, found.sentence[:64]
('drives', 'type 2: the platform can move while all drives are locked, about')
)")
      .def("__repr__", [](BoundTaskSpace& space) {
        const std::shared_ptr<TaskSpace> on = space.take();
        std::string text = "TaskSpace of ";
        text += on->platform() == 0 ? "no platform" : '"' + space.model()->body(on->platform()).name + '"';
        text += " with " + std::to_string(on->limbs()) + (on->limbs() == 1 ? " limb: " : " limbs: ");
        for (std::size_t k = 0; k < on->names().size(); ++k) text += (k > 0 ? ", " : "") + on->names()[k];
        return to_str(text);
      });
}

}  // namespace axode::python
