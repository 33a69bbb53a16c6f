"""Functions for CasADi give the values of the library, and their derivatives equal those that CasADi computes itself."""

import doctest
import os
import pickle
import subprocess
import sys

import axode
import axode.casadi
import casadi as ca
import numpy as np
import pytest
from axode.table import ROWS
from mechanisms import MECHANISMS
from properties import WITH, assert_same_or_refused, state

QUICK = ["-O0"]
MODELS = {
    "arm": MECHANISMS["arm"],
    "machine": MECHANISMS["machine"],
    "walker": axode.Model.from_bodies(
        [{"name": "trunk", "joint": "free", "mass": 4, "com": [0, 0.1, 1.2], "inertia": [0.2, 0.3, 0.1]},
         *[{"name": f"{side} leg", "on": "trunk", "mass": 1, "com": [0.05, y, 0.5], "inertia": [0.1, 0.12, 0.02],
            "joint": {"kind": "revolute", "axis": [0.1, 1, 0], "point": [0, y, 1]}} for side, y in (("left", 0.2), ("right", -0.2))]],
        name="walker"),
}
FRAMES = {"arm": "flange", "machine": "chip", "walker": "left leg"}


# Expressions (SX), which CasADi can differentiate itself.
FROM_CASADI = ["coordinate_rates", "integrate", "difference"]


def quantities(name):
    some = ["forward_dynamics", "inverse_dynamics", "mass_matrix", "inverse_mass_matrix", *FROM_CASADI]
    return some if name == "arm" else [*some, "poses", ("pose", FRAMES[name]), ("jacobian", FRAMES[name]),
                                       ("jacobian", FRAMES[name], "mixed")]


CASES = [(name, quantity) for name in MODELS for quantity in quantities(name)]
CASES += [("humanoid", ("pose", MECHANISMS["humanoid"].frame_names[-1])), ("humanoid", ("jacobian", MECHANISMS["humanoid"].frame_names[-1], "spatial"))]
MODELS["humanoid"] = MECHANISMS["humanoid"]
HAND = ("jacobian", MECHANISMS["humanoid"].frame_names[-1], "spatial")


def function(name, quantity):
    return axode.casadi.function(MODELS[name], quantity, flags=QUICK)


def arguments(F, m, seed=0):
    """A random state whose quaternions have a length that is near 1, but not 1."""
    random = np.random.default_rng(seed)
    length = 1 + 0.1 * random.random() * (m.nq != m.nv)
    q = {"q": m.random(seed=seed) * length, "q0": m.random(seed=seed) * length, "q1": m.random(seed=seed + 1)}
    return [ca.DM(q[F.name_in(k)] if F.name_in(k) in q else random.uniform(-1, 1, F.size1_in(k))) for k in range(F.n_in())]


def in_one(matrices):
    return ca.vertcat(*[ca.vec(ca.densify(x)) for x in matrices])


def numbers(x):
    return np.array(in_one(x)).ravel()


def weights(F, seed=1):
    random = np.random.default_rng(seed)
    return [ca.DM(F.sparsity_out(k), random.uniform(-1, 1, F.nnz_out(k))) for k in range(F.n_out())]


def jacobian(F, x):
    """The derivatives of all results by all arguments, as CasADi computes them for expressions."""
    symbols = [ca.MX.sym(F.name_in(k), F.sparsity_in(k)) for k in range(F.n_in())]
    y = in_one(F.call(symbols))
    return np.array(ca.Function("J", symbols, [ca.horzcat(*[ca.jacobian(y, s) for s in symbols])]).call(x)[0])


def by_differences(f, x, h=1e-5):
    """The derivative of the vector f(list of vectors) by all entries of these vectors, by differences."""
    sizes = np.cumsum([0] + [part.numel() for part in x])
    all_x = numbers(x)
    columns = []
    for k in range(len(all_x)):
        ends = []
        for step in (h, -h):
            moved = all_x.copy()
            moved[k] += step
            ends.append(f([ca.reshape(ca.DM(moved[a:b]), *part.shape) for part, a, b in zip(x, sizes, sizes[1:])]))
        columns.append((ends[0] - ends[1]) / (2 * h))
    return np.array(columns).T.reshape(-1, len(all_x))


