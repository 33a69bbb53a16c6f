#include "axode/dynamics/newton_euler.hpp"
#include "bindings.hpp"
#include "choice.hpp"
#include "map_items.hpp"

namespace axode::python {
namespace {

/// Representations of an argument and of a result.
struct Source {
  Representation representation;
};
struct Target {
  Representation representation;
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
}  // namespace nanobind::detail

namespace axode::python {
namespace {

using namespace nb::literals;

// ------------------------------------------------------------------------------------------------------ inertia

void check_mass(const Inertia<>& M) {
  if (!(M.m > 0))
    throw nb::value_error(("M: its mass is " + std::to_string(M.m) + "; expected one above 0").c_str());
}

void add_inertia(nb::module_& lie) {
  add<double, Vec3<>, Sym3<>>(
      lie, "inertia", {"mass", "com", "Theta_c"},
      [](double m, const Vec3<>& c, const Sym3<>& Theta_c) { return inertia_from_com(m, c, Theta_c); }, R"(
M = [[Theta, h~], [-h~, m I]] from mass (...), center of mass (..., 3) and Theta_c (..., 3, 3): (..., 6, 6) (eq. Mb).

kg, m and kg m^2. Theta_c is the rotational inertia about the center of mass in the axes of the frame of M, symmetric;
h = m c, and Theta is about the frame's origin, by the parallel-axis theorem.

>>> M = axode.lie.inertia(2, [0, 0, 0.5], np.diag([0.1, 0.1, 0.02]))
>>> M[:3, :3].diagonal().round(3), float(M[3, 3])
(array([0.6 , 0.6 , 0.02]), 2.0)
)");
  add<SE3<>, Inertia<>>(
      lie, "transform_inertia", {"C", "M"},
      [](const SE3<>& C, const Inertia<>& M) { return transform(C, M); }, R"(
Ad_C^-T M Ad_C^-1, the inertia in the frame in which its own frame has the pose C: (..., 6, 6) (eq. Ms).

C (..., 4, 4) in m, M (..., 6, 6). With C_i, the pose of a body, M^s from M^b; with its rotation only, M^h.

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
The center of mass in the frame of an inertia matrix: (..., 6, 6) to (..., 3), m. ValueError where the mass is not > 0.

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

kg m^2. ValueError where the mass is not > 0.

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
How far an inertia matrix is from one that a distribution of mass can have: (..., 6, 6) to (...); such have >= 0.

The smallest second moment of mass about the center of mass, as a fraction of the largest principal moment.

>>> M = axode.lie.inertia(1, [0, 0, 0], np.diag([1, 1, 3]))  # no body: 3 > 1 + 1
>>> float(axode.lie.realisability(M).round(3))
-0.167
)");
}

// -------------------------------------------------------------------------------------------------- Newton-Euler

template <class Rep> Twist<Rep> as_twist(const Screw<>& X) { return {X.w, X.v}; }
template <class Rep> TwistRate<Rep> as_rate(const Screw<>& X) { return {X.w, X.v}; }
template <class CoScrew> Screw<> as_screw(const CoScrew& W) {
  const auto& [a, b] = W;
  return {a, b};
}

Array newton_euler_of(ArrayLike M, ArrayLike V, ArrayLike dV, Representation representation, ArrayLike R) {
  const Given<Inertia<>> inertia{"M", M};
  const Given<Screw<>> twist{"V", V}, rate{"dV", dV};
  const bool rotated = !nb::handle(R.given).is_none();
  if (rotated != (representation == Representation::mixed))
    throw nb::value_error(rotated
                              ? "R: expected none, it is for the mixed representation"
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

// ---------------------------------------------------------------------------------------- changes of representation

/// f(From{}, To{}).
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
The twist of a frame with pose C in another representation: (..., 4, 4), (..., 6) to (..., 6) (eqs. VhVb, VsVb, Vmbhs).

V is in the representation source, the result in target: body, spatial, hybrid, mixed; rad/s and m/s.

>>> C = axode.lie.exp([0, 0, np.pi / 2, 0, 0, 0])
>>> axode.lie.change_twist(C, [0, 0, 0, 1, 0, 0], "body", "hybrid").round(3)
array([0., 0., 0., 0., 1., 0.])
)");
  lie.def("change_twist_rate", &changed_rate, "C"_a, "V"_a, "dV"_a, "source"_a, "target"_a, R"(
The rate of the twist V of a frame with pose C in another representation: (..., 4, 4), (..., 6), (..., 6) to (..., 6).

V and dV, the time derivative of its components, are in the representation source, the result is the time derivative of
the components in target; rad/s^2 and m/s^2. To hybrid gives r'', the acceleration of the origin.

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
A wrench on a frame with pose C in another representation: (..., 4, 4), (..., 6) to (..., 6); its power stays.

Moment (N m), then force (N), in the representation source; the result is in target.

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
The momentum of a body with pose C in another representation: (..., 4, 4), (..., 6) to (..., 6).

Angular (N m s), then linear (N s), in the representation source; the result is in target.

>>> C = axode.lie.exp([0, 0, 0, 2, 0, 0])
>>> axode.lie.change_momentum(C, [0, 0, 0, 0, 10, 0], "body", "spatial")
array([ 0.,  0., 20.,  0., 10.,  0.])
)");
}

}  // namespace

void add_rigid_body(nb::module_& lie) {
  add_inertia(lie);
  lie.def("newton_euler", &newton_euler_of, "M"_a, "V"_a, "dV"_a, "representation"_a = "body",
          "R"_a = nb::none(), R"(
W = M V' - ad_V^T M V, the wrench that gives a body with twist V the acceleration dV: (..., 6) (eqs. NEb, NEs, NEh).

M (..., 6, 6) is in the axes and about the point of the representation: M^b in the body frame, M^s or M^h from it by
`transform_inertia`. For "mixed" it is M^b, and R (..., 3, 3) is the rotation of the body. V, dV (..., 6) in rad/s and
m/s, and per s; the result is in N m and N, without gravity. ValueError where R is missing, or given without need.

>>> M = axode.lie.inertia(2, [0, 0, 0], np.eye(3))
>>> axode.lie.newton_euler(M, [0, 0, 3, 0, 0, 0], [0, 0, 1, 0, 5, 0])
array([ 0.,  0.,  1.,  0., 10.,  0.])
)");
  add_changes(lie);
}

}  // namespace axode::python
