#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/bound_model.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/conversions.hpp"
#include "python/bindings/support/description.hpp"
#include "python/bindings/support/one_state.hpp"
#include "python/bindings/support/raise.hpp"
#include "python/bindings/support/text.hpp"

namespace axode::python {
namespace {

using namespace nb::literals;

template <class Range> std::vector<std::string> names(const Range& named) {
  std::vector<std::string> found;
  for (const auto& each : named) found.push_back(each.name);
  return found;
}

/// The name that is given for an argument. Throws nb::value_error if it is not a str.
std::string name_in(const char* argument, nb::handle given) {
  if (!nb::isinstance<nb::str>(given))
    throw nb::value_error((std::string(argument) + " is " + shown(given) + "; expected a name").c_str());
  return text_of(given);
}

/// A joint that Python holds, with its model, from which the names of its indices follow.
struct BoundJoint {
  const BoundModel* model;
  int i;
  const Joint& operator*() const { return (*model)->joint(i); }
};
struct BoundBody {
  const BoundModel* model;
  int i;
  const Body& operator*() const { return (*model)->body(i); }
};

/// An array with one number of each degree of freedom of a joint.
template <double Dof::*number> Array of_each_dof(const BoundJoint& joint) {
  NewArray out({static_cast<nb::ssize_t>((*joint).dof.size())});
  double* to = out.data();
  for (const Dof& dof : (*joint).dof) *to++ = dof.*number;
  return out.array();
}

std::string rounded(double x) {
  std::array<char, 32> text;
  return {text.data(), static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.6g", x))};
}

std::string repr(const BoundModel& model) {
  const auto count = [](int n, const char* one, const char* many) {
    return std::to_string(n) + (n == 1 ? one : many);
  };
  return "Model(\"" + model->name() + "\": " + count(model->n_bodies(), " moving body", " moving bodies") +
         ", nq = " + std::to_string(model->nq()) + ", nv = " + std::to_string(model->nv()) + ", " +
         count(model->n_frames(), " frame", " frames") + ", " + rounded(model->total_mass()) + " kg)";
}

std::string indices(int first, int n) {
  if (n == 0) return "-";
  return n == 1 ? std::to_string(first) : std::to_string(first) + ":" + std::to_string(first + n);
}

/// A line of text for each joint: kind, indices of q and v, the body that it moves, and its predecessor.
std::string table(const BoundModel& model) {
  std::vector<std::array<std::string, 6>> rows{{"joint", "kind", "q", "v", "body", "on"}};
  for (int i = 1; i <= model->n_bodies(); ++i) {
    const Joint& joint = model->joint(i);
    rows.push_back({joint.name, std::string(to_string(joint.kind)), indices(joint.iq, joint.nq),
                    indices(joint.iv, joint.nv), model->body(i).name,
                    model->body(model->body(i).predecessor).name});
  }
  std::array<std::size_t, 6> width{};
  for (const auto& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string text = repr(model);
  for (const auto& row : rows) {
    text += "\n ";
    for (std::size_t c = 0; c < row.size(); ++c)
      text += " " + row[c] + (c + 1 < row.size() ? std::string(width[c] - row[c].size() + 1, ' ') : "");
  }
  return text;
}

void add_parts(nb::module_& module) {
  nb::class_<BoundJoint>(module, "Joint", "The joint that moves a body; read only.")
      .def_prop_ro("name", [](const BoundJoint& j) { return (*j).name; })
      .def_prop_ro(
          "kind", [](const BoundJoint& j) { return std::string(to_string((*j).kind)); },
          "revolute, prismatic, helical, spherical, planar or free.")
      .def_prop_ro(
          "pitch", [](const BoundJoint& j) { return (*j).pitch; }, "Pitch of a helical joint, m/rad.")
      .def_prop_ro(
          "q", [](const BoundJoint& j) { return nb::slice((*j).iq, (*j).iq + (*j).nq, 1); },
          nb::sig("def q(self) -> slice[int, int, int]"),
          "Slice of its coordinates in q: `q[m.joint(name).q]`. Empty for a coupled joint.")
      .def_prop_ro(
          "v", [](const BoundJoint& j) { return nb::slice((*j).iv, (*j).iv + (*j).nv, 1); },
          nb::sig("def v(self) -> slice[int, int, int]"), "Slice of its velocities in v, a and tau.")
      .def_prop_ro("nq", [](const BoundJoint& j) { return (*j).nq; })
      .def_prop_ro("nv", [](const BoundJoint& j) { return (*j).nv; })
      .def_prop_ro(
          "leader",
          [](const BoundJoint& j) -> std::optional<std::tuple<std::string, double, double>> {
            if (!(*j).leader) return std::nullopt;
            return std::tuple((*j.model)->joint((*j).leader->joint).name, (*j).leader->ratio,
                              (*j).leader->offset);
          },
          "(name, ratio, offset) if its coordinate is ratio * the coordinate of joint `name` + offset, else "
          "None.")
      .def_prop_ro("lower", &of_each_dof<&Dof::lower>,
                   "Lower limit of each degree of freedom, rad or m; may be -inf.")
      .def_prop_ro("upper", &of_each_dof<&Dof::upper>,
                   "Upper limit of each degree of freedom, rad or m; may be inf.")
      .def_prop_ro("velocity", &of_each_dof<&Dof::velocity>, "Largest speed, rad/s or m/s; may be inf.")
      .def_prop_ro("effort", &of_each_dof<&Dof::effort>, "Largest drive force, N m or N; may be inf.")
      .def_prop_ro("damping", &of_each_dof<&Dof::damping>,
                   "Viscous damping, N m s/rad or N s/m; counted if `joint_losses` is set.")
      .def_prop_ro("friction", &of_each_dof<&Dof::friction>,
                   "Coulomb friction, N m or N; counted if `joint_losses` is set.")
      .def_prop_ro("armature", &of_each_dof<&Dof::armature>,
                   "Inertia of the drive at the joint, kg m^2 or kg.")
      .def_prop_ro("gear_loss", &of_each_dof<&Dof::gear_loss>,
                   "Part of the force that its gear transmits and loses in addition while the drive drives; "
                   "counted if `joint_losses` is set.")
      .def_prop_ro(
          "gear_loss_back",
          [](const BoundJoint& j) {
            NewArray out({static_cast<nb::ssize_t>((*j).dof.size())});
            double* to = out.data();
            for (const Dof& dof : (*j).dof) *to++ = dof.gear_loss_back.value_or(dof.gear_loss);
            return out.array();
          },
          "Losses of the gears of its degrees of freedom while the joint drives the drive back; from 1 on a "
          "gear locks itself.")
      .def_prop_ro(
          "passive", [](const BoundJoint& j) { return (*j).passive; },
          "Whether it has no drive; this matters in mechanisms with loops.")
      .def("__repr__", [](const BoundJoint& j) {
        return "Joint(\"" + (*j).name + "\": " + std::string(to_string((*j).kind)) + ", q " +
               indices((*j).iq, (*j).nq) + ", v " + indices((*j).iv, (*j).nv) + ")";
      });
  nb::class_<BoundBody>(module, "Body", "A body that moves, in the frame in which it was placed; read only.")
      .def_prop_ro("name", [](const BoundBody& b) { return (*b).name; })
      .def_prop_ro(
          "predecessor", [](const BoundBody& b) { return (*b.model)->body((*b).predecessor).name; },
          "The body that carries it, or \"ground\".")
      .def_prop_ro(
          "A", [](const BoundBody& b) { return to_array((*b).A); },
          "C_i(0), pose at q = 0 in the inertial frame, (4, 4), m.")
      .def_prop_ro(
          "B", [](const BoundBody& b) { return to_array((*b).B); },
          "Pose at q = 0 in the predecessor's frame, (4, 4), m.")
      .def_prop_ro(
          "S_self", [](const BoundBody& b) { return to_array((*b).S_self); },
          "Pose of the joint frame in the body frame, (4, 4), m; its z-axis is the joint axis.")
      .def_prop_ro(
          "X", [](const BoundBody& b) { return columns(std::span<const Screw<>>((*b).X)); },
          "Joint screws in the body frame, (6, d), angular before linear; a column for each velocity.")
      .def_prop_ro(
          "M", [](const BoundBody& b) { return to_array((*b).M); },
          "Inertia matrix [[Theta, h~], [-h~, m I]] in the body frame, (6, 6), with all that is fixed to it "
          "(eq. Mb).")
      .def_prop_ro(
          "mass", [](const BoundBody& b) { return (*b).M.m; }, "kg.")
      .def("__repr__", [](const BoundBody& b) {
        return "Body(\"" + (*b).name + "\" on \"" + (*b.model)->body((*b).predecessor).name + "\", " +
               rounded((*b).M.m) + " kg)";
      });
}

void add_configurations(nb::class_<BoundModel>& model) {
  model
      .def(
          "neutral", [](const BoundModel& m) { return to_array(neutral(m)); }, R"(
The configuration with every joint at zero and every quaternion (x y z w) the identity: shape (nq,).

>>> arm.neutral()
array([0., 0., 0., 0., 0., 0., 0.])
)")
      .def(
          "random",
          [](const BoundModel& m, std::uint64_t seed, std::optional<std::size_t> n) {
            if (!n) return to_array(random_configuration(m, seed));
            NewArray out({static_cast<nb::ssize_t>(*n), m->nq()});
            put(random_configurations(m, seed, *n), out.all());
            return out.array();
          },
          "seed"_a = 0, "n"_a = nb::none(), R"(
A random configuration within the limits, uniform for each joint, shape (nq,), or n configurations, (n, nq). The same
seed gives the same result.

Unlimited angles are in [-pi, pi], unlimited lengths in [-1, 1] m, rotations uniform on SO(3).

>>> q = arm.random(seed=3)
>>> q.shape
(7,)
>>> arm.random(seed=3, n=100).shape
(100, 7)
)")
      .def(
          "normalize",
          [](const BoundModel& m, ArrayLike q) {
            return map_states(m, 1, linear_cost(m), {m->nq()}, q,
                              [&](auto&, auto from, auto out) { put(normalize(m, from), out); })
                .array();
          },
          "q"_a, R"(
The configuration q with every quaternion scaled to norm 1, shape (nq,) or (N, nq). ValueError if the norm of one is
0.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> base.normalize(2 * base.neutral())[:4]
array([0., 0., 0., 1.])
)")
      .def(
          "coordinate_rates",
          [](const BoundModel& m, ArrayLike q, ArrayLike v) {
            return map_states(
                       m, 1, linear_cost(m), {m->nq()}, q,
                       [&](auto&, auto from, auto by, auto out) { put(coordinate_rates(m, from, by), out); },
                       Named{"v", v})
                .array();
          },
          "q"_a, "v"_a, R"(
The rates dq/dt = E(q) v of the coordinates, shape (nq,) or (N, nq), from v (nv,) or (N, nv). The rate of a quaternion
a is a (omega; 0) / 2.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> base.coordinate_rates(base.neutral(), np.arange(base.nv))[:7]
array([0. , 0.5, 1. , 0. , 3. , 4. , 5. ])
)")
      .def(
          "velocities_from_rates",
          [](const BoundModel& m, ArrayLike q, ArrayLike dq) {
            const States states(m, q, 1);
            const Items rates = states.configurations("dq", dq);
            return each_item(states, linear_cost(m), {m->nv()},
                             [&](auto&, std::size_t k, auto out) {
                               put(velocities_from_rates(m, states.q(k), rates[k]), out);
                             })
                .array();
          },
          "q"_a, "dq"_a, R"(
The velocities v from the rates dq/dt, the inverse of `coordinate_rates`: shape (nv,) or (N, nv).

The part of a quaternion's rate that would change its norm is left out.

>>> base = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> q, v = base.random(), np.arange(base.nv)
>>> bool(np.allclose(base.velocities_from_rates(q, base.coordinate_rates(q, v)), v))
True
)")
      .def(
          "integrate",
          [](const BoundModel& m, ArrayLike q, ArrayLike dv) {
            return map_states(
                       m, 1, linear_cost(m), {m->nq()}, q,
                       [&](auto&, auto from, auto by, auto out) { put(integrate(m, from, by), out); },
                       Named{"dv", dv})
                .array();
          },
          "q"_a, "dv"_a, R"(
q (+) dv: the configuration after every joint has moved along its left-trivialised direction.

q has shape (nq,) or (N, nq), dv (nv,) or (N, nv), rad and m; a step of length h with velocity v is dv = h v.

>>> arm.integrate(arm.neutral(), np.full(7, 0.1))
array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
)")
      .def(
          "difference",
          [](const BoundModel& m, ArrayLike q0, ArrayLike q1) {
            const States states(m, q0, 1, "q0");
            const Items to = states.configurations("q1", q1);
            return each_item(
                       states, linear_cost(m), {m->nv()},
                       [&](auto&, std::size_t k, auto out) { put(difference(m, states.q(k), to[k]), out); })
                .array();
          },
          "q0"_a, "q1"_a, R"(
q1 (-) q0: the dv with integrate(q0, dv) = q1, the shorter way round on rotations.

Shapes (nq,) or (N, nq) to (nv,) or (N, nv), rad and m.

>>> arm.difference(arm.neutral(), np.full(7, 0.2))
array([0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2])
)")
      .def(
          "initial_state",
          [](const BoundModel& m) {
            const InitialState start = initial_state(m);
            return std::pair(to_array(start.q), to_array(start.v));
          },
          R"(
(q, v): the state in which a motion of the mechanism starts, as its drawing says; (nq,) and (nv,).

Joints that the drawing does not name are at zero and at rest.

>>> bool(arm.initial_state()[1].any())
False
)")
      .def(
          "interpolate",
          [](const BoundModel& m, ArrayLike q0, ArrayLike q1, nb::handle s) {
            const double part = number("s", s);
            const States states(m, q0, 1, "q0");
            const Items to = states.configurations("q1", q1);
            return each_item(states, linear_cost(m), {m->nq()},
                             [&](auto&, std::size_t k, auto out) {
                               put(interpolate(m, states.q(k), to[k], part), out);
                             })
                .array();
          },
          "q0"_a, "q1"_a, "s"_a,
          nb::sig(
              "def interpolate(self, q0: numpy.typing.ArrayLike, q1: numpy.typing.ArrayLike, s: float) -> "
              "numpy.typing.NDArray[numpy.float64]"),
          R"(
q0 (+) s (q1 (-) q0): a screw motion of every joint from q0 at s = 0 to q1 at s = 1.

Shapes (nq,) or (N, nq).

>>> arm.interpolate(arm.neutral(), np.full(7, 0.2), 0.5)
array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
)")
      .def(
          "clamp",
          [](const BoundModel& m, ArrayLike q) {
            return map_states(m, 1, linear_cost(m), {m->nq()}, q,
                              [&](auto&, auto from, auto out) { put(clamp(m, from), out); })
                .array();
          },
          "q"_a, R"(
The nearest configuration within the limits, shape (nq,) or (N, nq).

>>> bool(np.all(arm.clamp(np.full(7, 10.0)) <= arm.limits()[1]))
True
)")
      .def(
          "limits",
          [](const BoundModel& m) {
            const CoordinateLimits found = limits(m);
            return std::pair(to_array(found.lower), to_array(found.upper));
          },
          R"(
(lower, upper) limit of each coordinate, two arrays (nq,), rad and m; infinite if there is no limit.

>>> lower, upper = arm.limits()
>>> float(upper[0])
2.96706
)");
}

/// The lists of tables of a drawing, and the table of its initial state (or None), as Python objects.
struct Tables {
  nb::handle bodies, frames, springs, loops, couplings, motions, drives, state;
};
nb::dict drawing_of(const Tables& of, const std::string& name, nb::handle gravity) {
  nb::dict drawing;
  drawing["format"] = "axode drawing 1";
  drawing["name"] = name;
  drawing["gravity"] = gravity;
  drawing["body"] = of.bodies;
  drawing["frame"] = of.frames;
  drawing["spring"] = of.springs;
  drawing["loop"] = of.loops;
  drawing["coupling"] = of.couplings;
  drawing["motion"] = of.motions;
  drawing["drive"] = of.drives;
  if (!of.state.is_none()) drawing["state"] = of.state;
  return drawing;
}

void add_construction(nb::class_<BoundModel>& model) {
  model
      .def_static(
          "from_bodies",
          [](nb::handle bodies, nb::handle frames, nb::handle springs, nb::handle loops, nb::handle couplings,
             nb::handle motions, nb::handle drives, nb::handle state, const std::string& name,
             nb::handle gravity, Base base, bool strict) {
            return BoundModel(
                from_dict(drawing_of({bodies, frames, springs, loops, couplings, motions, drives, state},
                                     name, gravity),
                          base, strictness(strict)));
          },
          "bodies"_a, "frames"_a = nb::make_tuple(), nb::kw_only(), "springs"_a = nb::make_tuple(),
          "loops"_a = nb::make_tuple(), "couplings"_a = nb::make_tuple(), "motions"_a = nb::make_tuple(),
          "drives"_a = nb::make_tuple(), "state"_a = nb::none(), "name"_a = "mechanism",
          "gravity"_a = nb::make_tuple(0.0, 0.0, -9.81), "base"_a = nb::none(), "strict"_a = false,
          nb::sig("def from_bodies(bodies: collections.abc.Sequence[dict[str, typing.Any]], "
                  "frames: collections.abc.Sequence[dict[str, typing.Any]] = (), *, "
                  "springs: collections.abc.Sequence[dict[str, typing.Any]] = (), "
                  "loops: collections.abc.Sequence[dict[str, typing.Any]] = (), "
                  "couplings: collections.abc.Sequence[dict[str, typing.Any]] = (), "
                  "motions: collections.abc.Sequence[dict[str, typing.Any]] = (), "
                  "drives: collections.abc.Sequence[dict[str, typing.Any]] = (), "
                  "state: dict[str, typing.Any] | None = None, "
                  "name: str = 'mechanism', gravity: numpy.typing.ArrayLike = (0.0, 0.0, -9.81), "
                  "base: typing.Literal['fixed', 'free'] | None = None, strict: bool = False) -> Model"),
          R"(
Builds a mechanism from axes, points, masses and inertias, all in one frame with every joint at zero.

Each body, frame, spring, loop, coupling, motion and drive, and the state, is a dict with the keys of the drawing format
(docs/drawing-format.md): name, on, joint, mass, com, inertia, ... SI units. The frame of a body is the construction
frame unless its dict names another, such as "frame": "joint" or "frame": "com". ModelError lists every fault; base and strict are those of `load`.

>>> pendulum = axode.Model.from_bodies([
...     {"name": "rod", "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]},
...      "mass": 1.0, "com": [0, 0, -0.5], "inertia": [1/12, 1/12, 0.001]}])
>>> axode.gravity_torques(pendulum, [np.pi / 2]).round(3)
array([4.905])
)")
      .def_static(
          "from_dict",
          [](const nb::dict& drawing, Base base, bool strict) {
            return BoundModel(from_dict(drawing, base, strictness(strict)));
          },
          "drawing"_a, "base"_a = nb::none(), nb::kw_only(), "strict"_a = false,
          nb::sig("def from_dict(drawing: dict[str, typing.Any], base: typing.Literal['fixed', 'free'] | "
                  "None = None, *, strict: bool = False) -> Model"),
          R"(
The mechanism of a whole drawing that is given as a dict, for example an edited result of `to_dict`, or one of
tomllib. Arguments and errors are those of `load`.

>>> drawing = arm.to_dict()
>>> drawing["gravity"] = [0, 0, -1.62]
>>> axode.Model.from_dict(drawing).gravity
array([ 0.  ,  0.  , -1.62])
)")
      .def(
          "to_dict", [](const BoundModel& m) { return to_dict(*m); },
          nb::sig("def to_dict(self) -> dict[str, typing.Any]"), R"(
The mechanism as a drawing in a dict, with everything in the construction frame. It can be edited and built again.

>>> arm.to_dict()["body"][1]["name"]
'link 1'
)");
}

void add_lookup(nb::class_<BoundModel>& model) {
  const auto joint_of = [](const BoundModel& m, nb::handle name) {
    return BoundJoint{&m, m->joint_index(name_in("name", name))};
  };
  const auto body_of = [](const BoundModel& m, nb::handle name) {
    return BoundBody{&m, m->body_index(name_in("name", name))};
  };
  model
      .def("joint", joint_of, "name"_a, nb::sig("def joint(self, name: str) -> Joint"),
           nb::keep_alive<0, 1>(), R"(
The joint with a name; KeyError with the nearest name if there is none.

>>> q = arm.neutral()
>>> q[arm.joint("A2").q] = 0.8
>>> arm.joint("A2")
Joint("A2": revolute, q 1, v 1)
)")
      .def("body", body_of, "name"_a, nb::sig("def body(self, name: str) -> Body"), nb::keep_alive<0, 1>(),
           R"(
The moving body with a name, or "ground"; KeyError with the nearest name if there is none.

>>> arm.body("link 2").predecessor
'link 1'
)")
      .def(
          "frame_index", [](const BoundModel& m, FrameName frame) { return frame.in(m); }, "frame"_a, R"(
The index of a frame in `frame_names`, and hence in the results of `poses`, `twists` and `accelerations`; KeyError for
an unknown name.

>>> axode.poses(arm, arm.neutral())[arm.frame_index("flange"), :3, 3]
array([0.   , 0.   , 1.306])
)")
      .def(
          "frame_pose",
          [](const BoundModel& m, FrameName frame) {
            const Frame& found = m->frame(frame.in(m));
            return std::pair(m->body(found.body).name, to_array(found.pose));
          },
          "frame"_a, R"(
(body, pose): the body that a frame is fixed to, and its pose (4, 4) in that body's frame, m.

>>> body, pose = arm.frame_pose("flange")
>>> body
'link 7'
)")
      .def(
          "reduced",
          [](const BoundModel& m, const std::vector<std::string>& locked, ArrayLike q) {
            const States states = one_state(m, q);
            std::vector<std::string_view> views(locked.begin(), locked.end());
            return BoundModel(reduced(m, views, states.q(0)));
          },
          "locked"_a, "q"_a, R"(
A new model in which the named joints are fixed at their positions in q, shape (nq,).

>>> arm.reduced(["A6", "A7"], arm.neutral()).nv
5
)");
}

void add_edits(nb::class_<BoundModel>& model) {
  model
      .def(
          "with_parameters",
          [](const BoundModel& m, ArrayLike pi) {
            const Numbers numbers("pi", pi);
            if (numbers.axes() != 1 || !numbers.ends_with({10 * m->n_bodies()}))
              numbers.wrong_shape("(" + std::to_string(10 * m->n_bodies()) +
                                  ",), ten numbers for each body, as in `parameters`");
            return BoundModel(with_parameters(m, {numbers.data(), static_cast<std::size_t>(numbers.size())}));
          },
          "pi"_a, R"(
A new model with other inertial parameters, identified ones for example: shape (10 n_bodies,), ordered as `parameters`.

Bodies that are fixed to a moving body stay as massless frames, because their inertia is part of the parameters of
that body. Parameters that no mass distribution has are reported in `warnings`; ModelError for a negative mass.

>>> heavier = arm.with_parameters(1.1 * arm.parameters)
>>> bool(np.isclose(heavier.total_mass, 1.1 * arm.total_mass))
True
)")
      .def(
          "with_gravity",
          [](const BoundModel& m, ArrayLike gravity) {
            const Numbers g("gravity", gravity);
            if (g.axes() != 1 || !g.ends_with({3})) g.wrong_shape("(3,), m/s^2");
            return BoundModel(with_gravity(m, vector_from(g.data())));
          },
          "gravity"_a, R"(
A new model in another gravity, (3,) in the inertial frame, m/s^2.

>>> arm.with_gravity([0, 0, -1.62]).gravity
array([ 0.  ,  0.  , -1.62])
)")
      .def(
          "with_payload",
          [](const BoundModel& m, FrameName frame, ArrayLike M, const std::string& name) {
            const Numbers numbers("M", M);
            if (numbers.axes() != 2 || !numbers.ends_with({6, 6}))
              numbers.wrong_shape("(6, 6), as of axode.lie.inertia");
            const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(numbers.data());
            return BoundModel(
                with_payload(m, m->frame(frame.in(m)).name, from_eigen<Inertia<>>(matrix), name));
          },
          "frame"_a, "M"_a, "name"_a = "payload", R"(
A new model with a body fixed to a frame; M (6, 6) is its inertia in that frame, and `name` becomes a frame as well.

`axode.lie` computes M from mass, center of mass and rotational inertia, and for boxes, balls, cylinders, capsules and
meshes. ModelError for a name that is taken and for an inertia that no mass distribution has.

>>> ball = axode.lie.sphere_inertia(2.0, 0.05)
>>> loaded = arm.with_payload("flange", axode.lie.transform_inertia(axode.lie.exp([0, 0, 0, 0, 0, 0.05]), ball))
>>> round(loaded.total_mass - arm.total_mass, 9)
2.0
)")
      .def(
          "append",
          [](const BoundModel& m, FrameName frame, const BoundModel& other, const std::string& prefix,
             nb::handle joint) {
            return BoundModel(append(m, m->frame(frame.in(m)).name, other, prefix, joint_of(joint)));
          },
          "frame"_a, "other"_a, "prefix"_a = "", "joint"_a = nb::none(),
          nb::sig("def append(self, frame: str | int, other: Model, prefix: str = '', "
                  "joint: dict[str, typing.Any] | str | None = None) -> Model"),
          R"(
A new model with another one mounted on a frame, for example a hand on an arm. The frame replaces the ground of the
other model.

`prefix` is put before all names of the other model; ValueError lists names that both have. `coordinate_names` shows
the order of the coordinates: as always, bodies are numbered depth-first. If a `joint` is given, with the keys of a
drawing and with axis and point in the frame, the ground of the other model moves on the frame by this joint; it
becomes a massless body `<joint>.base`. A joint without a name is called `<prefix>mount`.

>>> two = arm.append("flange", arm, prefix="second ")
>>> two.nv, two.velocity_names[7]
(14, 'second A1')
>>> arm.append("flange", arm, prefix="second ", joint={"kind": "prismatic", "axis": "z"}).velocity_names[7]
'second mount'
)")
      .def(
          "rerooted",
          [](const BoundModel& m, const std::string& body) { return BoundModel(rerooted(m, body)); },
          "body"_a, R"(
The same mechanism with another body as its root. This body is on the ground by the joint of the old root, which is
fixed or free, and the joints between the two bodies are reversed.

All names stay, and joints of one velocity keep their q, v, a and tau. A spherical, planar or free joint between the
two bodies has the inverse displacement, and a free root has the pose and twist of the body; `joint_state(n, poses(m,
q), twists(m, q, v))` of bodies with the same names has the q and v of the new model. ValueError for an unknown body,
for a root on another kind of joint, and for limits, losses, springs and armatures that would then act along the axes
of another body.

>>> duck = axode.load(axode.robots / "humanoid.urdf", base="free")
>>> seen_from_a_foot = duck.rerooted(duck.body_names[-1])
>>> seen_from_a_foot.body_names[0] == duck.body_names[-1], seen_from_a_foot.nv == duck.nv
(True, True)
)");
}

}  // namespace

int FrameName::in(const Model& model, const char* argument) const {
  const nb::handle name(given);
  if (nb::isinstance<nb::str>(name)) return model.frame_index(text_of(name));
  if (!PyIndex_Check(given) || PyBool_Check(given))
    throw nb::value_error(
        (std::string(argument) + " is " + shown(name) + "; expected the name of a frame, or its number")
            .c_str());
  const Py_ssize_t number = PyNumber_AsSsize_t(given, nullptr);  // a number that is too large becomes the
                                                                 // largest one
  if (number < 0 || number >= model.n_frames())
    throw nb::value_error((std::string(argument) + " is " + shown(name) + "; model \"" + model.name() +
                           "\" has frames 0 to " + std::to_string(model.n_frames() - 1))
                              .c_str());
  return static_cast<int>(number);
}

Place<> place(const Model& model, FrameName frame, ArrayLike offset, const char* argument) {
  const int f = frame.in(model, argument);
  if (nb::handle(offset.given).is_none()) return f;
  const Numbers numbers("offset", offset);
  const double* x = numbers.data();
  if (numbers.axes() == 1 && numbers.ends_with({3})) return {f, Vec3<>{x[0], x[1], x[2]}};
  if (numbers.axes() != 2 || !numbers.ends_with({4, 4}))
    numbers.wrong_shape("(3,), a point in the frame, or (4, 4), a pose in it");
  return {f, pose_from("offset", x)};
}

void add_model(nb::module_& module) {
  add_parts(module);
  nb::class_<BoundModel> model(module, "Model", nb::is_weak_referenceable(), R"(
An immutable tree of bodies, which `load`, `Model.from_bodies` and `Builder` make. Threads may share it.

Moving bodies are numbered depth-first in the order in which they were declared; joint i moves body i. Frames are the
ground, the bodies, then all other names; functions with results for every frame use the order of `frame_names`.
print(model) shows the coordinates of each joint.

>>> arm
Model("arm7": 7 moving bodies, nq = 7, nv = 7, 10 frames, 26.334 kg)
)");
  model.def_prop_ro("name", [](const BoundModel& m) { return m->name(); })
      .def_prop_ro(
          "nq", [](const BoundModel& m) { return m->nq(); }, "Number of coordinates q; a rotation has four.")
      .def_prop_ro(
          "nv", [](const BoundModel& m) { return m->nv(); },
          "Number of velocities v, the degrees of freedom.")
      .def_prop_ro(
          "n_bodies", [](const BoundModel& m) { return m->n_bodies(); }, "Number of moving bodies.")
      .def_prop_ro("n_frames", [](const BoundModel& m) { return m->n_frames(); })
      .def_prop_ro(
          "body_names", [](const BoundModel& m) { return names(m->bodies().subspan(1)); },
          "Names of the moving bodies, in the model's order.")
      .def_prop_ro(
          "joint_names", [](const BoundModel& m) { return names(m->joints()); },
          "Names of the joints, one for each moving body, in the model's order; `velocity_names` names the "
          "entries of v, a and tau.")
      .def_prop_ro(
          "coordinate_names", [](const BoundModel& m) { return coordinate_names(m); },
          "Names of the entries of q: the name of the joint, with a number as in `hip[0]` if it has several.")
      .def_prop_ro(
          "velocity_names", [](const BoundModel& m) { return velocity_names(m); },
          "Names of the entries of v, a and tau: the name of the joint, with a number as in `hip[0]` if it "
          "has several.")
      .def_prop_ro(
          "parameter_names", [](const BoundModel& m) { return parameter_names(m); },
          "Names of the entries of `parameters`: `link 1 m`, `link 1 m cx`, ..., `link 1 Iyz`.")
      .def_prop_ro(
          "joints",
          [](nb::handle_t<BoundModel> self) {
            const BoundModel& m = *nb::inst_ptr<BoundModel>(self);
            nb::list all;
            for (const Joint& joint : m->joints()) all.append(self.attr("joint")(to_str(joint.name)));
            return all;
          },
          nb::sig("def joints(self) -> list[Joint]"), "All joints, in the order of `joint_names`.")
      .def_prop_ro(
          "n_loops", [](const BoundModel& m) { return static_cast<int>(m->loops().all.size()); },
          "Number of loops and couplings.")
      .def_prop_ro(
          "loop_names", [](const BoundModel& m) { return names(m->loops().all); },
          "Names of the loops, then of the couplings, in the order of the drawing.")
      .def_prop_ro(
          "motion_names",
          [](const BoundModel& m) {
            std::vector<std::string> all;
            for (const MotionDescription& motion : m->motions()) all.push_back(motion_name(motion));
            return all;
          },
          "Names of the prescribed motions, in the order of the drawing.")
      .def_prop_ro(
          "drive_names",
          [](const BoundModel& m) {
            std::vector<std::string> all;
            for (const DriveDescription& drive : m->drives()) all.push_back(drive_name(drive, all.size()));
            return all;
          },
          "Names of the drives with states, in the order of the drawing.")
      .def_prop_ro(
          "parameters", [](const BoundModel& m) { return to_array(inertial_parameters(m)); },
          "Inertial parameters, (10 n_bodies,): m, m c, Theta (xx, yy, zz, xy, xz, yz) of each body in its "
          "own frame, with all that is fixed to it; tau = regressor(m, q, v, a) @ m.parameters.")
      .def_prop_ro(
          "velocity_limits", [](const BoundModel& m) { return to_array(velocity_limits(m)); },
          "Largest speed for each velocity, (nv,), rad/s or m/s; may be inf.")
      .def_prop_ro(
          "effort_limits", [](const BoundModel& m) { return to_array(effort_limits(m)); },
          "Largest drive force for each velocity, (nv,), N m or N; may be inf.")
      .def_prop_ro(
          "frame_names", [](const BoundModel& m) { return names(m->frames()); },
          "Names of the frames: \"ground\", the moving bodies, then the frames that are fixed to one of "
          "them.")
      .def_prop_ro(
          "gravity", [](const BoundModel& m) { return to_array(m->gravity()); },
          "Acceleration of gravity in the inertial frame, (3,), m/s^2.")
      .def_prop_ro(
          "total_mass", [](const BoundModel& m) { return m->total_mass(); }, "Mass of all moving bodies, kg.")
      .def_prop_ro(
          "warnings", [](const BoundModel& m) { return fault_list(m->warnings()); },
          nb::sig("def warnings(self) -> list[axode.Fault]"),
          "Warnings about the mechanism, which did not prevent its compilation.")
      .def("__repr__", &repr)
      .def("__str__", &table)
      .def("__copy__", [](const BoundModel& m) { return BoundModel(*m); })
      .def(
          "__deepcopy__", [](const BoundModel& m, nb::handle) { return BoundModel(*m); }, "memo"_a)
      .def(
          "__getstate__", [](const BoundModel& m) { return packed(m->description()); },
          nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
      .def(
          "__setstate__",
          [](BoundModel& m, const nb::tuple& state) {
            new (&m) BoundModel(ModelBuilder(unpacked(state)).build());
          },
          nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"));
  add_construction(model);
  add_lookup(model);
  add_edits(model);
  add_configurations(model);
}

}  // namespace axode::python
