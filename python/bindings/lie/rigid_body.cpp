#include "axode/lie/newton_euler.hpp"
#include "axode/lie/solids.hpp"
#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/choice.hpp"
#include "python/bindings/support/map_items.hpp"

namespace axode::python {
namespace {

/// The representation of an argument (Source) and that of a result (Target).
struct Source {
  Representation representation;
};
struct Target {
  Representation representation;
};
/// A pair of frames F_j and F_k as Python gives it. It is annotated in Python as FramePair.
struct PairOfFrames {
  PyObject* given = nullptr;
};

}  // namespace

template <> struct Words<Source> : Words<Representation> {
  static constexpr const char* argument = "source";
  static Source value(std::size_t k) { return {Words<Representation>::value(k)}; }
};
template <> struct Words<Target> : Words<Representation> {
  static constexpr const char* argument = "target";
  static Target value(std::size_t k) { return {Words<Representation>::value(k)}; }
};

}  // namespace axode::python

namespace nanobind::detail {
template <> struct type_caster<axode::python::Source> : WordCaster<axode::python::Source> {};
template <> struct type_caster<axode::python::Target> : WordCaster<axode::python::Target> {};
template <> struct type_caster<axode::python::PairOfFrames> {
  NB_TYPE_CASTER(axode::python::PairOfFrames, const_name("axode.lie.FramePair"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.given = source.ptr();
    return true;
  }
};
}  // namespace nanobind::detail

namespace axode::python {
namespace {

using namespace nb::literals;

// --------------------------------------------------------------------------------------------------- inertia

void check_mass(const Inertia<>& M) {
  if (!(M.m > 0))
    throw nb::value_error(("M: its mass is " + to_text(M.m) + "; expected one above 0").c_str());
}

void add_inertia(nb::module_& lie) {
  add<double, Vec3<>, Sym3<>>(
      lie, "inertia", {"mass", "com", "Theta_c"},
      [](double m, const Vec3<>& c, const Sym3<>& Theta_c) { return inertia_from_com(m, c, Theta_c); }, R"(
The inertia matrix M = [[Theta, h~], [-h~, m I]] from mass (...), center of mass (..., 3) and Theta_c (..., 3, 3):
(..., 6, 6) (eq. Mb).

kg, m and kg m^2. Theta_c is the rotational inertia about the center of mass in the axes of the frame of M, symmetric;
h = m c, and Theta is about the frame's origin, by the parallel-axis theorem.

>>> M = axode.lie.inertia(2, [0, 0, 0.5], np.diag([0.1, 0.1, 0.02]))
>>> M[:3, :3].diagonal().round(3), float(M[3, 3])
(array([0.6 , 0.6 , 0.02]), 2.0)
)");
  add<SE3<>, Inertia<>>(
      lie, "transform_inertia", {"C", "M"},
      [](const SE3<>& C, const Inertia<>& M) { return transform(C, M); }, R"(
Ad_C^-T M Ad_C^-1, the inertia in another frame, in which the frame of M has the pose C: (..., 6, 6) (eq. Ms).

C has the shape (..., 4, 4), in m, and M (..., 6, 6). If C is the pose C_i of a body, M^b becomes M^s; if C has its
rotation only, M^b becomes M^h.

>>> M = axode.lie.inertia(2, [0, 0, 0], np.diag([0.1, 0.1, 0.02]))
>>> axode.lie.center_of_mass(axode.lie.transform_inertia(axode.lie.exp([0, 0, 1, 1, 0, 3]), M)).round(3)
array([0.841, 0.46 , 3.   ])
)");
  add<Inertia<>>(
      lie, "center_of_mass", {"M"},
      [](const Inertia<>& M) {
        check_mass(M);
        return center_of_mass(M);
      },
      R"(
The center of mass in the frame of an inertia matrix: (..., 6, 6) to (..., 3), m. ValueError if the mass is not > 0.

>>> axode.lie.center_of_mass(arm.body("link 2").M).round(4)
array([0.   , 0.003, 0.424])
)");
  add<Inertia<>>(
      lie, "inertia_about_com", {"M"},
      [](const Inertia<>& M) {
        check_mass(M);
        return inertia_about_com(M);
      },
      R"(
Theta_c, the rotational inertia about the center of mass, in the axes of the frame of M: (..., 6, 6) to (..., 3, 3).

The result is in kg m^2. ValueError if the mass is not > 0.

>>> M = axode.lie.inertia(2, [0, 0, 0.5], np.diag([0.1, 0.1, 0.02]))
>>> axode.lie.inertia_about_com(M).diagonal().round(3)
array([0.1 , 0.1 , 0.02])
)");
  add<Inertia<>>(
      lie, "realisability", {"M"},
      [](const Inertia<>& M) {
        check_mass(M);
        return realisability(M);
      },
      R"(
Measures whether a mass distribution can have an inertia matrix: (..., 6, 6) to (...). It can if the result is >= 0.

The result is the smallest second moment of mass about the center of mass, divided by the largest principal moment.

>>> M = axode.lie.inertia(1, [0, 0, 0], np.diag([1, 1, 3]))  # no body: 3 > 1 + 1
>>> float(axode.lie.realisability(M).round(3))
-0.167
)");
}

// ---------------------------------------------------------------------------------------------------- solids

std::vector<Vec3<>> vertices_from(ArrayLike given) {
  const Numbers numbers("vertices", given);
  if (numbers.axes() != 2 || !numbers.ends_with({numbers.length(0), 3}))
    numbers.wrong_shape("(N, 3), a row for each vertex, m");
  std::vector<Vec3<>> vertices;
  for (nb::ssize_t k = 0; k < numbers.size(); k += 3) vertices.push_back(vector_from(numbers.data() + k));
  return vertices;
}
std::vector<std::array<int, 3>> faces_from(ArrayLike given) {
  const Numbers numbers("faces", given);
  if (numbers.axes() != 2 || !numbers.ends_with({numbers.length(0), 3}))
    numbers.wrong_shape("(F, 3), the numbers of the vertices of each triangle");
  std::vector<std::array<int, 3>> faces(static_cast<std::size_t>(numbers.length(0)));
  for (std::size_t k = 0; k < 3 * faces.size(); ++k) {
    const double number = numbers.data()[k];
    if (number != std::floor(number) || std::abs(number) > 2147483647.0)
      throw nb::value_error(("faces: " + std::to_string(number) + " is not the number of a vertex").c_str());
    faces[k / 3][k % 3] = static_cast<int>(number);
  }
  return faces;
}

void add_solids(nb::module_& lie) {
  add<double, Vec3<>>(lie, "box_inertia", {"mass", "size"}, &box_inertia, R"(
Inertia matrix (..., 6, 6) of a box about its center, with edges of `size` (..., 3) along x, y and z; kg, m.

>>> axode.lie.box_inertia(12, [1, 2, 3])[:3, :3].diagonal()
array([13., 10.,  5.])
)");
  add<double, double>(lie, "sphere_inertia", {"mass", "radius"}, &sphere_inertia, R"(
Inertia matrix (..., 6, 6) of a ball about its center; kg, m.

>>> axode.lie.sphere_inertia(5, 1)[:3, :3].diagonal()
array([2., 2., 2.])
)");
  add<double, double, double>(lie, "cylinder_inertia", {"mass", "radius", "length"}, &cylinder_inertia, R"(
Inertia matrix (..., 6, 6) of a cylinder about its center, its axis along z; kg, m.

>>> axode.lie.cylinder_inertia(12, 1, 1)[:3, :3].diagonal()
array([4., 4., 6.])
)");
  add<double, double, double>(lie, "capsule_inertia", {"mass", "radius", "length"}, &capsule_inertia, R"(
Inertia matrix (..., 6, 6) of a cylinder along z with a half ball on each end, about its center; kg, m.

`length` is that of the cylinder without the half balls.

>>> axode.lie.capsule_inertia(1, 0.1, 0.5)[:3, :3].diagonal().round(5)
array([0.03637, 0.03637, 0.00479])
)");
  lie.def(
      "mesh_volume",
      [](ArrayLike vertices, ArrayLike faces) {
        return mesh_volume(vertices_from(vertices), faces_from(faces));
      },
      "vertices"_a, "faces"_a, R"(
The volume that a closed mesh encloses, m^3. vertices has shape (N, 3), and faces (F, 3) are triangles, given by the
numbers of their vertices.

Faces run counterclockwise as seen from outside. ValueError if the mesh is not closed or its faces are oriented
inwards.

>>> corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
>>> round(axode.lie.mesh_volume(*corner), 6)
0.166667
)");
  lie.def(
      "mesh_inertia",
      [](nb::handle mass, ArrayLike vertices, ArrayLike faces) {
        return to_array(mesh_inertia(number("mass", mass), vertices_from(vertices), faces_from(faces)));
      },
      "mass"_a, "vertices"_a, "faces"_a,
      nb::sig(
          "def mesh_inertia(mass: float, vertices: numpy.typing.ArrayLike, faces: numpy.typing.ArrayLike) -> "
          "numpy.typing.NDArray[numpy.float64]"),
      R"(
Inertia matrix (6, 6) of the solid that a closed mesh encloses, in the frame of the vertices; kg, m.

vertices (N, 3) and faces (F, 3) are those of `mesh_volume`. The mass is this volume times a density.

>>> corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
>>> axode.lie.center_of_mass(axode.lie.mesh_inertia(3, *corner))
array([0.25, 0.25, 0.25])
)");
}

// ---------------------------------------------------------------------------------------------- Newton-Euler

template <class Rep> Twist<Rep> as_twist(const Screw<>& X) { return {X.w, X.v}; }
template <class Rep> TwistRate<Rep> as_rate(const Screw<>& X) { return {X.w, X.v}; }
template <class CoScrew> Screw<> as_screw(const CoScrew& W) {
  const auto& [a, b] = W;
  return {a, b};
}
template <class Screwlike> Screw<> as_item(const Screwlike& X) { return as_screw(X); }
Inertia<> as_item(const Inertia<>& M) { return M; }

Array newton_euler_of(ArrayLike M, ArrayLike V, ArrayLike dV, Representation representation, ArrayLike R) {
  const Given<Inertia<>> inertia{"M", M};
  const Given<Screw<>> twist{"V", V}, rate{"dV", dV};
  const bool rotated = !nb::handle(R.given).is_none();
  if (rotated != (representation == Representation::mixed))
    throw nb::value_error(rotated
                              ? "R: expected None, because only the mixed representation needs it"
                              : "R: the mixed representation needs the rotation of the body, (..., 3, 3)");
  if (rotated)
    return map_items(
        [](const Inertia<>& M_b, const SO3<>& R_b, const Screw<>& X, const Screw<>& dX) {
          return as_screw(newton_euler(M_b, R_b, as_twist<Mixed>(X), as_rate<Mixed>(dX)));
        },
        inertia, Given<SO3<>>{"R", R}, twist, rate);
  const auto run = [&](auto rep) {
    using Rep = decltype(rep);
    return map_items(
        [](const Inertia<>& M_r, const Screw<>& X, const Screw<>& dX) {
          return as_screw(newton_euler(M_r, as_twist<Rep>(X), as_rate<Rep>(dX)));
        },
        inertia, twist, rate);
  };
  switch (representation) {
    case Representation::spatial: return run(Spatial{});
    case Representation::hybrid: return run(Hybrid{});
    default: return run(BodyFixed{});
  }
}

Array acceleration_of(ArrayLike C, ArrayLike M, ArrayLike V, ArrayLike W, Representation representation) {
  return with_representation(representation, [&]<class Rep>(Rep) {
    return map_items(
        [](const SE3<>& pose, const Inertia<>& M_b, const Screw<>& X, const Screw<>& Y) {
          check_mass(M_b);
          return as_screw(acceleration(pose, M_b, as_twist<Rep>(X), Wrench<Rep>{Y.w, Y.v}));
        },
        Given<SE3<>>{"C", C}, Given<Inertia<>>{"M", M}, Given<Screw<>>{"V", V}, Given<Screw<>>{"W", W});
  });
}

// -------------------------------------------------------------------------- measured at F_j, resolved in F_k

/// Calls f(jk, x, ...) for every item of arrays. jk is a pair of frames j and k, which is a tuple of four
/// entries in Python: position r_j and velocity dr_j of the origin of j, rotation R_k and angular velocity
/// w_k of k. Each entry may be an array with one item for each call.
template <class F, class... T> Array in_frames(PairOfFrames jk, const F& f, const Given<T>&... given) {
  const nb::handle pair(jk.given);
  if (!PyTuple_Check(jk.given) || nb::len(pair) != 4)
    throw nb::value_error("jk: expected an axode.lie.FramePair, (r_j, dr_j, R_k, w_k)");
  const std::array<nb::object, 4> part{pair[0], pair[1], pair[2], pair[3]};
  return map_items(
      [&](const Vec3<>& r_j, const Vec3<>& dr_j, const SO3<>& R_k, const Vec3<>& w_k, const T&... x) {
        return as_item(f(FramePair<>{r_j, dr_j, R_k, w_k}, x...));
      },
      Given<Vec3<>>{"jk.r_j", {part[0].ptr()}}, Given<Vec3<>>{"jk.dr_j", {part[1].ptr()}},
      Given<SO3<>>{"jk.R_k", {part[2].ptr()}}, Given<Vec3<>>{"jk.w_k", {part[3].ptr()}}, given...);
}

void add_frame_pairs(nb::module_& lie) {
  lie.def(
      "twist_in_frames",
      [](PairOfFrames jk, ArrayLike V) {
        return in_frames(
            jk, [](const FramePair<>& pair, const Screw<>& X) { return change(pair, as_twist<Spatial>(X)); },
            Given<Screw<>>{"V", V});
      },
      "jk"_a, "V"_a, R"(
^kV^j, a twist measured at the origin of a frame F_j and resolved in a frame F_k, from the spatial twist: (..., 6).

It is in rad/s and m/s; see `FramePair`.

>>> jk = axode.lie.FramePair(r_j=[1, 0, 0], dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 0])
>>> axode.lie.twist_in_frames(jk, [0, 0, 2, 0, 0, 0])
array([0., 0., 2., 0., 2., 0.])
)");
  lie.def(
      "twist_rate_in_frames",
      [](PairOfFrames jk, ArrayLike V, ArrayLike dV) {
        return in_frames(
            jk,
            [](const FramePair<>& pair, const Screw<>& X, const Screw<>& dX) {
              return change(pair, as_twist<Spatial>(X), as_rate<Spatial>(dX));
            },
            Given<Screw<>>{"V", V}, Given<Screw<>>{"dV", dV});
      },
      "jk"_a, "V"_a, "dV"_a, R"(
The time derivative of the components of ^kV^j, from the spatial twist and its rate: (..., 6), rad/s^2 and m/s^2.

>>> jk = axode.lie.FramePair(r_j=[0, 0, 0], dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 1])
>>> axode.lie.twist_rate_in_frames(jk, [0, 0, 0, 1, 0, 0], np.zeros(6))  # F_k turns away from a steady twist
array([ 0.,  0.,  0.,  0., -1.,  0.])
)");
  lie.def(
      "wrench_in_frames",
      [](PairOfFrames jk, ArrayLike W) {
        return in_frames(
            jk,
            [](const FramePair<>& pair, const Screw<>& Y) {
              return change(pair, Wrench<Spatial>{Y.w, Y.v});
            },
            Given<Screw<>>{"W", W});
      },
      "jk"_a, "W"_a, R"(
A wrench measured at the origin of F_j and resolved in F_k, from the spatial wrench: (..., 6), N m and N.

>>> jk = axode.lie.FramePair(r_j=[2, 0, 0], dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 0])
>>> axode.lie.wrench_in_frames(jk, [0, 0, 0, 0, 10, 0])
array([  0.,   0., -20.,   0.,  10.,   0.])
)");
  lie.def(
      "inertia_in_frames",
      [](PairOfFrames jk, ArrayLike C, ArrayLike M) {
        return in_frames(
            jk,
            [](const FramePair<>& pair, const SE3<>& pose, const Inertia<>& M_b) {
              return inertia_in_frames(pair, pose, M_b);
            },
            Given<SE3<>>{"C", C}, Given<Inertia<>>{"M", M});
      },
      "jk"_a, "C"_a, "M"_a, R"(
The inertia matrix ^kM^j of a body with the pose C (..., 4, 4) and the inertia matrix M (..., 6, 6) in its own frame:
(..., 6, 6).

>>> jk = axode.lie.FramePair(r_j=[1, 0, 0], dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 0])
>>> M = axode.lie.inertia(2, [0, 0, 0], np.eye(3))
>>> axode.lie.center_of_mass(axode.lie.inertia_in_frames(jk, np.eye(4), M))
array([-1.,  0.,  0.])
)");
  lie.def(
      "newton_euler_in_frames",
      [](PairOfFrames jk, ArrayLike M, ArrayLike V, ArrayLike dV) {
        return in_frames(
            jk,
            [](const FramePair<>& pair, const Inertia<>& M_jk, const Screw<>& X, const Screw<>& dX) {
              return newton_euler(M_jk, pair, as_twist<InFrames>(X), as_rate<InFrames>(dX));
            },
            Given<Inertia<>>{"M", M}, Given<Screw<>>{"V", V}, Given<Screw<>>{"dV", dV});
      },
      "jk"_a, "M"_a, "V"_a, "dV"_a, R"(
The wrench ^kW^j that a body needs for its motion, all measured at F_j and resolved in F_k (eq. NEij): (..., 6).

M (..., 6, 6), V, dV (..., 6) as `inertia_in_frames`, `twist_in_frames` and `twist_rate_in_frames` give them; N m and N,
without gravity.

>>> jk = axode.lie.FramePair(r_j=[0, 0, 0], dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 0])
>>> axode.lie.newton_euler_in_frames(jk, axode.lie.inertia(2, [0, 0, 0], np.eye(3)), np.zeros(6), [0, 0, 1, 0, 5, 0])
array([ 0.,  0.,  1.,  0., 10.,  0.])
)");
}

