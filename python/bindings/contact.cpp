#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "axode/batch/portions.hpp"
#include "axode/contact.hpp"
#include "axode/integration/contact_sensitivities.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "axode/view/mesh_hull.hpp"
#include "python/bindings/contact_force.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/named_tuple.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/text.hpp"

/// Collision shapes, their distances, and the derivatives of motions with contact.
namespace axode::python {
namespace {

using namespace nb::literals;

nb::list distances_of(const BoundModel& m, ArrayLike q, std::optional<double> margin) {
  const States states = one_state(m, q);
  Distances distances = states.released(1000, [&] {  // files of meshes may be read
    return Distances(m, ContactShapes(m, hull_of_mesh));
  });
  const std::span<const ShapeDistance> found =
      distances.evaluate(states.q(0), margin.value_or(std::numeric_limits<double>::infinity()));
  const std::size_t nv = static_cast<std::size_t>(m->nv());
  std::vector<double> J(found.size() * nv);
  distances.jacobian(J);
  nb::list all;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const ShapeDistance& d = found[k];
    all.append(record("ShapeDistance", to_str(distances.shapes()[d.a].name),
                      to_str(distances.shapes()[d.b].name), d.distance, to_array(d.normal),
                      to_array(d.point_a), to_array(d.point_b), d.residual, d.proved,
                      to_array(std::span<const double>(J).subspan(k * nv, nv))));
  }
  return all;
}

nb::list shape_pairs_of(const BoundModel& m) {
  const ContactShapes shapes(*m, hull_of_mesh);
  nb::list all;
  for (const auto& [a, b] : shapes.pairs())
    all.append(nb::make_tuple(to_str(shapes[a].name), to_str(shapes[b].name)));
  return all;
}

/// The indices of the shapes of the named pairs, or of all pairs that may touch if `given` is None.
std::vector<std::array<int, 2>> pairs_from(const ContactShapes& shapes, nb::handle given) {
  if (given.is_none()) return {shapes.pairs().begin(), shapes.pairs().end()};
  std::map<std::string, int> numbers;
  for (int i = 0; i < shapes.size(); ++i) numbers.try_emplace(shapes[i].name, i);
  const auto number = [&](const std::string& name) {
    if (const auto found = numbers.find(name); found != numbers.end()) return found->second;
    throw UnknownName("pairs: there is no collision shape \"" + name + '"' +
                      did_you_mean(name, numbers, [](const auto& known) { return known.first; }));
  };
  std::vector<std::array<int, 2>> pairs;
  std::vector<std::array<std::string, 2>> named;
  if (nb::isinstance<nb::str>(given) || !nb::try_cast(given, named))
    throw nb::type_error("pairs: expected pairs of names of collision shapes, as shape_pairs(m) gives them");
  for (const auto& [a, b] : named) pairs.push_back({number(a), number(b)});
  return pairs;
}

nb::object pair_distances_of(const BoundModel& m, ArrayLike q, nb::handle given, int threads) {
  const States states(m, q, threads);
  const ContactShapes shapes = states.released(1000, [&] {  // files of meshes may be read
    return ContactShapes(*m, hull_of_mesh);
  });
  const std::vector<std::array<int, 2>> pairs = pairs_from(shapes, given);
  const std::size_t P = pairs.size(), size_of_J = P * static_cast<std::size_t>(m->nv());
  NewArray distances = states.result({static_cast<nb::ssize_t>(P)});
  NewArray jacobians = states.result({static_cast<nb::ssize_t>(P), m->nv()});
  states.unlocked(5.0 * static_cast<double>(P), [&](const batch::Monitor& monitor) {
    return batch::in_portions(states.count(), 1, threads, monitor, [&]() -> batch::Work {
      return [&, of = std::make_shared<Distances>(*m, shapes, pairs)](std::size_t k, std::size_t) {
        states.run(k, [&] {
          const std::span<const ShapeDistance> found = of->evaluate(states.q(k));
          std::ranges::transform(found, distances.all().subspan(k * P, P).begin(), &ShapeDistance::distance);
          of->jacobian(jacobians.all().subspan(k * size_of_J, size_of_J));
        });
      };
    });
  });
  return record("PairDistances", distances.array(), jacobians.array());
}

/// The arguments of a motion with contact whose derivatives are asked for.
struct ContactMotion {
  States states;
  Items v;
  Rows tau;
  double step;
  ContactShapes shapes;
  nb::ssize_t K;

