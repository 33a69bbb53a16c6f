"""SE(3), screws and single bodies: numbers are in their places, and arrays of items give the same results as the
items one by one."""

import inspect
import itertools
import math

import axode
import numpy as np
import pytest
from axode import lie
from mechanisms import REPRESENTATIONS, close

RANDOM = np.random.default_rng(0)
N = 40


def rotation_vectors(*angles):
    """An array (N, 3) of rotation vectors with random angles up to pi, except that the first angles are given."""
    e = RANDOM.normal(size=(N, 3))
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    all_angles = RANDOM.uniform(0, np.pi, N)
    all_angles[:len(angles)] = angles
    return all_angles[:, None] * e


SMALL = (0, 1e-300, 1e-160, 1e-12, 1e-8, 1e-4, 1e-2)
NEAR_PI = (np.pi, np.pi - 1e-15, np.pi - 1e-12, np.pi - 1e-8, np.pi - 1e-4)
AROUND_SERIES = (1 - 1e-9, 1 + 1e-9, 0.999, 1.001)
XI = rotation_vectors(*SMALL, *NEAR_PI, *AROUND_SERIES)
X = np.hstack([XI, RANDOM.uniform(-2, 2, (N, 3))])
U = RANDOM.uniform(-1, 1, (N, 6))
C = lie.exp(X)
R = C[:, :3, :3]


def random_inertia(n=N):
    """An array (n, 6, 6) of inertias of random bodies."""
    axes = lie.exp_SO3(RANDOM.uniform(-2, 2, (n, 3)))
    second_moments = RANDOM.uniform(0.1, 1, (n, 3))
    principal = second_moments.sum(axis=1, keepdims=True) - second_moments
    Theta_c = np.einsum("nij,nj,nkj->nik", axes, principal, axes)
    return lie.inertia(RANDOM.uniform(0.5, 5, n), RANDOM.uniform(-1, 1, (n, 3)), (Theta_c + Theta_c.swapaxes(1, 2)) / 2)


def T(matrices):
    return np.swapaxes(matrices, -1, -2)


def along(matrices, vectors):
    return np.einsum("...ij,...j->...i", matrices, vectors)


# -------------------------------------------------------------------------------------------- arrays of items

M = random_inertia()
E = R[:, :, 0]
QUATERNION = lie.quaternion(R)
CAY = lie.cay(X)
POSITIVE = 0.1 + np.abs(U)
ITEMS = {  # items for every argument of every function; words are the same for all items
    "exp": (X,), "log": (C,), "exp_SO3": (XI,), "log_SO3": (R,), "inverse": (C,), "rotation_to": (E,),
    "quaternion": (R,), "rotation": (QUATERNION,), "quaternion_product": (QUATERNION, QUATERNION[::-1]),
    "exp_quaternion": (XI,), "log_quaternion": (QUATERNION,), "scalar_first": (QUATERNION,),
    "from_scalar_first": (QUATERNION,), "skew": (XI,), "from_skew": (lie.skew(XI),), "hat": (X,),
    "from_hat": (lie.hat(X),), "Ad": (C,), "ad": (X,), "dexp": (X,), "dexp_inv": (X,), "ddexp": (X, U),
    "ddexp_inv": (X, U), "dexp_SO3": (XI,), "dexp_inv_SO3": (XI,), "ddexp_SO3": (XI, E), "ddexp_inv_SO3": (XI, E),
    "cay": (X,), "cay_inv": (CAY,), "cay_SO3": (XI,), "cay_inv_SO3": (CAY[:, :3, :3],), "cay_quaternion": (XI,),
    "dcay": (X,), "dcay_inv": (X,), "ddcay": (X, U), "ddcay_inv": (X, U), "dcay_SO3": (XI,), "dcay_inv_SO3": (XI,),
    "ddcay_SO3": (XI, E), "ddcay_inv_SO3": (XI, E), "cay_of_ad": (X,), "cay_of_ad_inv": (CAY,), "dcay_of_ad": (X,),
    "dcay_inv_of_ad": (X,), "ddcay_of_ad": (X, U), "ddcay_inv_of_ad": (X, U),
    "screw": (E, XI, XI[:, 0], XI[:, 1]), "screw_axis": (U,), "pluecker": (U,), "reciprocal_product": (X, U),
    "exchange_halves": (X,), "inertia": (U[:, 0], XI, M[:, :3, :3]), "transform_inertia": (C, M),
    "box_inertia": (POSITIVE[:, 0], POSITIVE[:, 1:4]), "sphere_inertia": (POSITIVE[:, 0], POSITIVE[:, 1]),
    "cylinder_inertia": (POSITIVE[:, 0], POSITIVE[:, 1], POSITIVE[:, 2]),
    "capsule_inertia": (POSITIVE[:, 0], POSITIVE[:, 1], POSITIVE[:, 2]),
    "center_of_mass": (M,), "inertia_about_com": (M,), "realisability": (M,), "newton_euler": (M, X, U),
    "acceleration": (C, M, X, U),
    "change_twist": (C, X, "body", "spatial"), "change_twist_rate": (C, X, U, "hybrid", "body"),
    "change_wrench": (C, X, "mixed", "spatial"), "change_momentum": (C, X, "spatial", "mixed"),
}