def assert_near(x, y, tolerance):
    scale = max(np.abs(y).max(initial=0), 1)
    assert np.shape(x) == np.shape(y)
    assert np.abs(np.subtract(x, y)).max(initial=0) <= tolerance * scale


@pytest.mark.parametrize(("name", "quantity"), CASES)
def test_values_are_those_of_the_library(name, quantity):
    m, F = MODELS[name], function(name, quantity)
    x = [np.array(part).ravel() for part in arguments(F, m)]
    given = m.normalize(x[0])
    word = quantity if isinstance(quantity, str) else quantity[0]
    if word == "pose":
        expected = [axode.poses(m, given)[m.frame_index(quantity[1])]]
    elif word == "poses":
        expected = axode.poses(m, given)
    elif word == "jacobian":
        expected = [axode.jacobian(m, given, *quantity[1:])]
    elif word == "coordinate_rates":
        x[0] = given
        expected = [m.coordinate_rates(*x)]
    elif word == "integrate":
        expected = [m.integrate(given, x[1])]
    elif word == "difference":
        expected = [m.difference(given, m.normalize(np.ravel(x[1])))]
    else:
        expected = [getattr(axode, word)(m, given, *x[1:])]
    results = F.call(x)
    assert len(results) == len(expected)
    for result, wanted in zip(results, expected):
        assert_near(np.array(result).reshape(np.shape(wanted), order="F"), wanted, 1e-9)


@pytest.mark.parametrize(("name", "quantity"), CASES)
def test_first_derivatives_are_those_of_differences(name, quantity):
    F = function(name, quantity)
    x = arguments(F, MODELS[name])
    J = jacobian(F, x)
    assert_near(J, by_differences(lambda at: numbers(F.call(at)), x), 1e-5)
    y = F.call(x)
    direction = [ca.DM(np.random.default_rng(k).uniform(-1, 1, part.shape)) for k, part in enumerate(x)]
    assert_near(numbers(F.forward(1).call(x + y + direction)), J @ numbers(direction), 1e-9)
    w = weights(F)
    assert_near(numbers(F.reverse(1).call(x + y + w)), J.T @ numbers(w), 1e-9)


def assert_second_derivatives(F, x, symmetric):
    w = weights(F)
    symbols = [ca.MX.sym(F.name_in(k), F.sparsity_in(k)) for k in range(F.n_in())]
    value = ca.dot(in_one(F.call(symbols)), in_one(w))
    gradient = ca.Function("gradient", symbols, [in_one([ca.vec(ca.gradient(value, s)) for s in symbols])])
    H = jacobian(gradient, x)
    assert_near(H, by_differences(lambda at: numbers(gradient.call(at)), x), 1e-5)
    assert not symmetric or np.array_equal(H, H.T)


@pytest.mark.parametrize(("name", "quantity"), [case for case in CASES if case[1] != "inverse_mass_matrix"])
def test_second_derivatives_are_those_of_differences_and_symmetric(name, quantity):
    F = function(name, quantity)
    assert_second_derivatives(F, arguments(F, MODELS[name]), symmetric=quantity not in FROM_CASADI)


@pytest.mark.parametrize("quantity", ["forward_dynamics", "mass_matrix", "poses"])
def test_the_length_of_quaternions_does_not_count(quantity):
    m, F = MODELS["machine"], function("machine", quantity)
    x = arguments(F, m)
    longer = np.array(x[0]).ravel()
    for joint in m.joints:
        if joint.kind in ("spherical", "free"):
            longer[joint.q][:4] *= -3
    assert_near(numbers(F.call([longer, *x[1:]])), numbers(F.call(x)), 1e-9)


@pytest.mark.parametrize(("name", "quantity", "share"), [("machine", "forward_dynamics", 0.2), ("machine", "mass_matrix", 0.02),
                                                         ("walker", "inverse_dynamics", 0.8), ("humanoid", HAND, 0.2)])