  ContactMotion(const BoundModel& m, ArrayLike q, ArrayLike of_v, ArrayLike of_tau, double length)
      : states(one_state(m, q)),
        v(states.velocities("v", of_v)),
        tau(states, "tau", of_tau, "nv numbers for each step"),
        step(length),
        shapes(states.released(1000,
                               [&] {  // files of meshes may be read
                                 return ContactShapes(*m, hull_of_mesh);
                               })),
        K(tau.count()) {
    check_step(step);
  }
  const Model& model() const { return states.model(); }
  /// Whether derivatives by geometric parameters are known.
  bool knows_geometry() const { return model().loops().empty() && !model().springs().between_frames(); }
  nb::ssize_t number_of_shapes() const { return shapes.size(); }
  /// Calls f(monitor) without the lock of Python. Throws std::invalid_argument if it fails.
  template <class F> ContactSensitivity run(const F& f) const {
    const ContactSensitivity found =
        states.unlocked(1000 * static_cast<double>(K), [&](const batch::Monitor& monitor) {
          batch::MonitorThrottle throttle(monitor, 0);
          return f([&] { return throttle.should_continue(0); });
        });
    if (!found.ok())
      throw std::invalid_argument("at " + to_text(found.failure.t) + " s " + found.failure.why);
    return found;
  }
};

nb::object contact_rollout_derivatives_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                          double step, bool parameters) {
  const ContactMotion motion(m, q, v, tau, step);
  const nb::ssize_t K = motion.K, nq = m->nq(), nv = m->nv(), n = motion.number_of_shapes(),
                    bodies = m->n_bodies();
  NewArray q_out(Shape{K + 1, nq}), v_out(Shape{K + 1, nv});
  NewArray A(Shape{K, 2 * nv, 2 * nv}), B(Shape{K, 2 * nv, nv}), C(Shape{K, 2 * nv, 3, n});
  std::optional<NewArray> placement, inertia, geometry;
  ContactParameters<double> by;
  if (parameters) {
    by.placement = placement.emplace(Shape{K, 2 * nv, n, 6}).all();
    by.inertia = inertia.emplace(Shape{K, 2 * nv, 10 * bodies}).all();
    if (motion.knows_geometry()) by.geometry = geometry.emplace(Shape{K, 2 * nv, bodies, 6}).all();
  }
  const ContactSensitivity found = motion.run([&](const Monitor& monitor) {
    return contact_rollout_derivatives(*m, motion.shapes, motion.states.q(0), motion.v[0], motion.tau[0],
                                       step, {q_out.all(), v_out.all(), A.all(), B.all(), C.all(), by},
                                       monitor);
  });
  const auto or_none = [](std::optional<NewArray>& x) { return x ? nb::cast(x->array()) : nb::none(); };
  return record("ContactRolloutDerivatives", q_out.array(), v_out.array(), A.array(), B.array(), C.array(),
                found.certificate, found.unique, found.at_kink, or_none(placement), or_none(inertia),
                or_none(geometry));
}

std::tuple<Array, Array> contact_rollout_jvp_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau,
                                                double step, ArrayLike dq, ArrayLike dv, ArrayLike dtau,
                                                nb::handle surfaces, nb::handle placement, nb::handle inertia,
                                                nb::handle geometry) {
  const ContactMotion motion(m, q, v, tau, step);
  const States& states = motion.states;
  const nb::ssize_t K = motion.K, nv = m->nv(), n = motion.number_of_shapes(), bodies = m->n_bodies();
  const Items of_q = states.velocities("dq", dq), of_v = states.velocities("dv", dv),
              of_tau = states.items("dtau", dtau, {K, nv}, "nv numbers for each step");
  std::vector<Items> kept;
  kept.reserve(4);
  const auto change = [&](const char* name, nb::handle x, const Shape& shape, const char* meaning) {
    if (x.is_none()) return std::span<const double>();
    return kept.emplace_back(states.items(name, {x.ptr()}, shape, meaning)).all();
  };
  const ContactParameters<const double> parameters{
      change("surfaces", surfaces, {3, n}, "friction, restitution and thickness of each shape"),
      change("placement", placement, {n, 6}, "a displacement of each shape"),
      change("inertia", inertia, {10 * bodies}, "ten inertial parameters of each body"),
      change("geometry", geometry, {bodies, 6}, "six geometric parameters of each body")};
  NewArray dq_out(Shape{K + 1, nv}), dv_out(Shape{K + 1, nv});
  static_cast<void>(motion.run([&](const Monitor& monitor) {
    return contact_rollout_jvp(*m, motion.shapes, states.q(0), motion.v[0], motion.tau[0], step, of_q[0],
                               of_v[0], of_tau[0], dq_out.all(), dv_out.all(), monitor, parameters);
  }));
  return {dq_out.array(), dv_out.array()};
}