def of_each(functions, *arrays):
    return np.array([functions(*items) for items in zip(*arrays)])


def expm(A):
    """The matrix exponential by its power series, which is exact for small matrices."""
    return sum(np.linalg.matrix_power(A, k) / math.factorial(k) for k in range(40))


def rate(f, x, u, h=1e-6):
    """The rate of f(x) when x moves along u, by central differences."""
    return (f(x + h * u) - f(x - h * u)) / (2 * h)


def cayley(A):
    """(1 - A/2)^-1 (1 + A/2)."""
    one = np.eye(A.shape[-1])
    return np.linalg.solve(one - A / 2, one + A / 2)


AWAY = np.linalg.norm(XI, axis=1) < np.pi - 1e-9  # at pi either direction is right
UNIT = np.broadcast_to(np.eye(6), (N, 6, 6))
#: (the result of a function, the expected result, the tolerance),
#: one of each. The laws themselves are tested in C++.
IS = {
    "exp": lambda: (lie.exp(X), of_each(expm, lie.hat(X)), 1e-14), "exp_SO3": lambda: (lie.exp_SO3(XI), R, 1e-14),
    "log": lambda: (lie.log(C)[AWAY], X[AWAY], 1e-12), "log_SO3": lambda: (lie.log_SO3(R)[AWAY], XI[AWAY], 1e-12),
    "inverse": lambda: (lie.inverse(C), np.linalg.inv(C), 1e-13),
    "skew": lambda: (along(lie.skew(XI), E), np.cross(XI, E), 0), "from_skew": lambda: (lie.from_skew(lie.skew(XI)), XI, 0),
    "hat": lambda: (lie.hat(X)[:, :3], np.dstack([lie.skew(XI), X[:, 3:]]), 0), "from_hat": lambda: (lie.from_hat(lie.hat(X)), X, 0),
    "Ad": lambda: (lie.hat(along(lie.Ad(C), U)), C @ lie.hat(U) @ np.linalg.inv(C), 1e-13),
    "ad": lambda: (lie.hat(along(lie.ad(X), U)), lie.hat(X) @ lie.hat(U) - lie.hat(U) @ lie.hat(X), 1e-14),
    "dexp": lambda: (lie.hat(along(lie.dexp(X), U)), rate(lie.exp, X, U) @ lie.inverse(C), 1e-8),
    "dexp_inv": lambda: (lie.dexp_inv(X) @ lie.dexp(X), UNIT, 1e-13),
    "ddexp": lambda: (lie.ddexp(X, U), rate(lie.dexp, X, U), 1e-8),
    "ddexp_inv": lambda: (lie.ddexp_inv(X, U), rate(lie.dexp_inv, X, U), 1e-8),
    "dexp_SO3": lambda: (lie.dexp_SO3(XI), lie.dexp(X)[:, :3, :3], 1e-14),
    "dexp_inv_SO3": lambda: (lie.dexp_inv_SO3(XI), lie.dexp_inv(X)[:, :3, :3], 1e-14),
    "ddexp_SO3": lambda: (lie.ddexp_SO3(XI, E), rate(lie.dexp_SO3, XI, E), 1e-8),
    "ddexp_inv_SO3": lambda: (lie.ddexp_inv_SO3(XI, E), rate(lie.dexp_inv_SO3, XI, E), 1e-8),
    "cay": lambda: (CAY, of_each(cayley, lie.hat(X)), 1e-14), "cay_inv": lambda: (lie.cay_inv(CAY), X, 1e-13),
    "cay_SO3": lambda: (lie.cay_SO3(XI), CAY[:, :3, :3], 1e-14), "cay_inv_SO3": lambda: (lie.cay_inv_SO3(lie.cay_SO3(XI)), XI, 1e-14),
    "cay_quaternion": lambda: (lie.rotation(lie.cay_quaternion(XI)), lie.cay_SO3(XI), 1e-14),
    "dcay": lambda: (lie.hat(along(lie.dcay(X), U)), rate(lie.cay, X, U) @ lie.inverse(CAY), 1e-8),
    "dcay_inv": lambda: (lie.dcay_inv(X) @ lie.dcay(X), UNIT, 1e-13),
    "ddcay": lambda: (lie.ddcay(X, U), rate(lie.dcay, X, U), 1e-8),
    "ddcay_inv": lambda: (lie.ddcay_inv(X, U), rate(lie.dcay_inv, X, U), 1e-8),
    "dcay_SO3": lambda: (lie.dcay_SO3(XI), lie.dcay(X)[:, :3, :3], 1e-14),
    "dcay_inv_SO3": lambda: (lie.dcay_inv_SO3(XI), lie.dcay_inv(X)[:, :3, :3], 1e-14),
    "ddcay_SO3": lambda: (lie.ddcay_SO3(XI, E), rate(lie.dcay_SO3, XI, E), 1e-8),
    "ddcay_inv_SO3": lambda: (lie.ddcay_inv_SO3(XI, E), rate(lie.dcay_inv_SO3, XI, E), 1e-8),
    "cay_of_ad": lambda: (lie.Ad(lie.cay_of_ad(X)), of_each(cayley, lie.ad(X)), 1e-13),
    "cay_of_ad_inv": lambda: (lie.cay_of_ad(lie.cay_of_ad_inv(CAY)), CAY, 1e-13),
    "dcay_of_ad": lambda: (lie.hat(along(lie.dcay_of_ad(X), U)), rate(lie.cay_of_ad, X, U) @ lie.inverse(lie.cay_of_ad(X)), 1e-8),
    "dcay_inv_of_ad": lambda: (lie.dcay_inv_of_ad(X) @ lie.dcay_of_ad(X), UNIT, 1e-13),
    "ddcay_of_ad": lambda: (lie.ddcay_of_ad(X, U), rate(lie.dcay_of_ad, X, U), 1e-8),
    "ddcay_inv_of_ad": lambda: (lie.ddcay_inv_of_ad(X, U), rate(lie.dcay_inv_of_ad, X, U), 1e-8),
    "rotation": lambda: (lie.rotation(QUATERNION), R, 1e-14),
    "quaternion": lambda: (lie.rotation(-lie.quaternion(R)) * (lie.quaternion(R)[:, 3:, None] >= 0), R, 1e-14),
    "quaternion_product": lambda: (lie.rotation(lie.quaternion_product(QUATERNION, QUATERNION[::-1])), R @ R[::-1], 1e-14),
    "exp_quaternion": lambda: (lie.rotation(lie.exp_quaternion(XI)), R, 1e-14),
    "log_quaternion": lambda: (lie.log_quaternion(lie.exp_quaternion(XI)), XI, 1e-14),
    "scalar_first": lambda: (lie.scalar_first(U[:, :4]), U[:, [3, 0, 1, 2]], 0),
    "from_scalar_first": lambda: (lie.from_scalar_first(lie.scalar_first(U[:, :4])), U[:, :4], 0),
    "exchange_halves": lambda: (lie.exchange_halves(M, axis=-2), M[:, [3, 4, 5, 0, 1, 2]], 0),
    "rotation_to": lambda: (lie.rotation_to(E)[:, :, 2], E, 1e-15),
    "screw": lambda: (lie.screw(E, XI, U[:, 0]), np.hstack([E, np.cross(XI, E) + U[:, :1] * E]), 1e-15),
    "screw_axis": lambda: (lie.screw(*lie.screw_axis(U)), U, 1e-15),
    "pluecker": lambda: (lie.pluecker(U), lie.screw(lie.screw_axis(U).e, lie.screw_axis(U).p), 1e-15),
    "reciprocal_product": lambda: (lie.reciprocal_product(X, U), np.sum(X * lie.exchange_halves(U), axis=1), 1e-14),
    "inertia": lambda: (lie.inertia_about_com(M) - M[:, :3, :3],
                        M[:, 3:, 3:] @ of_each(np.dot, *2 * [lie.skew(lie.center_of_mass(M))]), 1e-13),
    "center_of_mass": lambda: (lie.skew(M[:, 3, 3, None] * lie.center_of_mass(M)), M[:, :3, 3:], 1e-14),
    "inertia_about_com": lambda: (lie.inertia(M[:, 3, 3], lie.center_of_mass(M), lie.inertia_about_com(M)), M, 1e-13),
    "transform_inertia": lambda: (lie.transform_inertia(C, M), T(lie.Ad(lie.inverse(C))) @ M @ lie.Ad(lie.inverse(C)), 1e-13),
    "realisability": lambda: ([np.sign(lie.realisability(lie.inertia(1, [0, 0, 0], np.diag([1.0, 1.0, z])))) for z in (1, 3)], [1, -1], 0),
    "box_inertia": lambda: (np.diag(lie.box_inertia(12.0, [1, 2, 3])), [13, 10, 5, 12, 12, 12], 1e-14),
    "sphere_inertia": lambda: (np.diag(lie.sphere_inertia(5.0, 1.0)), [2, 2, 2, 5, 5, 5], 1e-14),
    "cylinder_inertia": lambda: (np.diag(lie.cylinder_inertia(12.0, 1.0, 2.0)), [7, 7, 6, 12, 12, 12], 1e-14),
    "capsule_inertia": lambda: (lie.capsule_inertia(20.0, 1.0, 4 / 3)[2, 2], 9.0, 1e-14),
    "newton_euler": lambda: (lie.newton_euler(M, X, U), along(M, U) - along(T(lie.ad(X)), along(M, X)), 1e-14),
    "acceleration": lambda: (lie.acceleration(C, M, X, lie.newton_euler(M, X, U)), U, 1e-11),
    "change_twist": lambda: (lie.change_twist(C, X, "body", "spatial"), along(lie.Ad(C), X), 1e-13),
    "change_wrench": lambda: (np.sum(lie.change_twist(C, X, "mixed", "spatial") * lie.change_wrench(C, U, "mixed", "spatial"),
                                     axis=1), np.sum(X * U, axis=1), 1e-13),
    "change_momentum": lambda: (lie.change_momentum(C, U, "spatial", "mixed"), lie.change_wrench(C, U, "spatial", "mixed"), 0),
    "change_twist_rate": lambda: (lie.change_twist_rate(C, X, U, "body", "spatial"), along(lie.Ad(C), U), 1e-13),
}


