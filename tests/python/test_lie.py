"""SE(3), screws and single bodies: laws of the groups, and that arrays of items are the items one by one."""

import inspect

import axode
import numpy as np
import pytest
from axode import lie
from mechanisms import REPRESENTATIONS, close

RANDOM = np.random.default_rng(0)
N = 40


def rotation_vectors(*angles):
    """(N, 3) with random angles up to pi, the first of which are these."""
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


def matrix_exponential(A, terms=80):
    """By its power series, which is exact for what is not large."""
    power = total = np.eye(A.shape[-1]) * np.ones_like(A)
    for k in range(1, terms):
        power = power @ A / k
        total = total + power
    return total


def random_inertia(n=N):
    """(n, 6, 6) of random bodies."""
    axes = lie.exp_SO3(RANDOM.uniform(-2, 2, (n, 3)))
    second_moments = RANDOM.uniform(0.1, 1, (n, 3))
    principal = second_moments.sum(axis=1, keepdims=True) - second_moments
    Theta_c = np.einsum("nij,nj,nkj->nik", axes, principal, axes)
    return lie.inertia(RANDOM.uniform(0.5, 5, n), RANDOM.uniform(-1, 1, (n, 3)), (Theta_c + Theta_c.swapaxes(1, 2)) / 2)


def T(matrices):
    return np.swapaxes(matrices, -1, -2)


def along(matrices, vectors):
    return np.einsum("...ij,...j->...i", matrices, vectors)


def rate(f, x, u, h=1e-6):
    """Central difference of f(x) when x moves along u."""
    return (f(x + h * u) - f(x - h * u)) / (2 * h)


# ------------------------------------------------------------------------------------------------ exp, log and dexp

def test_exp_is_the_exponential_of_the_matrix():
    assert close(C, matrix_exponential(lie.hat(X)), 1e-14)
    assert close(lie.exp_SO3(XI), matrix_exponential(lie.skew(XI)), 1e-14)


def test_log_is_the_inverse_of_exp_also_near_0_and_pi():
    assert close(lie.exp(lie.log(C)), C, 1e-13)
    away = np.linalg.norm(XI, axis=1) < np.pi - 1e-9  # at pi either direction is right
    assert away.sum() > N - 5
    assert close(lie.log(C)[away], X[away], 1e-12)
    relative = np.linalg.norm(lie.log_SO3(R) - XI, axis=1)[away] / np.maximum(np.linalg.norm(XI[away], axis=1), 1e-300)
    assert relative.max() < 1e-12
    assert (np.linalg.norm(lie.log_SO3(R), axis=1) <= np.pi).all()
    at_pi = lie.log_SO3(R[7])
    assert min(np.abs(at_pi - XI[7]).max(), np.abs(at_pi + XI[7]).max()) < 1e-14


def test_powers_of_one_exponential_add():
    assert close(lie.exp(0.3 * X) @ lie.exp(0.5 * X), lie.exp(0.8 * X), 1e-14)
    assert close(lie.inverse(C), lie.exp(-X), 1e-14)
    assert close(lie.inverse(C) @ C, np.broadcast_to(np.eye(4), C.shape), 1e-14)


def test_dexp_is_the_derivative_of_exp():
    dC = rate(lie.exp, X, U)
    assert close(dC @ lie.inverse(C), lie.hat(along(lie.dexp(X), U)), 1e-8)
    assert close(lie.inverse(C) @ dC, lie.hat(along(lie.dexp(-X), U)), 1e-8)
    xi, eta = X[:, :3], U[:, :3]
    assert close(rate(lie.exp_SO3, xi, eta) @ T(R), lie.skew(along(lie.dexp_SO3(xi), eta)), 1e-8)


@pytest.mark.parametrize("name, n", [("", 6), ("_SO3", 3)])
def test_dexp_inv_is_the_inverse_and_ddexp_the_derivative(name, n):
    dexp, dexp_inv, ddexp, ddexp_inv = (getattr(lie, f + name) for f in ("dexp", "dexp_inv", "ddexp", "ddexp_inv"))
    x, u = X[:, :n], U[:, :n]
    assert close(dexp_inv(x) @ dexp(x), np.broadcast_to(np.eye(n), (N, n, n)), 1e-13)
    assert close(ddexp(x, u), rate(dexp, x, u), 1e-8)
    assert close(ddexp_inv(x, u), rate(dexp_inv, x, u), 1e-8)


def test_Ad_is_a_homomorphism_with_ad_as_its_derivative():
    D = C[::-1]
    assert close(lie.Ad(C) @ lie.Ad(D), lie.Ad(C @ D), 1e-14)
    assert close(lie.Ad(C), matrix_exponential(lie.ad(X)), 1e-13)
    assert close(C @ lie.hat(U) @ lie.inverse(C), lie.hat(along(lie.Ad(C), U)), 1e-13)
    assert close(lie.hat(X) @ lie.hat(U) - lie.hat(U) @ lie.hat(X), lie.hat(along(lie.ad(X), U)), 1e-14)
    assert close(lie.Ad(C) @ lie.dexp(-X), lie.dexp(X), 1e-13)