nb::object contact_rollout_vjp_of(const BoundModel& m, ArrayLike q, ArrayLike v, ArrayLike tau, double step,
                                  ArrayLike w_q, ArrayLike w_v) {
  const ContactMotion motion(m, q, v, tau, step);
  const States& states = motion.states;
  const nb::ssize_t K = motion.K, nv = m->nv(), n = motion.number_of_shapes(), bodies = m->n_bodies();
  const Items of_q = states.items("w_q", w_q, {K + 1, nv}, "nv numbers for each state"),
              of_v = states.items("w_v", w_v, {K + 1, nv}, "nv numbers for each state");
  NewArray by_q(Shape{nv}), by_v(Shape{nv}), by_tau(Shape{K, nv});
  NewArray surfaces(Shape{3, n}), placement(Shape{n, 6}), inertia(Shape{10 * bodies});
  std::optional<NewArray> geometry;
  if (motion.knows_geometry()) geometry.emplace(Shape{bodies, 6});
  static_cast<void>(motion.run([&](const Monitor& monitor) {
    return contact_rollout_vjp(
        *m, motion.shapes, states.q(0), motion.v[0], motion.tau[0], step, of_q[0], of_v[0],
        {by_q.all(), by_v.all(), by_tau.all()}, monitor,
        {surfaces.all(), placement.all(), inertia.all(), geometry ? geometry->all() : std::span<double>()});
  }));
  return record("ContactRolloutGradient", by_q.array(), by_v.array(), by_tau.array(), surfaces.array(),
                placement.array(), inertia.array(), geometry ? nb::cast(geometry->array()) : nb::none());
}

BoundModel with_shapes_of(const BoundModel& m, nb::handle friction, nb::handle restitution,
                          nb::handle placement) {
  std::vector<Numbers> kept;
  kept.reserve(3);
  const auto given = [&](const char* name, nb::handle x, int axes,
                         const char* shape) -> std::span<const double> {
    if (x.is_none()) return {};
    const Numbers& numbers = kept.emplace_back(name, ArrayLike{x.ptr()});
    if (numbers.axes() != axes || (axes == 2 && numbers.length(1) != 6))
      numbers.wrong_shape(std::string(shape) + " for n collision shapes");
    return {numbers.data(), static_cast<std::size_t>(numbers.size())};
  };
  return BoundModel(
      with_shapes(m, {given("friction", friction, 1, "(n,)"), given("restitution", restitution, 1, "(n,)"),
                      given("placement", placement, 2, "(n, 6)")}));
}

nb::list contacts_of(const BoundModel& m, ArrayLike q, nb::handle tau, LoadList loads, bool joint_losses,
                     std::optional<double> margin, double touching) {
  const States states = one_state(m, q);
  std::optional<Items> forces;
  if (!tau.is_none()) forces.emplace(states.velocities("tau", {tau.ptr()}));
  const AtRestOptions options{.margin = margin, .touching = touching, .joint_losses = joint_losses};
  const AppliedLoads applied(states, loads, false);
  return applied.with(0, [&](const Loads<double>& now) {
    std::vector<std::string> names;
    const ContactsAtRest found = states.released(1000, [&] {
      const ContactShapes shapes(m, hull_of_mesh);
      for (int i = 0; i < shapes.size(); ++i) names.push_back(shapes[i].name);
      return contacts_at_rest(m, shapes, states.q(0), forces ? (*forces)[0] : std::span<const double>(),
                              options, now);
    });
    return contact_list(names, found.contacts);
  });
}

}  // namespace