@pytest.mark.parametrize("name", ITEMS)
def test_numbers_are_in_their_places(name):
    found, expected, tolerance = IS[name]()
    assert close(found, expected, tolerance)


def test_representations_are_those_of_the_twists_of_a_model():
    m = axode.load(axode.robots / "arm7.toml")
    q, v, a = m.random(), *np.random.default_rng(1).uniform(-1, 1, (2, m.nv))
    C = axode.poses(m, q)
    for source, target in itertools.product(REPRESENTATIONS, repeat=2):
        V, dV = axode.twists(m, q, v, source), axode.accelerations(m, q, v, a, source)
        assert close(lie.change_twist(C, V, source, target), axode.twists(m, q, v, target), 1e-13)
        assert close(lie.change_twist_rate(C, V, dV, source, target), axode.accelerations(m, q, v, a, target), 1e-12)


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_accelerations_and_wrenches_of_a_body_are_each_other_s_way_back(representation):
    at = lie.transform_inertia(C, M), *(lie.change_twist(C, U, "body", "spatial"), X)
    W = lie.change_wrench(C, lie.newton_euler(*at, "spatial"), "spatial", representation)
    V = lie.change_twist(C, at[1], "spatial", representation)
    dV = lie.change_twist_rate(C, at[1], X, "spatial", representation)
    assert close(lie.acceleration(C, M, V, W, representation), dV, 1e-11)
    C_of = {"body": np.broadcast_to(np.eye(4), C.shape), "spatial": C, "hybrid": C * np.append(np.ones((4, 3)), [[0], [0], [0], [1]], axis=1)}
    inertia = lie.transform_inertia(C_of.get(representation, C_of["body"]), M)
    own = R if representation == "mixed" else None
    assert close(lie.newton_euler(inertia, V, dV, representation, own), W, 1e-12)
    with pytest.raises(ValueError, match="mass"):
        lie.acceleration(C[0], 0 * M[0], V[0], W[0])