// --------------------------------------------------------------------------------- changes of representation

/// Calls f(From{}, To{}) with the types of the representations of source and target.
template <class F> Screw<> with_both(const Source& source, const Target& target, const F& f) {
  return with_representation(source.representation, [&](auto from) {
    return with_representation(target.representation, [&](auto to) { return as_screw(f(from, to)); });
  });
}

template <template <class, class> class Kind>
Array changed(const char* name, ArrayLike C, ArrayLike x, const Source& source, const Target& target) {
  return map_items(
      [&](const SE3<>& pose, const Screw<>& X) {
        return with_both(source, target, [&](auto from, auto to) {
          return change<decltype(to)>(pose, Kind<decltype(from), double>{X.w, X.v});
        });
      },
      Given<SE3<>>{"C", C}, Given<Screw<>>{name, x});
}

Array changed_rate(ArrayLike C, ArrayLike V, ArrayLike dV, const Source& source, const Target& target) {
  return map_items(
      [&](const SE3<>& pose, const Screw<>& X, const Screw<>& dX) {
        return with_both(source, target, [&](auto from, auto to) {
          return change<decltype(to)>(pose, as_twist<decltype(from)>(X), as_rate<decltype(from)>(dX));
        });
      },
      Given<SE3<>>{"C", C}, Given<Screw<>>{"V", V}, Given<Screw<>>{"dV", dV});
}