void add_contact(nb::module_& module) {
  module.def("distances", &distances_of, "m"_a, "q"_a, "margin"_a = nb::none(),
             nb::sig("def distances(m: Model, q: numpy.typing.ArrayLike, margin: float | None = None) -> "
                     "list[axode.records.ShapeDistance]"),
             R"(
Signed distances of the collision shapes that may touch, at q (nq,), where they are less than `margin` (m; None: all), see `ShapeDistance`.

Each has its nearest points, a certificate and its exact Jacobian. ValueError for a shape that cannot touch, such as a mesh
without a hull.

>>> ball = {"kind": "sphere", "role": "collision", "radius": 0.1}
>>> slider = axode.Model.from_dict({"format": "axode drawing 1", "shape": [ball], "body": [{
...     "name": "slide", "joint": {"kind": "prismatic", "axis": "x"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1],
...     "shape": [ball]}]})
>>> [near] = axode.distances(slider, [0.5])
>>> near.a, near.b, round(near.distance, 12), near.jacobian
('ground shape 1', 'slide shape 1', 0.3, array([1.]))
)");
  module.def("shape_pairs", &shape_pairs_of, "m"_a,
             nb::sig("def shape_pairs(m: Model) -> list[tuple[str, str]]"), R"(
The pairs of collision shapes that may touch, by their names, in the order of `distances` without a margin.

>>> robot = axode.load(axode.robots / "quadruped.toml")
>>> axode.shape_pairs(robot)[0]
('floor', 'belly')
)");
  module.def("pair_distances", &pair_distances_of, "m"_a, "q"_a, "pairs"_a = nb::none(), "threads"_a = 1,
             nb::sig("def pair_distances(m: Model, q: numpy.typing.ArrayLike, pairs: "
                     "collections.abc.Sequence[tuple[str, str]] | None = None, threads: int = 1) -> "
                     "axode.records.PairDistances"),
             R"(
Signed distances (..., P) of P pairs of collision shapes, m, and their Jacobians (..., P, nv), for one state q (nq,) or many (N, nq).

`pairs` are names of shapes, as in `shape_pairs`; None: all pairs that may touch. Signs, Jacobians and errors are those of
`distances`, which has nearest points and certificates as well. 0.2 to 15 us for each pair. KeyError for an unknown shape.

>>> robot = axode.load(axode.robots / "quadruped.toml")
>>> feet = [pair for pair in axode.shape_pairs(robot) if pair[0] == "floor"]
>>> distances, jacobians = axode.pair_distances(robot, np.tile(robot.neutral(), (100, 1)), feet)
>>> distances.shape == (100, len(feet)), jacobians.shape == (100, len(feet), robot.nv)
(True, True)
)");
  module.def(
      "contact_rollout_derivatives", &contact_rollout_derivatives_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a,
      "parameters"_a = false,
      nb::sig(
          "def contact_rollout_derivatives(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
          "tau: numpy.typing.ArrayLike, step: float, parameters: bool = False) -> "
          "axode.records.ContactRolloutDerivatives"),
      R"(
The motion from q (nq,) and v (nv,) under drive forces tau (K, nv) with contact, and how it depends on them, see `ContactRolloutDerivatives`.

The motion is that of `simulate(..., method="contact", joint_losses=True)` in K steps with constant forces; q has shape (K + 1, nq)
and v (K + 1, nv). Small deviations x = (dq, dv) become x_{k+1} = A_k x_k + B_k dtau_k, with A (K, 2 nv, 2 nv) and B (K, 2 nv, nv);
deviations of q are left-trivialised, q (+) dq as in `Model.integrate`. C (K, 2 nv, 3, number of collision shapes) has the derivatives
by the friction, the restitution and the thickness of a layer on each shape (m; the radius of a sphere or capsule, the height of
a plane), shapes of the ground first. With `parameters`, there are also those by the `placement` (K, 2 nv, shapes, 6) of shapes on
their bodies, six displacements along the axes of each shape, angular first; by the `inertia` (K, 2 nv, 10 n_bodies), as in
`m.parameters`; and by the `geometry` (K, 2 nv, n_bodies, 6), the geometric parameters of `rollout_vjp`, or None for loops and
springs between frames. These are the exact derivatives of the numerical steps, by
implicit differentiation: what touches, sticks, slides or bounces goes on doing so. `at_kink` says whether something was on
the boundary between two of these, so that the derivative is that of the branch that was taken, and `unique` is false if the
share of a load among sliding contacts decides a derivative. `certificate` is the largest of the steps. ValueError for contact
points without a closed form and for motions that cannot continue.

>>> ball = {"kind": "sphere", "role": "collision", "radius": 0.1, "friction": 0.2}
>>> table = axode.Model.from_dict({"format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision", "friction": 0.2}],
...     "body": [{"name": "ball", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [4e-3, 4e-3, 4e-3], "shape": [ball]}]})
>>> slides = axode.contact_rollout_derivatives(table, [0, 0, 0, 1, 0, 0, 0.1], [0, 0, 0, 1, 0, 0], np.zeros((5, 6)), 1e-2)
>>> slides.q[-1, 4].round(5), slides.A.shape, slides.unique
(np.float64(0.04755), (5, 12, 12), True)
)");
  module.def(
      "contact_rollout_jvp", &contact_rollout_jvp_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "dq"_a, "dv"_a,
      "dtau"_a, nb::kw_only(), "surfaces"_a = nb::none(), "placement"_a = nb::none(),
      "inertia"_a = nb::none(), "geometry"_a = nb::none(),
      nb::sig("def contact_rollout_jvp(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "tau: numpy.typing.ArrayLike, step: float, dq: numpy.typing.ArrayLike, "
              "dv: numpy.typing.ArrayLike, dtau: numpy.typing.ArrayLike, *, "
              "surfaces: numpy.typing.ArrayLike | None = None, "
              "placement: numpy.typing.ArrayLike | None = None, "
              "inertia: numpy.typing.ArrayLike | None = None, "
              "geometry: numpy.typing.ArrayLike | None = None) -> tuple[numpy.ndarray, numpy.ndarray]"),
      R"(
(dq, dv), (K + 1, nv) each: the deviations of all states of a motion with contact if its start, its drive forces and its parameters deviate.

Start and forces deviate by dq (nv,), dv (nv,) and dtau (K, nv), and parameters by `surfaces` (3, n) and `placement` (n, 6) of n
shapes, `inertia` (10 n_bodies,) and `geometry` (n_bodies, 6); None: not at all. Motion, deviations and errors are those of
`contact_rollout_derivatives`, computed without its matrices.

>>> box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2], "friction": 0.2}
>>> table = axode.Model.from_dict({"format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision", "friction": 0.2}],
...     "body": [{"name": "box", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [7e-3, 7e-3, 7e-3], "shape": [box]}]})
>>> start = [0, 0, 0, 1, 0, 0, 0.1], [0, 0, 0, 1, 0, 0], np.zeros((5, 6)), 1e-2
>>> dq, dv = axode.contact_rollout_jvp(table, *start, np.zeros(6), np.zeros(6), np.zeros((5, 6)), surfaces=[[1, 1], [0, 0], [0, 0]])
>>> dv[-1, 3].round(6)  # -g t by the friction
np.float64(-0.4905)
)");
  module.def(
      "contact_rollout_vjp", &contact_rollout_vjp_of, "m"_a, "q"_a, "v"_a, "tau"_a, "step"_a, "w_q"_a,
      "w_v"_a,
      nb::sig("def contact_rollout_vjp(m: Model, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike, "
              "tau: numpy.typing.ArrayLike, step: float, w_q: numpy.typing.ArrayLike, "
              "w_v: numpy.typing.ArrayLike) -> axode.records.ContactRolloutGradient"),
      R"(
The gradients of a weighted sum over all states of a motion with contact, the sum of w_q . dq + w_v . dv, see `ContactRolloutGradient`.

w_q and w_v have shape (K + 1, nv). Motion, deviations and errors are those of `contact_rollout_derivatives`, and the parameters those
of `contact_rollout_jvp`.

>>> box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2], "friction": 0.2}
>>> table = axode.Model.from_dict({"format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision", "friction": 0.2}],
...     "body": [{"name": "box", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [7e-3, 7e-3, 7e-3], "shape": [box]}]})
>>> w = np.zeros((6, 6))
>>> w[-1, 3] = 1
>>> axode.contact_rollout_vjp(table, [0, 0, 0, 1, 0, 0, 0.1], [0, 0, 0, 1, 0, 0], np.zeros((5, 6)), 1e-2, 0 * w, w).surfaces[0].round(5)
array([-0.24525, -0.24525])
)");
  module.def(
      "contacts", &contacts_of, "m"_a, "q"_a, "tau"_a = nb::none(), "loads"_a = nb::none(),
      "joint_losses"_a = false, "margin"_a = nb::none(), "touching"_a = 1e-6,
      nb::sig("def contacts(m: Model, q: numpy.typing.ArrayLike, tau: numpy.typing.ArrayLike | None = None, "
              "loads: collections.abc.Sequence[axode.Load] | None = None, joint_losses: bool = False, "
              "margin: float | None = None, touching: float = 1e-6) -> "
              "list[axode.records.ContactForce]"),
      R"(
Points of contact at q (nq,), and the forces there at the instant at which the mechanism is at rest and let go, see `ContactForce`.

Points with a gap of at most `touching` (m) press; others with a gap below `margin` (m; None: that of the drawing) are open.
tau (nv,) are the drive forces, and springs and `loads` act in addition; dry friction of joints holds if `joint_losses`. Where
several points carry one load, the share of each is arbitrary, and their sum and moment are not. ValueError for a loop that
is open at q, a shape that cannot touch, prescribed motions, drives with states, couplings with play and a singular mass
matrix.

>>> ball = axode.Model.from_dict({"format": "axode drawing 1", "body": [{
...     "name": "ball", "joint": {"kind": "prismatic", "axis": "z"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1],
...     "shape": [{"kind": "sphere", "role": "collision", "radius": 0.1}]}]})
>>> [point] = axode.contacts(axode.with_floor(ball, -0.1), [0])
>>> point.a, point.b, point.status, point.force.round(9)
('floor', 'ball shape 1', 'stick', array([0.  , 0.  , 9.81]))
)");
  module.def("with_shapes", &with_shapes_of, "m"_a, nb::kw_only(), "friction"_a = nb::none(),
             "restitution"_a = nb::none(), "placement"_a = nb::none(),
             nb::sig("def with_shapes(m: Model, *, friction: numpy.typing.ArrayLike | None = None, "
                     "restitution: numpy.typing.ArrayLike | None = None, "
                     "placement: numpy.typing.ArrayLike | None = None) -> Model"),
             R"(
The mechanism whose n collision shapes have another `friction` (n,), `restitution` (n,) or `placement` (n, 6) on their bodies.

Shapes of the ground come first, then those of the bodies in the order of the drawing. A `placement` displaces a shape from where it
is drawn, along the axes of the shape: three rotations (rad) and three translations (m), the exponential of a screw. None: as drawn.
ValueError for another shape of an array, and ModelError for numbers that a shape cannot have.

>>> robot = axode.load(axode.robots / "quadruped.toml")
>>> n = axode.contact_rollout_derivatives(robot, robot.neutral(), np.zeros(robot.nv), np.zeros((0, robot.nv)), 1e-3).C.shape[-1]
>>> axode.with_shapes(robot, friction=np.full(n, 0.5)).nv == robot.nv
True
)");
  module.def(
      "with_floor", [](const BoundModel& m, double height) { return BoundModel(with_floor(m, height)); },
      "m"_a, "height"_a = 0.0, nb::sig("def with_floor(m: Model, height: float = 0.0) -> Model"),
      R"(
The mechanism on a floor: with a plane across gravity (z if there is none) as one more collision shape of the ground, `floor`.

`height` (m) is that of the plane above the inertial origin. The mechanism has `[contact]` from now on, so that `simulate` and
`rollout` count contact. ValueError if the height is not finite, or if something moves and no body has a collision shape.
ModelError if the mechanism cannot be built with a floor.

>>> robot = axode.load(axode.robots / "quadruped.toml")
>>> axode.with_floor(robot, -0.5).nv == robot.nv
True
)");
}

}  // namespace axode::python