def test_matrices_and_their_vectors_belong_together():
    assert np.array_equal(along(lie.skew(XI), U[:, :3]), np.cross(XI, U[:, :3]))
    assert np.array_equal(lie.from_skew(lie.skew(XI)), XI)
    assert np.array_equal(lie.from_hat(lie.hat(X)), X)


# ------------------------------------------------------------------------------------------------------ quaternions

def test_quaternions_are_the_same_rotations():
    a, b = lie.exp_quaternion(XI), lie.exp_quaternion(XI[::-1])
    assert np.abs(np.linalg.norm(a, axis=1) - 1).max() < 1e-15
    assert close(lie.rotation(a), R, 1e-14) and close(lie.rotation(-a), R, 1e-14)
    assert close(lie.rotation(lie.quaternion_product(a, b)), R @ R[::-1], 1e-14)
    assert close(lie.quaternion_product(a, a * [-1, -1, -1, 1]), np.broadcast_to([0.0, 0, 0, 1], (N, 4)), 1e-15)
    back = lie.quaternion(R)
    assert close(back * np.sign(np.sum(back * a, axis=1, keepdims=True)), a, 1e-14)
    assert (back[:, 3] >= 0).all()
    assert close(lie.log_quaternion(back), lie.log_SO3(R), 1e-14)
    assert close(lie.log_quaternion(a), XI, 1e-14)


def test_orders_of_other_libraries_are_permutations():
    a = RANDOM.normal(size=(N, 4))
    assert np.array_equal(lie.scalar_first(a), a[:, [3, 0, 1, 2]])
    assert np.array_equal(lie.from_scalar_first(lie.scalar_first(a)), a)
    J = RANDOM.normal(size=(5, 6, 7))
    assert np.array_equal(lie.exchange_halves(J, 1), J[:, [3, 4, 5, 0, 1, 2]])
    assert np.array_equal(lie.exchange_halves(J, axis=-2), lie.exchange_halves(J, 1))
    assert np.array_equal(lie.exchange_halves(X), X[:, [3, 4, 5, 0, 1, 2]])
    assert np.array_equal(lie.exchange_halves(lie.exchange_halves(X)), X)


def test_rotation_to_is_the_shortest_one():
    n = lie.rotation(lie.exp_quaternion(RANDOM.normal(size=(N, 3))))[:, :, 2]
    turned = lie.rotation_to(n)
    assert close(turned[:, :, 2], n, 1e-15)
    assert np.abs(lie.log_SO3(turned)[:, 2]).max() < 1e-15  # its axis is level
    assert np.array_equal(lie.rotation_to([0, 0, -1]), np.diag([1, -1, -1]))


# ----------------------------------------------------------------------------------------------------------- screws

def test_a_screw_and_its_axis_are_the_same():
    translations = np.hstack([np.zeros((N, 3)), U[:, 3:]])
    for screws in (U, translations, np.zeros((2, 6))):
        axis = lie.screw_axis(screws)
        assert close(lie.screw(*axis), screws, 1e-15)
        assert np.abs(np.sum(axis.p * axis.e, axis=1)).max() < 1e-13  # nearest to the origin
    assert np.isinf(lie.screw_axis(translations).h).all()
    assert close(lie.pluecker(U), lie.screw(lie.screw_axis(U).e, lie.screw_axis(U).p), 1e-15)


def test_points_of_the_axis_only_slide_along_it():
    turns = np.linalg.norm(XI, axis=1) > 1e-3  # the axes of others are far away
    e, p, h, magnitude = lie.screw_axis(X[turns])
    moved = along(R[turns], p) + C[turns, :3, 3]
    assert close(moved - p, (h * magnitude)[:, None] * e, 1e-12)


def test_axes_that_meet_are_reciprocal_and_the_product_is_invariant():
    e, f, p = (lie.rotation(lie.exp_quaternion(RANDOM.normal(size=(N, 3))))[:, :, 0] for _ in range(3))
    assert np.abs(lie.reciprocal_product(lie.screw(e, p), lie.screw(f, p))).max() < 1e-14
    assert np.abs(lie.reciprocal_product(lie.screw(e, p), lie.screw(e, -p))).max() < 1e-14
    there = lie.reciprocal_product(along(lie.Ad(C), X), along(lie.Ad(C), U))
    assert close(there, lie.reciprocal_product(X, U), 1e-13)
    assert isinstance(lie.reciprocal_product(X[0], U[0]), float)


# ------------------------------------------------------------------------------------------------------ rigid bodies