def test_patterns_have_what_is_there_and_little_else(name, quantity, share):
    F = function(name, quantity)
    given = [arguments(F, MODELS[name], seed) for seed in range(3)]
    values = F.jacobian()
    found = [values.call(x + F.call(x)) for x in given]
    for k in range(values.n_out()):
        pattern = np.array(ca.DM(values.sparsity_out(k), 1).full() != 0)
        seen = np.any([np.abs(blocks[k].full()) > 1e-13 for blocks in found], axis=0)
        assert not np.any(seen & ~pattern)
        assert pattern.sum() <= seen.sum() * 1.25
    entries, all_entries = (sum(count(k) for k in range(values.n_out())) for count in (values.nnz_out, values.numel_out))
    assert 0 < entries < share * all_entries


def test_rates_of_coordinates_move_the_frames_as_their_twists_say():
    m = MODELS["machine"]
    pose, rates = function("machine", ("pose", "chip")), function("machine", "coordinate_rates")
    q, v = m.normalize(m.random(seed=4)), np.random.default_rng(4).uniform(-1, 1, m.nv)
    along = np.array(pose.forward(1)(q, pose(q), rates(q, v)))
    J = axode.jacobian(m, q, "chip", "hybrid")
    turn = J[:3] @ v
    C = axode.poses(m, q)[m.frame_index("chip")]
    assert_near(along[:3, 3], J[3:] @ v, 1e-12)
    assert_near(along[:3, :3], np.cross(turn, C[:3, :3].T).T, 1e-12)


@pytest.mark.parametrize("angle", [0, 1e-9, 1e-3, 0.19, 0.21, 0.99, 1.01, 3.0, np.pi - 1e-6])
def test_steps_and_differences_are_inverse_at_every_angle_and_have_derivatives(angle):
    m = MODELS["machine"]
    step, back = function("machine", "integrate"), function("machine", "difference")
    q, dv = m.normalize(m.random(seed=4)), np.random.default_rng(4).uniform(-1, 1, m.nv)
    for joint in m.joints:
        if joint.kind in ("spherical", "free", "planar"):
            rotation = dv[joint.v][:1 if joint.kind == "planar" else 3]
            rotation *= angle / np.linalg.norm(rotation)
    assert_near(numbers([step(q, dv)]), m.integrate(q, dv), 1e-14)
    assert_near(numbers([back(q, m.integrate(q, dv))]), dv, 1e-13)
    x = ca.MX.sym("x", m.nv)
    there_and_back = ca.Function("there_and_back", [x], [back(q, step(q, x))])
    J = ca.Function("J", [x], [ca.jacobian(there_and_back(x), x)])
    assert_near(np.array(J(dv)), np.eye(m.nv), 1e-13)
    H = ca.Function("H", [x], [ca.hessian(ca.sum1(there_and_back(x)), x)[0]])
    assert np.abs(np.array(H(dv))).max() < 1e-13


def test_arguments_may_be_absent_and_results_unwanted():
    F = function("machine", "poses")
    q = ca.MX.sym("q", F.size1_in(0))
    one = ca.Function("one", [q], [F(q)[F.index_out("C_chip")], ca.jacobian(F(q)[F.index_out("C_pointer")][:3, 3], q)])
    x = arguments(F, MODELS["machine"])[0]
    assert_near(numbers([one(x)[0]]), numbers([F(x)[F.index_out("C_chip")]]), 1e-15)
    G = function("arm", "forward_dynamics")
    still = G(ca.DM(7, 1), ca.DM(7, 1), ca.DM(7, 1))  # without entries
    assert_near(numbers([still]), axode.forward_dynamics(MODELS["arm"], *np.zeros((3, 7))), 1e-9)


