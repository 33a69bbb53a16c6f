#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/building/placement.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "python/bindings/model/model.hpp"
#include "python/bindings/states/states.hpp"
#include "python/bindings/support/bindings.hpp"
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

std::string repr(const BoundModel& model) {
  const auto count = [](int n, const char* one, const char* many) {
    return std::to_string(n) + (n == 1 ? one : many);
  };
  return "Model(\"" + model->name() + "\": " + count(model->n_bodies(), " moving body", " moving bodies") +
         ", nq = " + std::to_string(model->nq()) + ", nv = " + std::to_string(model->nv()) + ", " +
         count(model->n_frames(), " frame", " frames") + ", " + rounded(model->total_mass()) + " kg)";
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
  add_joint_and_body(module);
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