def test_inertia_is_that_of_its_points():
    points, masses = RANDOM.uniform(-1, 1, (20, 3)), RANDOM.uniform(0.1, 1, 20)
    c = masses @ points / masses.sum()

    def about(o):
        return -np.einsum("k,kij,kjl->il", masses, lie.skew(points - o), lie.skew(points - o))
    M = lie.inertia(masses.sum(), c, about(c))
    assert close(M[:3, :3], about(0), 1e-14) and close(M[:3, 3:], lie.skew(masses @ points), 1e-14)
    assert close(lie.center_of_mass(M), c, 1e-14) and close(lie.inertia_about_com(M), about(c), 1e-13)
    assert lie.realisability(M) > 0
    assert abs(lie.realisability(lie.inertia(1, [0, 0, 0], np.diag([1.0, 1.0, 0])))) < 1e-12
    assert lie.realisability(lie.inertia(1, [0, 0, 0], np.diag([1.0, 1.0, 3]))) < -0.1


def test_inertia_transforms_as_a_congruence():
    M = random_inertia()
    A = lie.Ad(lie.inverse(C))
    assert close(lie.transform_inertia(C, M), T(A) @ M @ A, 1e-13)


def test_newton_euler_is_the_rate_of_momentum_in_every_representation():
    M, V, dV = random_inertia(), X, U
    W = {"body": lie.newton_euler(M, V, dV)}
    assert close(W["body"], along(M, dV) - along(T(lie.ad(V)), along(M, V)), 1e-14)
    R_only = C.copy()
    R_only[:, :3, 3] = 0
    in_its_frame = {"spatial": lie.transform_inertia(C, M), "hybrid": lie.transform_inertia(R_only, M), "mixed": M}
    for representation, inertia in in_its_frame.items():
        W[representation] = lie.newton_euler(
            inertia, lie.change_twist(C, V, "body", representation),
            lie.change_twist_rate(C, V, dV, "body", representation), representation,
            R if representation == "mixed" else None)
        assert close(W[representation], lie.change_wrench(C, W["body"], "body", representation), 1e-12)

    def spatial_momentum(s):  # along the motion C exp(V s + dV s^2 / 2), to second order
        return along(T(lie.Ad(lie.inverse(C @ lie.exp(V * s + dV * s * s / 2)))), along(M, V + dV * s))
    assert close(rate(spatial_momentum, 0.0, 1.0, 1e-5), W["spatial"], 1e-8)


@pytest.mark.parametrize("target", REPRESENTATIONS)
@pytest.mark.parametrize("source", REPRESENTATIONS)
def test_a_change_of_representation_keeps_power_and_is_undone_by_the_other(source, target):
    V, W = lie.change_twist(C, X, source, target), lie.change_wrench(C, U, source, target)
    assert close(np.sum(V * W, axis=1), np.sum(X * U, axis=1), 1e-13)
    assert np.array_equal(lie.change_momentum(C, U, source, target), W)
    assert close(lie.change_twist(C, V, target, source), X, 1e-14)
    dV = lie.change_twist_rate(C, X, U, source, target)
    assert close(lie.change_twist_rate(C, V, dV, target, source), U, 1e-13)

    def twist(s):  # of the motion with twist X + U s in the source representation, to second order
        V_b, dV_b = lie.change_twist(C, X, source, "body"), lie.change_twist_rate(C, X, U, source, "body")
        return lie.change_twist(C @ lie.exp(V_b * s + dV_b * s * s / 2), X + U * s, source, target)
    assert close(rate(twist, 0.0, 1.0, 1e-5), dV, 1e-8)


def test_representations_are_those_of_the_twists_of_a_model():
    m = axode.load(axode.robots / "arm7.toml")
    q, v, a = m.random(), *np.random.default_rng(1).uniform(-1, 1, (2, m.nv))
    poses = axode.poses(m, q)
    for source in REPRESENTATIONS:
        for target in REPRESENTATIONS:
            V = axode.twists(m, q, v, source)
            assert close(lie.change_twist(poses, V, source, target), axode.twists(m, q, v, target), 1e-13)
            dV = axode.accelerations(m, q, v, a, source)
            assert close(lie.change_twist_rate(poses, V, dV, source, target), axode.accelerations(m, q, v, a, target),
                         1e-12)


# ------------------------------------------------------------------------------------------------- arrays of items

