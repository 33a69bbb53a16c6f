#include "axode/lie/cayley.hpp"

#include "python/bindings/support/bindings.hpp"
#include "python/bindings/support/map_items.hpp"

namespace axode::python {
namespace {

/// Throws nb::value_error if R is a rotation by half a turn, for which no Cayley coordinates exist.
void check_less_than_half_a_turn(const char* argument, const SO3<>& R) {
  constexpr double rounding = 1e-15;  // rounding error of the cosine of half the angle
  if (quaternion(R).w > rounding) return;
  throw nb::value_error((argument + std::string(" turns by half a turn, which Cayley's map reaches only at "
                                                "infinity; expected less, or use log"))
                            .c_str());
}

void add_cayley_of_rotations(nb::module_& lie) {
  add<Vec3<>>(
      lie, "cay_SO3", {"w"}, [](const Vec3<>& w) { return cay_SO3(w); }, R"(
Cayley's map (1 - w~/2)^-1 (1 + w~/2): (..., 3) to (..., 3, 3). The angle is 2 atan(|w|/2), about w.

>>> axode.lie.cay_SO3([0, 0, 2])  # a quarter turn
array([[ 0., -1.,  0.],
       [ 1.,  0.,  0.],
       [ 0.,  0.,  1.]])
)");
  add<SO3<>>(
      lie, "cay_inv_SO3", {"R"},
      [](const SO3<>& R) {
        check_less_than_half_a_turn("R", R);
        return cay_inv_SO3(R);
      },
      R"(
The w with cay_SO3(w) = R: (..., 3, 3) to (..., 3). ValueError where R is no rotation, or half a turn.

>>> axode.lie.cay_inv_SO3(axode.lie.cay_SO3([0.1, 0.2, 0.3])).round(3)
array([0.1, 0.2, 0.3])
)");
  add<Vec3<>>(
      lie, "cay_quaternion", {"w"}, [](const Vec3<>& w) { return cay_quaternion(w); }, R"(
The unit quaternion x y z w of cay_SO3(w): (..., 3) to (..., 4).

>>> axode.lie.cay_quaternion([0, 0, 2]).round(4)
array([0.    , 0.    , 0.7071, 0.7071])
)");
  add<Vec3<>>(
      lie, "dcay_SO3", {"w"},
      [](const Vec3<>& w) { return matrix3([&](const Vec3<>& z) { return dcay(w, z); }); }, R"(
dcay_w on SO(3), right-trivialised: (..., 3) to (..., 3, 3).

For R = cay w the angular velocity is dcay_SO3(w) @ dw in inertial axes, dcay_SO3(-w) @ dw in body axes.

>>> axode.lie.dcay_SO3([0, 0, 2])
array([[ 0.5, -0.5,  0. ],
       [ 0.5,  0.5,  0. ],
       [ 0. ,  0. ,  0.5]])
)");
  add<Vec3<>>(
      lie, "dcay_inv_SO3", {"w"},
      [](const Vec3<>& w) { return matrix3([&](const Vec3<>& z) { return dcay_inv(w, z); }); }, R"(
The inverse of dcay_SO3(w), 1 - w~/2 + w w^T/4: (..., 3) to (..., 3, 3). It is never singular.

>>> axode.lie.dcay_inv_SO3([0, 0, 2])
array([[ 1.,  1.,  0.],
       [-1.,  1.,  0.],
       [ 0.,  0.,  2.]])
)");
  add<Vec3<>, Vec3<>>(
      lie, "ddcay_SO3", {"w", "u"},
      [](const Vec3<>& w, const Vec3<>& u) {
        return matrix3([&](const Vec3<>& z) { return ddcay(w, u, z); });
      },
      R"(
The derivative of dcay_SO3(w) when w moves along u: (..., 3), (..., 3) to (..., 3, 3).

>>> axode.lie.ddcay_SO3(np.zeros(3), [0, 0, 1])  # u~ / 2
array([[ 0. , -0.5,  0. ],
       [ 0.5,  0. ,  0. ],
       [ 0. ,  0. ,  0. ]])
)");
  add<Vec3<>, Vec3<>>(
      lie, "ddcay_inv_SO3", {"w", "u"},
      [](const Vec3<>& w, const Vec3<>& u) {
        return matrix3([&](const Vec3<>& z) { return ddcay_inv(w, u, z); });
      },
      R"(
The derivative of dcay_inv_SO3(w) when w moves along u: (..., 3), (..., 3) to (..., 3, 3).

>>> axode.lie.ddcay_inv_SO3([0, 0, 2], [0, 0, 1]).diagonal()
array([0., 0., 1.])
)");
}

void add_cayley_of_poses(nb::module_& lie) {
  add<Screw<>>(
      lie, "cay", {"X"}, [](const Screw<>& X) { return cay(X); }, R"(
Cayley's map (1 - X^/2)^-1 (1 + X^/2) of the matrix hat(X): (..., 6) to (..., 4, 4), m.

A rational map beside exp, with which it agrees to second order. The angle is 2 atan(|w|/2): half a turn is at infinity.
`cay_of_ad` is the other map of this name on SE(3).

>>> axode.lie.cay([0, 0, 2, 4, 0, 1])
array([[ 0., -1.,  0.,  2.],
       [ 1.,  0.,  0.,  2.],
       [ 0.,  0.,  1.,  1.],
       [ 0.,  0.,  0.,  1.]])
)");
  add<SE3<>>(
      lie, "cay_inv", {"C"},
      [](const SE3<>& C) {
        check_less_than_half_a_turn("C", C.R);
        return cay_inv(C);
      },
      R"(
The screw X with cay(X) = C: (..., 4, 4) to (..., 6). ValueError where C is no pose, or turns by half a turn.

>>> axode.lie.cay_inv(axode.lie.cay([0.1, 0.2, 0.3, 1, 2, 3])).round(3)
array([0.1, 0.2, 0.3, 1. , 2. , 3. ])
)");
  add<Screw<>>(
      lie, "dcay", {"X"},
      [](const Screw<>& X) { return matrix6([&](const Screw<>& Z) { return dcay(X, Z); }); }, R"(
dcay_X, right-trivialised, (d/dt cay X) (cay X)^-1 = hat(dcay_X X'): (..., 6) to (..., 6, 6).

For C = cay X the spatial twist is dcay(X) @ dX, and the body-fixed one is dcay(-X) @ dX.

>>> X = np.array([0.1, 0.2, 0.3, 1, 2, 3])
>>> np.allclose(axode.lie.Ad(axode.lie.cay(X)) @ axode.lie.dcay(-X), axode.lie.dcay(X))
True
)");
  add<Screw<>>(
      lie, "dcay_inv", {"X"},
      [](const Screw<>& X) { return matrix6([&](const Screw<>& Z) { return dcay_inv(X, Z); }); }, R"(
The inverse of dcay(X), a polynomial of second degree in X: (..., 6) to (..., 6, 6). It is never singular.

>>> X = np.array([0.1, 0.2, 0.3, 1, 2, 3])
>>> np.allclose(axode.lie.dcay_inv(X) @ axode.lie.dcay(X), np.eye(6))
True
)");
  add<Screw<>, Screw<>>(
      lie, "ddcay", {"X", "U"},
      [](const Screw<>& X, const Screw<>& U) {
        return matrix6([&](const Screw<>& Z) { return ddcay(X, U, Z); });
      },
      R"(
D_U dcay_X, the derivative of dcay(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> X, U = np.array([0.1, 0.2, 0.3, 1, 2, 3]), np.ones(6)
>>> step = (axode.lie.dcay(X + 1e-5 * U) - axode.lie.dcay(X - 1e-5 * U)) / 2e-5
>>> np.allclose(axode.lie.ddcay(X, U), step)
True
)");
  add<Screw<>, Screw<>>(
      lie, "ddcay_inv", {"X", "U"},
      [](const Screw<>& X, const Screw<>& U) {
        return matrix6([&](const Screw<>& Z) { return ddcay_inv(X, U, Z); });
      },
      R"(
The derivative of dcay_inv(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> axode.lie.ddcay_inv(np.zeros(6), [0, 0, 1, 0, 0, 0])[:3, :3]  # -ad_U / 2
array([[ 0. ,  0.5,  0. ],
       [-0.5,  0. ,  0. ],
       [ 0. ,  0. ,  0. ]])
)");
}

void add_cayley_of_ad(nb::module_& lie) {
  add<Screw<>>(
      lie, "cay_of_ad", {"X"}, [](const Screw<>& X) { return cay_of_ad(X); }, R"(
The pose C with Ad(C) = (1 - ad(X)/2)^-1 (1 + ad(X)/2): (..., 6) to (..., 4, 4), m.

Its rotation is that of `cay(X)`. Its shift along the axis of X is that of cay, divided by 1 + |w|^2/4.

>>> axode.lie.cay_of_ad([0, 0, 2, 4, 0, 1])[:3, 3]
array([2. , 2. , 0.5])
)");
  add<SE3<>>(
      lie, "cay_of_ad_inv", {"C"},
      [](const SE3<>& C) {
        check_less_than_half_a_turn("C", C.R);
        return cay_of_ad_inv(C);
      },
      R"(
The screw X with cay_of_ad(X) = C: (..., 4, 4) to (..., 6). ValueError where C is no pose, or turns by half a turn.

>>> axode.lie.cay_of_ad_inv(axode.lie.cay_of_ad([0.1, 0.2, 0.3, 1, 2, 3])).round(3)
array([0.1, 0.2, 0.3, 1. , 2. , 3. ])
)");
  add<Screw<>>(
      lie, "dcay_of_ad", {"X"},
      [](const Screw<>& X) { return matrix6([&](const Screw<>& Z) { return dcay_of_ad(X, Z); }); }, R"(
The right-trivialised differential of cay_of_ad at X: (..., 6) to (..., 6, 6).

>>> X = np.array([0.1, 0.2, 0.3, 1, 2, 3])
>>> np.allclose(axode.lie.dcay_of_ad(X) @ axode.lie.dcay_inv_of_ad(X), np.eye(6))
True
)");
  add<Screw<>>(
      lie, "dcay_inv_of_ad", {"X"},
      [](const Screw<>& X) { return matrix6([&](const Screw<>& Z) { return dcay_inv_of_ad(X, Z); }); }, R"(
The inverse of dcay_of_ad(X): (..., 6) to (..., 6, 6).

ad(dcay_inv_of_ad(X) @ Z) is (1 - ad(X)/2) ad(Z) (1 + ad(X)/2).

>>> axode.lie.dcay_inv_of_ad([0, 0, 2, 0, 0, 1])[5]
array([0., 0., 1., 0., 0., 2.])
)");
  add<Screw<>, Screw<>>(
      lie, "ddcay_of_ad", {"X", "U"},
      [](const Screw<>& X, const Screw<>& U) {
        return matrix6([&](const Screw<>& Z) { return ddcay_of_ad(X, U, Z); });
      },
      R"(
The derivative of dcay_of_ad(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> X, U = np.array([0.1, 0.2, 0.3, 1, 2, 3]), np.ones(6)
>>> step = (axode.lie.dcay_of_ad(X + 1e-5 * U) - axode.lie.dcay_of_ad(X - 1e-5 * U)) / 2e-5
>>> np.allclose(axode.lie.ddcay_of_ad(X, U), step)
True
)");
  add<Screw<>, Screw<>>(
      lie, "ddcay_inv_of_ad", {"X", "U"},
      [](const Screw<>& X, const Screw<>& U) {
        return matrix6([&](const Screw<>& Z) { return ddcay_inv_of_ad(X, U, Z); });
      },
      R"(
The derivative of dcay_inv_of_ad(X) when X moves along U: (..., 6), (..., 6) to (..., 6, 6).

>>> axode.lie.ddcay_inv_of_ad([0, 0, 2, 0, 0, 1], [0, 0, 1, 0, 0, 0])[5]
array([0. , 0. , 0.5, 0. , 0. , 1. ])
)");
}

}  // namespace

void add_cayley(nb::module_& lie) {
  add_cayley_of_rotations(lie);
  add_cayley_of_poses(lie);
  add_cayley_of_ad(lie);
}

}  // namespace axode::python