def test_pairs_of_frames_give_the_same_wrench_and_have_four_entries():
    random = np.random.default_rng(6)
    jk = lie.FramePair(*random.normal(size=(2, N, 3)), lie.exp_SO3(random.normal(size=(N, 3))), random.normal(size=(N, 3)))
    V, dV = U, X
    W = lie.newton_euler(lie.transform_inertia(C, M), V, dV, "spatial")
    expected = lie.wrench_in_frames(jk, W)
    assert close(lie.newton_euler_in_frames(jk, lie.inertia_in_frames(jk, C, M), lie.twist_in_frames(jk, V),
                                            lie.twist_rate_in_frames(jk, V, dV)), expected, 1e-11)
    first = lie.FramePair(*(part[0] for part in jk))
    assert np.array_equal(lie.wrench_in_frames(first, W[0]), expected[0])
    assert np.allclose(np.sum(expected * lie.twist_in_frames(jk, V), axis=1), np.sum(W * V, axis=1), rtol=1e-10)
    for wrong in (None, 3, np.eye(4), ([0, 0, 0],) * 3):
        with pytest.raises((ValueError, TypeError), match="jk"):
            lie.twist_in_frames(wrong, np.zeros(6))
    with pytest.raises(ValueError, match="jk.R_k: expected a rotation"):
        lie.twist_in_frames(lie.FramePair([0, 0, 0], [0, 0, 0], np.zeros((3, 3)), [0, 0, 0]), np.zeros(6))