M = random_inertia()
E = R[:, :, 0]
QUATERNION = lie.quaternion(R)
POSITIVE = 0.1 + np.abs(U)
ITEMS = {  # of every argument of every function; words are the same for all
    "exp": (X,), "log": (C,), "exp_SO3": (XI,), "log_SO3": (R,), "inverse": (C,), "rotation_to": (E,),
    "quaternion": (R,), "rotation": (QUATERNION,), "quaternion_product": (QUATERNION, QUATERNION[::-1]),
    "exp_quaternion": (XI,), "log_quaternion": (QUATERNION,), "scalar_first": (QUATERNION,),
    "from_scalar_first": (QUATERNION,), "skew": (XI,), "from_skew": (lie.skew(XI),), "hat": (X,),
    "from_hat": (lie.hat(X),), "Ad": (C,), "ad": (X,), "dexp": (X,), "dexp_inv": (X,), "ddexp": (X, U),
    "ddexp_inv": (X, U), "dexp_SO3": (XI,), "dexp_inv_SO3": (XI,), "ddexp_SO3": (XI, E), "ddexp_inv_SO3": (XI, E),
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


def items_of(name):
    arrays = [x for x in ITEMS[name] if not isinstance(x, str)]
    return arrays, [x for x in ITEMS[name] if isinstance(x, str)]


def argument_names(name):
    """From the signature, with which the docstring begins."""
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
    assert lie.exp(np.zeros((1,) * 14 + (6,))).shape == (1,) * 14 + (4, 4)
    for axes in (15, 16, 31):
        with pytest.raises(ValueError, match="X: expected shape with at most 14 axes"):
            lie.exp(np.zeros((1,) * axes + (6,)))


OVERFLOWING = [[1e200, 1e200, 0], [1e200, -1e200, 0], [0, 0, 1]]
WRONG = {
    "no rotation": (lambda: lie.log_SO3(2 * np.eye(3)), "R: expected a rotation"),
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
    "a rotation for body": (lambda: lie.newton_euler(M, X, U, "body", R), "R: expected none"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_no_such_item_is_refused(kind):
    call, message = WRONG[kind]
    with pytest.raises(ValueError, match=message):
        call()


def test_float32_rotations_are_taken():
    assert close(lie.exp(lie.log(C.astype(np.float32))), C, 1e-6)


# ---------------------------------------------------------------- one body: the way back, and any pair of frames

def random_body(random, N):
    """Poses, inertia matrices, spatial twists and their rates."""
    C = lie.exp(random.normal(size=(N, 6)))
    A = random.normal(size=(N, 3, 3))
    M = lie.inertia(random.uniform(1, 2, N), random.normal(size=(N, 3)), A @ np.swapaxes(A, 1, 2) + np.eye(3))
    return C, M, random.normal(size=(N, 6)), random.normal(size=(N, 6))


@pytest.mark.parametrize("representation", ["body", "spatial", "hybrid", "mixed"])
def test_acceleration_undoes_newton_euler(representation):
    C, M, V, dV = random_body(np.random.default_rng(5), 50)
    W = lie.newton_euler(lie.transform_inertia(C, M), V, dV, "spatial")
    found = lie.acceleration(C, M, lie.change_twist(C, V, "spatial", representation),
                             lie.change_wrench(C, W, "spatial", representation), representation)
    expected = lie.change_twist_rate(C, V, dV, "spatial", representation)
    assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()
    with pytest.raises(ValueError, match="mass"):
        lie.acceleration(C[0], 0 * M[0], V[0], W[0])


def test_newton_euler_in_any_pair_of_frames_gives_the_same_wrench():
    random = np.random.default_rng(6)
    C, M, V, dV = random_body(random, 50)
    r_j, dr_j, w_k = random.normal(size=(3, 50, 3))
    jk = lie.FramePair(r_j, dr_j, lie.exp_SO3(random.normal(size=(50, 3))), w_k)
    W = lie.newton_euler(lie.transform_inertia(C, M), V, dV, "spatial")
    found = lie.newton_euler_in_frames(jk, lie.inertia_in_frames(jk, C, M), lie.twist_in_frames(jk, V),
                                       lie.twist_rate_in_frames(jk, V, dV))
    expected = lie.wrench_in_frames(jk, W)
    assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()
    first = lie.FramePair(*(part[0] for part in jk))
    assert np.array_equal(lie.wrench_in_frames(first, W[0]), expected[0])
    assert np.array_equal(lie.inertia_in_frames(first, C[0], M[0]), lie.inertia_in_frames(jk, C, M)[0])
    power = np.einsum("ni,ni->n", expected, lie.twist_in_frames(jk, V))
    assert np.allclose(power, np.einsum("ni,ni->n", W, V), rtol=1e-10)


def test_a_pair_of_frames_has_four_entries():
    for wrong in (None, 3, np.eye(4), ([0, 0, 0],) * 3):
        with pytest.raises((ValueError, TypeError), match="jk"):
            lie.twist_in_frames(wrong, np.zeros(6))
    with pytest.raises(ValueError, match="jk.R_k: expected a rotation"):
        lie.twist_in_frames(lie.FramePair([0, 0, 0], [0, 0, 0], np.zeros((3, 3)), [0, 0, 0]), np.zeros(6))