void add_changes(nb::module_& lie) {
  lie.def(
      "change_twist",
      [](ArrayLike C, ArrayLike V, Source source, Target target) {
        return changed<Twist>("V", C, V, source, target);
      },
      "C"_a, "V"_a, "source"_a, "target"_a, R"(
Converts the twist of a frame with pose C to another representation: (..., 4, 4), (..., 6) to (..., 6) (eqs. VhVb,
VsVb, Vmbhs).

V is in the representation source, the result in target: body, spatial, hybrid, mixed; rad/s and m/s.

>>> C = axode.lie.exp([0, 0, np.pi / 2, 0, 0, 0])
>>> axode.lie.change_twist(C, [0, 0, 0, 1, 0, 0], "body", "hybrid").round(3)
array([0., 0., 0., 0., 1., 0.])
)");
  lie.def("change_twist_rate", &changed_rate, "C"_a, "V"_a, "dV"_a, "source"_a, "target"_a, R"(
Converts the rate of the twist V of a frame with pose C to another representation: (..., 4, 4), (..., 6), (..., 6) to
(..., 6).

V and dV, the time derivative of its components, are in the representation source, the result is the time derivative
of the components in target; rad/s^2 and m/s^2. In hybrid representation, its linear part is r'', the acceleration of
the origin.

>>> V, dV = [0, 0, 2, 3, 0, 0], np.zeros(6)  # a steady body-fixed twist: on a circle
>>> axode.lie.change_twist_rate(np.eye(4), V, dV, "body", "hybrid")
array([0., 0., 0., 0., 6., 0.])
)");
  lie.def(
      "change_wrench",
      [](ArrayLike C, ArrayLike W, Source source, Target target) {
        return changed<Wrench>("W", C, W, source, target);
      },
      "C"_a, "W"_a, "source"_a, "target"_a, R"(
Converts a wrench on a frame with pose C to another representation: (..., 4, 4), (..., 6) to (..., 6). Its power does
not change.

W has the moment (N m), then the force (N), in the representation source; the result is in the representation target.

>>> C = axode.lie.exp([0, 0, 0, 2, 0, 0])
>>> axode.lie.change_wrench(C, [0, 0, 0, 0, 10, 0], "body", "spatial")  # about the inertial origin
array([ 0.,  0., 20.,  0., 10.,  0.])
)");
  lie.def(
      "change_momentum",
      [](ArrayLike C, ArrayLike Pi, Source source, Target target) {
        return changed<Momentum>("Pi", C, Pi, source, target);
      },
      "C"_a, "Pi"_a, "source"_a, "target"_a, R"(
Converts the momentum of a body with pose C to another representation: (..., 4, 4), (..., 6) to (..., 6).

Pi is angular (N m s), then linear (N s), in the representation source; the result is in the representation target.

>>> C = axode.lie.exp([0, 0, 0, 2, 0, 0])
>>> axode.lie.change_momentum(C, [0, 0, 0, 0, 10, 0], "body", "spatial")
array([ 0.,  0., 20.,  0., 10.,  0.])
)");
}

}  // namespace