def items_of(name):
    arrays = [x for x in ITEMS[name] if not isinstance(x, str)]
    return arrays, [x for x in ITEMS[name] if isinstance(x, str)]


def argument_names(name):
    """The names of the arguments, from the signature with which the docstring begins."""
    signature = getattr(lie, name).__doc__.split("\n")[0]
    inside = signature[signature.index("(") + 1:signature.rindex(") ->")]
    return [part.split(":")[0] for part in inside.split(", ") if ":" in part]


def results(found):
    return found if isinstance(found, tuple) else (found,)


def test_a_mesh_of_a_box_is_the_box_wherever_it_is():
    size = np.array([0.3, 0.5, 0.7])
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
             [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    for pose in C[:5]:
        vertices = corners @ pose[:3, :3].T + pose[:3, 3]
        assert close(lie.mesh_volume(vertices, faces), size.prod())
        assert close(lie.mesh_inertia(2.5, vertices, faces), lie.transform_inertia(pose, lie.box_inertia(2.5, size)))
    for wrong, message in (((corners, faces[1:]), "a mesh must be closed"),
                           ((corners[:, :2], faces), r"^vertices: expected shape \(N, 3\)"),
                           ((corners, [0, 1, 2]), r"^faces: expected shape \(F, 3\)"),
                           ((corners, [[0, 1, 2.5]]), "faces: 2.5.* is not the number of a vertex"),
                           ((corners, [[0, 1, 8]]), "faces: number 0 has vertex 8 of 8"),
                           ((corners, np.array(faces)[:, ::-1]), "counterclockwise as seen from outside")):
        with pytest.raises(ValueError, match=message):
            lie.mesh_volume(*wrong)


def test_every_function_is_among_those_that_are_tried():
    of_their_own = {"mesh_volume", "mesh_inertia", *(name for name in lie.__all__ if name.endswith("_in_frames"))}
    tried = {*ITEMS, *of_their_own}
    assert tried == {name for name in lie.__all__ if not inspect.isclass(getattr(lie, name))}


@pytest.mark.parametrize("name", ITEMS)
def test_many_items_are_the_items_one_by_one(name):
    f, (arrays, words) = getattr(lie, name), items_of(name)
    many = results(f(*arrays, *words))
    for k in range(N):
        for one, all_of_them in zip(results(f(*(x[k] for x in arrays), *words)), many, strict=True):
            assert np.array_equal(one, all_of_them[k])
    folded = results(f(*(x.reshape(4, 1, 10, *x.shape[1:]) for x in arrays), *words))
    for x, y in zip(folded, many, strict=True):
        assert np.array_equal(x, y.reshape(4, 1, 10, *y.shape[1:]))
    for x, y in zip(results(f(*(x[:0] for x in arrays), *words)), many, strict=True):
        assert x.shape == (0, *y.shape[1:])
    for x, y in zip(results(f(*(x.tolist() for x in arrays), *words)), many, strict=True):
        assert np.array_equal(x, y)


@pytest.mark.parametrize("name", [name for name in ITEMS if len(items_of(name)[0]) > 1])
def test_an_item_without_leading_axes_goes_with_all_others(name):
    f, (arrays, words) = getattr(lie, name), items_of(name)
    for alone in range(len(arrays)):
        mixed = [x[3] if k == alone else x for k, x in enumerate(arrays)]
        repeated = [np.broadcast_to(x[3], x.shape) if k == alone else x for k, x in enumerate(arrays)]
        assert np.array_equal(f(*mixed, *words), f(*repeated, *words))
        short = [x[:2] if k == alone else x for k, x in enumerate(arrays)]
        names, other = argument_names(name), 0 if alone > 0 else 1
        with pytest.raises(ValueError) as caught:
            f(*short, *words)
        for k in (alone, other):
            assert f"{names[k]} has shape {short[k].shape}" in str(caught.value)


@pytest.mark.parametrize("name", ITEMS)
def test_every_argument_is_checked_and_named(name):
    f, (arrays, words) = getattr(lie, name), items_of(name)
    names = argument_names(name)

    def refused(argument, x, message):
        given = [x if k == argument else array for k, array in enumerate(arrays)]
        with pytest.raises(ValueError, match=rf"^{names[argument]}\b.*{message}"):
            f(*given, *words)
    for k, array in enumerate(arrays):
        if array.ndim > 1:
            refused(k, array[..., :-1], "expected shape .*, got ")
            refused(k, 1.0, r"expected shape .*, got \(\)")
        refused(k, np.where(np.arange(array.size).reshape(array.shape) == 3, np.nan, array), "is nan")
        if (name, k) != ("screw", 2):
            refused(k, np.where(np.arange(array.size).reshape(array.shape) == 3, np.inf, array), "is inf")
        refused(k, array + 0j, "expected real numbers .* got dtype complex128")
        refused(k, "text", "expected real numbers .* got str")
    with pytest.raises(TypeError, match="NoneType"):
        f(None, *arrays[1:], *words)


def test_more_axes_than_an_array_can_have_are_refused():
    assert lie.exp(np.zeros((1,) * 30 + (6,))).shape == (1,) * 30 + (4, 4)
    for axes in (31, 40, 63):
        with pytest.raises(ValueError, match="X: expected shape with at most 30 axes"):
            lie.exp(np.zeros((1,) * axes + (6,)))


OVERFLOWING = [[1e200, 1e200, 0], [1e200, -1e200, 0], [0, 0, 1]]
WRONG = {
    "no rotation": (lambda: lie.log_SO3(2 * np.eye(3)), "R: expected a rotation"),
    "half a turn": (lambda: lie.cay_inv_SO3(np.diag([1, -1, -1.0])), "R turns by half a turn"),
    "a pose of half a turn": (lambda: lie.cay_inv(np.diag([1, -1, -1, 1.0])), "C turns by half a turn"),
    "a reflection": (lambda: lie.quaternion(np.diag([1, 1, -1.0])), "R: expected a rotation"),
    "what overflows": (lambda: lie.log_SO3(OVERFLOWING), "R: expected a rotation"),
    "a pose that overflows": (lambda: lie.log(np.pad(OVERFLOWING, (0, 1)) + np.diag([0, 0, 0, 1])),
                              "C: expected a pose"),
    "no pose": (lambda: lie.Ad(np.ones((4, 4))), "C: expected a pose"),
    "the fourth pose": (lambda: lie.log(np.where(np.arange(N)[:, None, None] == 3, np.ones((4, 4)), C)),
                        r"^item \[3\]: C: expected a pose"),
    "a quaternion of another length": (lambda: lie.rotation([0, 0, 0, 1.01]), "a: expected a unit quaternion"),
    "no unit vector": (lambda: lie.rotation_to([0, 0, 2]), "n: expected a unit vector"),
    "no direction": (lambda: lie.screw([0, 0, 0], [0, 0, 0]), "e: expected a unit vector"),
    "an infinite pitch backwards": (lambda: lie.screw([0, 0, 1], [0, 0, 0], -np.inf), "h is -inf"),
    "a pitch that is no number": (lambda: lie.screw([0, 0, 1], [0, 0, 0], np.nan), "h is nan"),
    "no skew matrix": (lambda: lie.from_skew(np.eye(3)), "A: expected a skew-symmetric matrix"),
    "no hat": (lambda: lie.from_hat(np.eye(4)), r"A: expected a matrix \[\[w~, v\], \[0, 0\]\]"),
    "no symmetry": (lambda: lie.inertia(1, [0, 0, 0], np.arange(9.0).reshape(3, 3)), "Theta_c: expected a symmetric"),
    "no inertia": (lambda: lie.newton_euler(np.arange(36.0).reshape(6, 6), U, U), "M: expected an inertia matrix"),
    "no mass": (lambda: lie.center_of_mass(np.zeros((6, 6))), "M: its mass is 0"),
    "no halves": (lambda: lie.exchange_halves(np.zeros((6, 3))), "x: expected shape with 6 entries along axis -1"),
    "an axis too many": (lambda: lie.exchange_halves(np.zeros((6, 3)), 2), "x: expected shape .* along axis 2"),
    "an axis before the first": (lambda: lie.exchange_halves(np.zeros(6), -2), "x: expected shape .* axis -2"),
    "an unknown source": (lambda: lie.change_twist(C, X, "world", "body"), "source is 'world'; expected one of 'body'"),
    "an unknown target": (lambda: lie.change_wrench(C, X, "body", "hybird"), "target is 'hybird'; .* did you mean"),
    "no rotation for mixed": (lambda: lie.newton_euler(M, X, U, "mixed"), "R: the mixed representation needs"),
    "a rotation for body": (lambda: lie.newton_euler(M, X, U, "body", R), "R: expected None"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_no_such_item_is_refused(kind):
    call, message = WRONG[kind]
    with pytest.raises(ValueError, match=message):
        call()


def test_float32_rotations_are_taken():
    assert close(lie.exp(lie.log(C.astype(np.float32))), C, 1e-6)
