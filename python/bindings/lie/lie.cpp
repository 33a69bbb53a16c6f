#include "axode/lie.hpp"

#include <nanobind/stl/string.h>

#include <cmath>

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/map_items.hpp"
#include "python/bindings/support/named_tuple.hpp"

namespace axode::python {

/// A pitch in m/rad; it is infinite for a translation.
struct Pitch {
  double h;
};
template <> inline constexpr Infinities infinities_of<Pitch> = Infinities::allowed;
template <> struct Item<Pitch> : Item<double> {
  static Pitch read(const char* argument, const double* from) {
    if (*from == -std::numeric_limits<double>::infinity())
      throw nb::value_error((argument + std::string(" is -inf; expected a pitch in m/rad, or inf")).c_str());
    return {*from};
  }
};

namespace {

using namespace nb::literals;

Array exchange_halves_of(ArrayLike x, int axis) {
  const Numbers numbers("x", x);
  const int at = axis < 0 ? axis + numbers.axes() : axis;
  if (at < 0 || at >= numbers.axes() || numbers.length(at) != 6)
    numbers.wrong_shape("with 6 entries along axis " + std::to_string(axis));
  NewArray out(first_axes(numbers, numbers.axes()));
  nb::ssize_t half = 3;  // numbers in each half
  for (int behind = at + 1; behind < numbers.axes(); ++behind) half *= numbers.length(behind);
  const double* from = numbers.data();
  for (nb::ssize_t k = 0; k < numbers.size(); k += 2 * half) {
    std::copy_n(from + k, half, out.data() + k + half);
    std::copy_n(from + k + half, half, out.data() + k);
  }
  return out.array();
}

using Vector4 = Eigen::Vector4d;
using Matrix3 = Eigen::Matrix3d;
using Matrix4 = Eigen::Matrix4d;

void add_groups(nb::module_& lie) {
  add<Screw<>>(
      lie, "exp", {"X"}, [](const Screw<>& X) { return exp(X); }, R"(
exp X, the displacement by a screw motion along X: (..., 6) to (..., 4, 4), rad and m (eq. POEX).

>>> axode.lie.exp([0, 0, np.pi / 2, 0, 0, 0.1]).round(3)
array([[ 0. , -1. ,  0. ,  0. ],
       [ 1. ,  0. ,  0. ,  0. ],
       [ 0. ,  0. ,  1. ,  0.1],
       [ 0. ,  0. ,  0. ,  1. ]])
)");
  add<SE3<>>(
      lie, "log", {"C"}, [](const SE3<>& C) { return log(C); }, R"(
log C, the screw X with exp(X) = C and its angle in [0, pi]: (..., 4, 4) to (..., 6), rad and m.

At the angle pi, both directions of the axis are right. ValueError if C is not a pose.

>>> axode.lie.log(axode.lie.exp([0.1, 0.2, 0.3, 1, 2, 3])).round(3)
array([0.1, 0.2, 0.3, 1. , 2. , 3. ])
)");
  add<Vec3<>>(
      lie, "exp_SO3", {"xi"}, [](const Vec3<>& xi) { return exp_SO3(xi); }, R"(
exp xi, the rotation by the rotation vector xi: (..., 3) to (..., 3, 3), rad; Rodrigues' formula.

>>> axode.lie.exp_SO3([0, 0, np.pi / 2]).round(3)
array([[ 0., -1.,  0.],
       [ 1.,  0.,  0.],
       [ 0.,  0.,  1.]])
)");
  add<SO3<>>(
      lie, "log_SO3", {"R"}, [](const SO3<>& R) { return log_SO3(R); }, R"(
log R, the rotation vector with its angle in [0, pi]: (..., 3, 3) to (..., 3), rad.

At the angle pi, both signs are right. ValueError if R is not a rotation.

>>> axode.lie.log_SO3(axode.lie.exp_SO3([0.1, 0.2, 0.3])).round(3)
array([0.1, 0.2, 0.3])
)");
  add<SE3<>>(
      lie, "inverse", {"C"}, [](const SE3<>& C) { return inverse(C); }, R"(
The inverse of a pose, [[R^T, -R^T r], [0, 1]]: (..., 4, 4) to (..., 4, 4), m. ValueError if C is not a pose.

>>> C_i, C_j = axode.poses(arm, arm.random())[[2, 3]]
>>> C_ij = axode.lie.inverse(C_i) @ C_j  # the pose of body 3 in body 2
>>> C_ij.shape
(4, 4)
)");
  add<Vec3<>>(
      lie, "rotation_to", {"n"},
      [](const Vec3<>& n) {
        check_unit("n", "unit vector", norm(n));
        return rotation_to(n);
      },
      R"(
The shortest rotation that takes the z-axis to the unit vector n: (..., 3) to (..., 3, 3).

If n = -z, it is half a turn about the x-axis. It places the in-plane axes of a planar joint with normal n.

>>> (axode.lie.rotation_to([0.6, 0, 0.8]) @ [0, 0, 1]).round(3)
array([0.6, 0. , 0.8])
)");
}

void add_quaternions(nb::module_& lie) {
  add<SO3<>>(
      lie, "quaternion", {"R"}, [](const SO3<>& R) { return quaternion(R); }, R"(
The unit quaternion x y z w of a rotation, with w >= 0: (..., 3, 3) to (..., 4).

ValueError if R is not a rotation.

>>> axode.lie.quaternion(np.diag([1, -1, -1]))
array([1., 0., 0., 0.])
)");
  add<Quaternion<>>(
      lie, "rotation", {"a"}, [](const Quaternion<>& a) { return rotation(a); }, R"(
The rotation of a unit quaternion x y z w: (..., 4) to (..., 3, 3).

Nothing is normalised: ValueError if the norm differs from 1 by more than 1e-6.

>>> axode.lie.rotation([1, 0, 0, 0])
array([[ 1.,  0.,  0.],
       [ 0., -1.,  0.],
       [ 0.,  0., -1.]])
)");
  add<Quaternion<>, Quaternion<>>(
      lie, "quaternion_product", {"a", "b"},
      [](const Quaternion<>& a, const Quaternion<>& b) { return a * b; }, R"(
The product of two quaternions x y z w, the rotation of b followed by that of a: (..., 4), (..., 4) to (..., 4).

The inverse of a is a * [-1, -1, -1, 1]. ValueError if a norm differs from 1 by more than 1e-6.

>>> axode.lie.quaternion_product([0, 0, 0.6, 0.8], [0, 0, 0.6, 0.8]).round(3)
array([0.  , 0.  , 0.96, 0.28])
)");
  add<Vec3<>>(
      lie, "exp_quaternion", {"xi"}, [](const Vec3<>& xi) { return exp_quaternion(xi); }, R"(
The unit quaternion x y z w of the rotation by the rotation vector xi: (..., 3) to (..., 4), rad.

>>> axode.lie.exp_quaternion([0, 0, np.pi / 2]).round(4)
array([0.    , 0.    , 0.7071, 0.7071])
)");
  add<Quaternion<>>(
      lie, "log_quaternion", {"a"}, [](const Quaternion<>& a) { return log_quaternion(a); }, R"(
The rotation vector of a unit quaternion x y z w, its angle in [0, pi]: (..., 4) to (..., 3), rad.

a and -a give the same result. ValueError if the norm differs from 1 by more than 1e-6.

>>> axode.lie.log_quaternion(-axode.lie.exp_quaternion([0.1, 0.2, 0.3])).round(3)
array([0.1, 0.2, 0.3])
)");
  add<Vector4>(
      lie, "scalar_first", {"a"},
      [](const Vector4& a) {
        return Vector4{a[3], a[0], a[1], a[2]};
      },
      R"(
Quaternions w x y z, the order of MuJoCo and Drake, from quaternions x y z w: (..., 4) to (..., 4).

>>> axode.lie.scalar_first([0.1, 0.2, 0.3, 0.9])
array([0.9, 0.1, 0.2, 0.3])
)");
  add<Vector4>(
      lie, "from_scalar_first", {"a"},
      [](const Vector4& a) {
        return Vector4{a[1], a[2], a[3], a[0]};
      },
      R"(
Quaternions x y z w from quaternions w x y z: (..., 4) to (..., 4).

>>> axode.lie.from_scalar_first([0.9, 0.1, 0.2, 0.3])
array([0.1, 0.2, 0.3, 0.9])
)");
}

void add_linear_maps(nb::module_& lie) {
  add<Vec3<>>(
      lie, "skew", {"a"}, [](const Vec3<>& a) { return skew(a); }, R"(
The skew-symmetric matrix of a, which maps b to a x b: (..., 3) to (..., 3, 3).

>>> axode.lie.skew([1, 2, 3]) @ [0, 0, 1]
array([ 2., -1.,  0.])
)");
  add<Matrix3>(
      lie, "from_skew", {"A"},
      [](const Matrix3& A) {
        const Vec3<> a = from_skew(A);
        check_structure("A", "a skew-symmetric matrix", A, skew(a));
        return a;
      },
      R"(
The vector a of a matrix skew(a): (..., 3, 3) to (..., 3).

ValueError if A differs from a skew-symmetric matrix by more than 1e-6 of its largest entry.

>>> axode.lie.from_skew(axode.lie.skew([1, 2, 3]))
array([1., 2., 3.])
)");
  add<Screw<>>(
      lie, "hat", {"X"}, [](const Screw<>& X) { return hat(X); }, R"(
The matrix [[w~, v], [0, 0]] of a screw (w; v): (..., 6) to (..., 4, 4) (eq. LieBracketSE3).

>>> axode.lie.hat([1, 2, 3, 4, 5, 6])
array([[ 0., -3.,  2.,  4.],
       [ 3.,  0., -1.,  5.],
       [-2.,  1.,  0.,  6.],
       [ 0.,  0.,  0.,  0.]])
)");
  add<Matrix4>(
      lie, "from_hat", {"A"},
      [](const Matrix4& A) {
        const Screw<> X = from_hat(A);
        check_structure("A", "a matrix [[w~, v], [0, 0]]", A, hat(X));
        return X;
      },
      R"(
The screw X of a matrix hat(X): (..., 4, 4) to (..., 6).

ValueError if A differs from a matrix [[w~, v], [0, 0]] by more than 1e-6 of its largest entry.

>>> axode.lie.from_hat(axode.lie.hat([1, 2, 3, 4, 5, 6]))
array([1., 2., 3., 4., 5., 6.])
)");
  add<SE3<>>(
      lie, "Ad", {"C"}, [](const SE3<>& C) { return Ad_matrix(C); }, R"(
Ad_C = [[R, 0], [r~ R, R]], which transforms screws from the frame with pose C: (..., 4, 4) to (..., 6, 6) (eq. Ad).

Hence V^s = Ad(C) @ V^b for twists, and W^b = Ad(C).T @ W^s for wrenches. ValueError if C is not a pose.

>>> C = axode.lie.exp([0, 0, 0, 1, 0, 0])
>>> axode.lie.Ad(C) @ [0, 0, 1, 0, 0, 0]  # turning about an axis at x = 1
array([ 0.,  0.,  1.,  0., -1.,  0.])
)");
  add<Screw<>>(
      lie, "ad", {"X"}, [](const Screw<>& X) { return ad_matrix(X); }, R"(
ad_X = [[w~, 0], [v~, w~]], so that ad(X) @ Z = [X, Z]: (..., 6) to (..., 6, 6) (eqs. ScrewProd, adse3).

>>> axode.lie.ad([0, 0, 1, 0, 0, 0]) @ [0, 0, 0, 1, 0, 0]
array([0., 0., 0., 0., 1., 0.])
)");
  add<Screw<>>(
      lie, "dexp", {"X"}, [](const Screw<>& X) { return dexp_matrix(X); }, R"(
dexp_X, right-trivialised, (d/dt exp X) exp(-X) = hat(dexp_X X'): (..., 6) to (..., 6, 6) (eq. Vdexp).

For C = exp X the spatial twist is dexp(X) @ dX, and the body-fixed one is dexp(-X) @ dX.

>>> axode.lie.dexp(np.zeros(6)).round(3).tolist() == np.eye(6).tolist()
True
)");
  add<Screw<>>(
      lie, "dexp_inv", {"X"}, [](const Screw<>& X) { return dexp_inv_matrix(X); }, R"(
The inverse of dexp(X): (..., 6) to (..., 6, 6). It does not exist at the angles 2 pi, 4 pi, ...

>>> X = np.array([0.1, 0.2, 0.3, 1, 2, 3])
>>> np.allclose(axode.lie.dexp_inv(X) @ axode.lie.dexp(X), np.eye(6))
True
)");
  add<Screw<>, Screw<>>(
      lie, "ddexp", {"X", "U"}, [](const Screw<>& X, const Screw<>& U) { return ddexp_matrix(X, U); }, R"(
D_U dexp_X, the derivative of dexp(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> X, U = np.array([0.1, 0.2, 0.3, 1, 2, 3]), np.ones(6)
>>> step = (axode.lie.dexp(X + 1e-5 * U) - axode.lie.dexp(X - 1e-5 * U)) / 2e-5
>>> np.allclose(axode.lie.ddexp(X, U), step)
True
)");
  add<Screw<>, Screw<>>(
      lie, "ddexp_inv", {"X", "U"}, [](const Screw<>& X, const Screw<>& U) { return ddexp_inv_matrix(X, U); },
      R"(
The derivative of dexp_inv(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> axode.lie.ddexp_inv(np.zeros(6), [0, 0, 1, 0, 0, 0])[:3, :3]  # -ad_U / 2
array([[ 0. ,  0.5,  0. ],
       [-0.5,  0. ,  0. ],
       [ 0. ,  0. ,  0. ]])
)");
  add<Vec3<>>(
      lie, "dexp_SO3", {"xi"}, [](const Vec3<>& xi) { return dexp_matrix(xi); }, R"(
dexp_xi on SO(3), right-trivialised: (..., 3) to (..., 3, 3).

For R = exp xi the angular velocity is dexp_SO3(xi) @ dxi in inertial axes, dexp_SO3(-xi) @ dxi in body axes.

>>> axode.lie.dexp_SO3([0, 0, np.pi]).round(4)
array([[ 0.    , -0.6366,  0.    ],
       [ 0.6366,  0.    ,  0.    ],
       [ 0.    ,  0.    ,  1.    ]])
)");
  add<Vec3<>>(
      lie, "dexp_inv_SO3", {"xi"}, [](const Vec3<>& xi) { return dexp_inv_matrix(xi); }, R"(
The inverse of dexp_SO3(xi): (..., 3) to (..., 3, 3). It does not exist at the angles 2 pi, 4 pi, ...

>>> xi = np.array([0.1, 0.2, 0.3])
>>> np.allclose(axode.lie.dexp_inv_SO3(xi) @ axode.lie.dexp_SO3(xi), np.eye(3))
True
)");
  add<Vec3<>, Vec3<>>(
      lie, "ddexp_SO3", {"xi", "eta"},
      [](const Vec3<>& xi, const Vec3<>& eta) { return ddexp_matrix(xi, eta); }, R"(
The derivative of dexp_SO3(xi) when xi moves along eta: (..., 3), (..., 3) to (..., 3, 3).

>>> axode.lie.ddexp_SO3(np.zeros(3), [0, 0, 1])  # eta~ / 2
array([[ 0. , -0.5,  0. ],
       [ 0.5,  0. ,  0. ],
       [ 0. ,  0. ,  0. ]])
)");
  add<Vec3<>, Vec3<>>(
      lie, "ddexp_inv_SO3", {"xi", "eta"},
      [](const Vec3<>& xi, const Vec3<>& eta) { return ddexp_inv_matrix(xi, eta); }, R"(
The derivative of dexp_inv_SO3(xi) when xi moves along eta: (..., 3), (..., 3) to (..., 3, 3).

>>> axode.lie.ddexp_inv_SO3(np.zeros(3), [0, 0, 1])  # -eta~ / 2
array([[ 0. ,  0.5,  0. ],
       [-0.5,  0. ,  0. ],
       [ 0. ,  0. ,  0. ]])
)");
}

void add_screws(nb::module_& lie) {
  lie.def(
      "screw",
      [](ArrayLike e, ArrayLike p, ArrayLike h, ArrayLike magnitude) {
        return map_items(
            [](const Vec3<>& direction, const Vec3<>& point, const Pitch& pitch, double size) {
              if (size != 0) check_unit("e", "unit vector", norm(direction));
              return screw(ScrewAxis<>{direction, point, pitch.h, size});
            },
            Given<Vec3<>>{"e", e}, Given<Vec3<>>{"p", p}, Given<Pitch>{"h", h},
            Given<double>{"magnitude", magnitude});
      },
      "e"_a, "p"_a, "h"_a = 0.0, "magnitude"_a = 1.0, R"(
magnitude (e; p x e + h e), the screw of a line with direction e through the point p: (..., 6).

e (..., 3) is a unit vector, p (..., 3) in m, the pitch h (...) in m/rad; with h = inf the result is the translation
magnitude (0; e). It is the screw of a joint; with a force (N) as the magnitude, and with its two halves exchanged, it
is a wrench. `screw(*screw_axis(X))` is X. ValueError if e is not a unit vector.

>>> axode.lie.screw([0, 0, 1], [1, 0, 0], 0.01 / (2 * np.pi)).round(4)  # a lead of 10 mm
array([ 0.    ,  0.    ,  1.    ,  0.    , -1.    ,  0.0016])
)");
  lie.def(
      "screw_axis",
      [](ArrayLike X) {
        auto [e, p, h, magnitude] = map_items(
            [](const Screw<>& x) {
              const ScrewAxis<> axis = screw_axis(x);
              return std::tuple(axis.e, axis.p, axis.h, axis.magnitude);
            },
            Given<Screw<>>{"X", X});
        return named_tuple("axode.lie", "ScrewAxis", e, p, h, magnitude);
      },
      "X"_a, nb::sig("def screw_axis(X: numpy.typing.ArrayLike) -> axode.lie.ScrewAxis"), R"(
(e, p, h, magnitude) of screws (..., 6): direction, the axis point nearest to the origin (m), pitch (m/rad), size.

Shapes (..., 3), (..., 3), (...), (...). The magnitude is the norm of the angular part, or of the linear part if the
angular part is 0. In this case it is a translation, whose pitch is inf and whose p is 0. The axis is in the frame of
X: in the inertial frame for a spatial twist, in the body frame for a body-fixed one. The central axis of a wrench is
`screw_axis(exchange_halves(W))`.

>>> axis = axode.lie.screw_axis([0, 0, 2, 0, -2, 1])
>>> axis.e, float(axis.h), float(axis.magnitude)
(array([0., 0., 1.]), 0.5, 2.0)
)");
  add<Screw<>>(
      lie, "pluecker", {"X"},
      [](const Screw<>& x) {
        const PlueckerLine<> line = pluecker(screw_axis(x));
        return Screw<>{line.e, line.moment};
      },
      R"(
Pluecker coordinates (e; p x e) of the axis of a screw: (..., 6) to (..., 6); (e; 0) for a translation.

>>> axode.lie.pluecker([0, 0, 2, 0, -2, 1])
array([ 0.,  0.,  1.,  0., -1.,  0.])
)");
  add<Screw<>, Screw<>>(
      lie, "reciprocal_product", {"X", "Z"},
      [](const Screw<>& X, const Screw<>& Z) { return reciprocal_product(X, Z); }, R"(
The reciprocal product w_X . v_Z + v_X . w_Z: (..., 6), (..., 6) to (...). It is 0 if two axes without pitch meet or
are parallel.

>>> X, Z = axode.lie.screw([0, 0, 1], [0, 0, 0]), axode.lie.screw([1, 0, 0], [0, 0.5, 0])
>>> float(axode.lie.reciprocal_product(X, Z))  # 0.5 m apart, at a right angle
-0.5
)");
  lie.def("exchange_halves", &exchange_halves_of, "x"_a, "axis"_a = -1, R"(
Converts from linear part first (Pinocchio, ROS) to angular part first, or back, along an axis of length 6; it is its
own inverse.

For twists (..., 6) this is the last axis, for the rows of a Jacobian (6, n) it is axis 0; for an inertia matrix
exchange both, one after the other. ValueError if there is no such axis, or if it has another length.

>>> axode.lie.exchange_halves([1, 2, 3, 4, 5, 6])
array([4., 5., 6., 1., 2., 3.])
)");
}

}  // namespace

void add_lie(nb::module_& lie) {
  add_groups(lie);
  add_quaternions(lie);
  add_linear_maps(lie);
  add_screws(lie);
}

}  // namespace axode::python