void add_rigid_body(nb::module_& lie) {
  add_inertia(lie);
  add_solids(lie);
  lie.def("newton_euler", &newton_euler_of, "M"_a, "V"_a, "dV"_a, "representation"_a = "body",
          "R"_a = nb::none(), R"(
W = M V' - ad_V^T M V, the wrench that gives a body with twist V the acceleration dV: (..., 6) (eqs. NEb, NEs, NEh).

M (..., 6, 6) is in the axes and about the point of the representation: M^b in the body frame, M^s or M^h from it by
`transform_inertia`. For "mixed" it is M^b, and R (..., 3, 3) is the rotation of the body. V, dV (..., 6) in rad/s and
m/s, and per s; the result is in N m and N, without gravity. ValueError if R is missing, or if it is given but not
needed.

>>> M = axode.lie.inertia(2, [0, 0, 0], np.eye(3))
>>> axode.lie.newton_euler(M, [0, 0, 3, 0, 0, 0], [0, 0, 1, 0, 5, 0])
array([ 0.,  0.,  1.,  0., 10.,  0.])
)");
  lie.def("acceleration", &acceleration_of, "C"_a, "M"_a, "V"_a, "W"_a, "representation"_a = "body", R"(
V', the acceleration of a body with the twist V under the resultant wrench W, the inverse of Newton-Euler: (..., 6).

C (..., 4, 4) is the pose of the body and M (..., 6, 6) its inertia matrix, always in the body frame; V, W (..., 6)
and the result are in the representation; rad/s^2 and m/s^2. ValueError if the mass is not > 0.

>>> M = axode.lie.inertia(2, [0, 0, 0], np.eye(3))
>>> axode.lie.acceleration(np.eye(4), M, np.zeros(6), [0, 0, 1, 0, 10, 0], "hybrid")
array([0., 0., 1., 0., 5., 0.])
)");
  add_frame_pairs(lie);
  add_changes(lie);
}

}  // namespace axode::python