def test_one_joint_has_second_derivatives():
    m = axode.Model.from_bodies([{"name": "rod", "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]}, "mass": 2,
                                  "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.1]}])
    x = ca.MX.sym("x")
    for quantity in ("forward_dynamics", "inverse_dynamics"):
        y = axode.casadi.function(m, quantity, flags=QUICK)(x, 0, 0)
        H = ca.Function("H", [x], [ca.hessian(y, x)[0]])
        sign = 1 if quantity == "forward_dynamics" else -0.6
        assert float(H(0.5)) == pytest.approx(sign * 2 * 9.81 * 0.5 / 0.6 * np.sin(0.5))
    z = axode.casadi.function(m, ("pose", "rod"), flags=QUICK)(x)[0, 0]
    assert float(ca.Function("H", [x], [ca.hessian(z, x)[0]])(0.5)) == pytest.approx(-np.cos(0.5))


def test_a_mechanism_that_does_not_move_has_functions():
    m = axode.Model.from_bodies([{"name": "block", "joint": {"kind": "fixed"}, "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    for quantity, shape in {"forward_dynamics": (0, 1), "mass_matrix": (0, 0), "inverse_mass_matrix": (0, 0), ("pose", "block"): (4, 4),
                            "coordinate_rates": (0, 1)}.items():
        F = axode.casadi.function(m, quantity, flags=QUICK)
        assert F.call([ca.DM(*F.size_in(k)) for k in range(F.n_in())])[0].shape == shape
        F.jacobian()


def test_a_mass_matrix_that_is_the_same_everywhere_has_an_inverse_without_derivatives():
    point = {"com": [0, 0, 0], "inertia": [0, 0, 0]}
    m = axode.Model.from_bodies([
        {"name": "cart", "joint": {"kind": "prismatic", "axis": "x", "point": [0, 0, 0]}, "mass": 2, **point},
        {"name": "slide", "on": "cart", "joint": {"kind": "prismatic", "axis": [1, 1, 0], "point": [0, 0, 0]}, "mass": 1, **point}])
    F = axode.casadi.function(m, "inverse_mass_matrix", 2, flags=QUICK)
    q = ca.DM([[0.1, 0.2], [0.3, 0.4]])
    assert_near(np.array(F(q)), np.hstack(2 * [np.linalg.inv(axode.mass_matrix(m, [0, 0]))]), 1e-12)
    assert F.jacobian().nnz_out(0) == 0
    assert_near(numbers([F.forward(1)(q, F(q), q)]), np.zeros(8), 1e-15)
    assert_near(numbers([F.reverse(1)(q, F(q), F(q))]), np.zeros(4), 1e-15)


def test_the_inverse_mass_matrix_has_first_derivatives_and_casadis_own_inverse_second_ones():
    A, M = function("machine", "inverse_mass_matrix"), function("machine", "mass_matrix")
    q = ca.MX.sym("q", A.size1_in(0))
    w = ca.DM(np.random.default_rng(1).uniform(-1, 1, A.size_out(0)))
    x = arguments(A, MODELS["machine"])
    found, expected = (ca.Function("g", [q], [ca.gradient(ca.dot(w, inverse), q)]) for inverse in (A(q), ca.inv(M(q))))
    assert_near(found.call(x)[0].full(), expected.call(x)[0].full(), 1e-9)
    H = ca.Function("H", [q], [ca.hessian(ca.dot(w, ca.inv(M(q))), q)[0]])
    assert_near(H.call(x)[0].full(), by_differences(lambda at: numbers(found.call(at)), x), 1e-5)
    with pytest.raises(RuntimeError, match="[Dd]erivative"):
        ca.hessian(ca.dot(w, A(q)), q)


def test_of_many_states_it_is_the_function_of_each_with_derivatives_on_the_diagonal():
    F, G = function("walker", "inverse_dynamics"), axode.casadi.function(MODELS["walker"], "inverse_dynamics", 4, flags=QUICK)
    states = [arguments(F, MODELS["walker"], seed) for seed in range(4)]
    together = [ca.horzcat(*column) for column in zip(*states)]
    assert np.array_equal(G.call(together)[0].full(), np.column_stack([F.call(x)[0].full() for x in states]))
    J, alone = G.jacobian(), F.jacobian()
    blocks = [alone.call(x + F.call(x)) for x in states]
    for k, matrix in enumerate(J.call(together + G.call(together))):
        expected = ca.diagcat(*[block[k] for block in blocks])
        assert matrix.sparsity() == expected.sparsity() and np.array_equal(matrix.full(), expected.full())
    for quantity in ("coordinate_rates", ("pose", "trunk")):
        one, four = function("walker", quantity), axode.casadi.function(MODELS["walker"], quantity, 4, flags=QUICK)
        n = one.n_in()
        assert_near(four.call(together[:n])[0].full(), np.hstack([one.call(x[:n])[0].full() for x in states]), 1e-15)


@pytest.mark.parametrize("quantity", ["mass_matrix", "coordinate_rates"])
def test_numbers_of_states_that_there_are_not_are_refused(quantity):
    m = MODELS["walker"]
    for states, wrong in ((0, ValueError), (-3, ValueError), (2**31, ValueError), (1.5, TypeError), ("a", TypeError)):
        with pytest.raises(wrong, match=f"states is {states!r}; expected"):
            axode.casadi.function(m, quantity, states)


def test_the_hessian_of_many_states_is_exact():
    m = MODELS["machine"]
    F = axode.casadi.function(m, "forward_dynamics", 2, flags=QUICK)
    assert_second_derivatives(F, [ca.horzcat(*pair) for pair in zip(*[arguments(function("machine", "forward_dynamics"), m, k)
                                                                     for k in range(2)])],
                              symmetric=True)


def test_threads_share_a_function():
    m, F = MODELS["arm"], function("arm", "forward_dynamics")
    states = np.random.default_rng(5).uniform(-1, 1, (3, 7, 64))
    for kind in ("serial", "thread", "openmp"):
        assert_near(np.array(F.map(64, kind, 4)(*states)), axode.forward_dynamics(m, *states.transpose(0, 2, 1)).T, 1e-9)


def test_pickled_it_is_the_same_here_and_in_another_process(tmp_path):
    F = function("arm", "forward_dynamics")
    x = [np.full(7, 0.1 * k) for k in (1, 2, 3)]
    (tmp_path / "F.pickle").write_bytes(pickle.dumps(F))
    program = "import casadi, pickle, sys; F = pickle.load(open(sys.argv[1], 'rb')); print(F(*[[0.1 * k] * 7 for k in (1, 2, 3)]))"
    done = subprocess.run([sys.executable, "-c", program, tmp_path / "F.pickle"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str(F(*x)) == str(pickle.loads(pickle.dumps(F))(*x))


def test_it_needs_no_cache():
    program = ("import axode, axode.casadi, casadi\n"
               "arm = axode.load(axode.robots / 'arm7.toml')\n"
               "F = axode.casadi.function(arm, 'mass_matrix', flags=['-O0'])\n"
               "x = casadi.MX.sym('x', 7)\n"
               "print(axode.codegen.cache().models, casadi.Function('J', [x], [casadi.jacobian(F(x), x)])(1).shape)\n")
    environment = {**os.environ, "XDG_CACHE_HOME": "/proc/none", "HOME": "/proc/none"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.stdout == "0 (49, 7)\n", done.stderr


def test_evaluation_fails_where_the_mass_matrix_is_singular():
    m = axode.Model.from_bodies([
        {"name": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [1, 0, 0],
         "inertia": [1, 1, 1]},
        {"name": "wrist", "on": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}}])
    F = axode.casadi.function(m, "forward_dynamics", flags=QUICK)
    with pytest.raises(RuntimeError, match="failed"):
        F([0, 0], [0, 0], [0, 1])
    arm = function("arm", "forward_dynamics")
    with pytest.raises(RuntimeError, match="failed"):
        arm(np.full(7, np.nan), np.zeros(7), np.zeros(7))


ARM = MODELS["arm"]
WRONG = {
    "a function of another library": (ARM, "crba", ValueError, "quantity is 'crba'; .*it is called 'mass_matrix' here"),
    "a derivative": (ARM, "forward_dynamics_hessian", ValueError,
                     "forward_dynamics_hessian comes with forward_dynamics for CasADi, as jac_, fwd1_, adj1_ and jac_adj1_"),
    "a pose of nothing": (ARM, "pose", ValueError, r'quantity is \'pose\'; expected .*\("pose", frame\)'),
    "a pose in a representation": (ARM, ("pose", "flange", "body"), ValueError, r"quantity is \('pose', .*expected"),
    "an unknown frame": (ARM, ("pose", "flang"), KeyError, 'has no frame "flang"; did you mean "flange"'),
    "an unknown representation": (ARM, ("jacobian", "flange", "world"), ValueError, "representation is 'world'; expected one of"),
    "a list": (ARM, ["mass_matrix"], ValueError, r"quantity is \['mass_matrix'\]; expected"),
}


@pytest.mark.parametrize("states", [1, 3])
def test_distances_of_shapes_have_a_jacobian(states):
    m = axode.load(axode.robots / "quadruped.toml")
    pairs = axode.shape_pairs(m)[:5]
    F = axode.casadi.function(m, ("pair_distances", pairs), states)
    q = 1.1 * m.random(seed=3, n=states).T
    assert F.name_in(0) == "q" and F.size_in(0) == (m.nq, states) and F.size_out(0) == (5, states)
    at = m.normalize(q.T)
    assert_near(F(q).full(), axode.pair_distances(m, at, pairs).distances.T, 1e-12)
    assert_near(jacobian(F, [ca.DM(q)]), by_differences(lambda x: numbers(F.call(x)), [ca.DM(q)]), 1e-7)
    x = ca.MX.sym("q", m.nq, states)
    gradient = ca.Function("gradient", [x], [ca.gradient(ca.sum1(ca.vec(axode.casadi.function(m, ("pair_distances", pairs), states)(x))), x)])
    assert_near(gradient(q).full().ravel(order="F"), jacobian(F, [ca.DM(q)]).sum(axis=0), 1e-12)
    assert axode.casadi.function(m, "pair_distances").size_out(0) == (len(axode.shape_pairs(m)), 1)
    with pytest.raises(KeyError, match='no collision shape "paw"'):
        axode.casadi.function(m, ("pair_distances", [("floor", "paw")]))


@pytest.mark.parametrize("case", WITH)
@pytest.mark.parametrize("quantity", ["forward_dynamics", "inverse_dynamics", "mass_matrix"])
def test_no_function_answers_for_another_mechanism(case, quantity):
    _, m = WITH[case]
    given = state(m, ROWS[quantity])

    def found():
        value = np.array(axode.casadi.function(m, quantity, flags=QUICK)(*given.values()))
        return value.reshape(ROWS[quantity].item(m))

    assert_same_or_refused(quantity, found, lambda: getattr(axode, quantity)(m, **given))


@pytest.mark.parametrize("kind", WRONG)
def test_what_it_cannot_do_is_said(kind):
    m, quantity, error, message = WRONG[kind]
    with pytest.raises(error, match=message):
        axode.casadi.function(m, quantity)


def test_names_are_such_that_casadi_takes_them():
    m = axode.Model.from_bodies(
        [{"name": "a", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [1, 0, 0],
          "inertia": [1, 1, 1]}],
        [{"name": name, "on": "a", "position": [1, k, 0]} for k, name in enumerate(["_tool--1_", "tool_1", "tool 1", "Hand (left)", "é"])],
        name="_my  robot!")
    F = axode.casadi.function(m, "poses", flags=QUICK)
    assert F.name() == "my_robot_poses"
    assert F.name_out()[2:] == ["C_tool_1", "C_tool_1_2", "C_tool_1_3", "C_Hand_left", "C_frame"]
    for name in m.frame_names:
        axode.casadi.function(m, ("jacobian", name, "hybrid"), flags=QUICK).jacobian()
    with pytest.raises(ValueError, match='the prefix "my__robot" is not a name in CasADi'):
        axode.codegen.c_source(m, ["mass_matrix"], prefix="my__robot", abi="casadi")
    with pytest.raises(ValueError, match="CasADi computes in double"):
        axode.codegen.c_source(m, ["mass_matrix"], single_precision=True, abi="casadi")
    with pytest.raises(ValueError, match="abi is 'cuda'|abi is 'matlab'"):
        axode.codegen.c_source(m, ["mass_matrix"], abi="matlab")


def test_the_examples_in_docstrings_are_so():
    names = {"axode": axode, "np": np, "arm": ARM}
    for test in doctest.DocTestFinder(recurse=False).find(axode.casadi.function, globs=names):
        assert doctest.DocTestRunner().run(test).failed == 0 and test.examples
