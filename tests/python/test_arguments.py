"""Wrong arguments cause errors that name the argument, the expected value and the given one, and never a crash."""

import functools
import inspect
import types
import typing

import axode
import numpy as np
import pytest
from axode.table import ROWS
from calls import CALLS, tool
from mechanisms import MECHANISMS, random_states

ARM = MECHANISMS["arm"]
Q, V, A = np.zeros(7), np.zeros(7), np.zeros(7)
POSITION = {"q": 0, "v": 1, "a": 2}

WRONG = {
    "too short": (lambda x: x[..., :-1], r"{name}: expected shape \(7,\).*, got \(6,\)"),
    "too long": (lambda x: np.append(x, 0), r"{name}: expected shape \(7,\).*, got \(8,\)"),
    "a number": (lambda x: 1.0, r"{name}: expected shape \(7,\).*, got \(\)"),
    "a tensor": (lambda x: np.zeros((2, 3, 7)), r"{name}: expected shape .*, got \(2, 3, 7\)"),
    "complex": (lambda x: x + 0j, "{name}: expected real numbers .*, got dtype complex128"),
    "truth values": (lambda x: x == 0, "{name}: expected real numbers .*, got dtype bool"),
    "objects": (lambda x: np.array([None] * 7), "{name}: expected real numbers .*, got dtype object"),
    "dates": (lambda x: np.zeros(7, "datetime64[s]"), r"{name}: expected real numbers .*, got dtype datetime64\[s\]"),
    "masked": (lambda x: np.ma.masked_array(x, mask=np.arange(7) == 2), "{name}: has masked entries"),
    "text": (lambda x: "1234567", "{name}: expected real numbers .*, got str"),
    "ragged": (lambda x: [[1, 2], [3]], "{name}: expected numbers in rows of equal length, got list"),
    "a dict": (lambda x: {"A1": 0.0}, "{name}: expected real numbers .*, got dict"),
    "nan": (lambda x: np.where(np.arange(7) == 3, np.nan, x), r"{name}\[3\] is nan; expected finite numbers"),
    "infinite": (lambda x: np.where(np.arange(7) == 6, -np.inf, x), r"{name}\[6\] is -inf; expected finite numbers"),
}


@pytest.mark.parametrize("argument", POSITION)
@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_array_is_named_with_what_was_expected(argument, kind):
    make, message = WRONG[kind]
    state = [Q, V, A]
    state[POSITION[argument]] = make(state[POSITION[argument]])
    with pytest.raises(ValueError, match=message.format(name=argument)):
        axode.inverse_dynamics(ARM, *state)


@pytest.mark.parametrize("call", [call for call in CALLS if call not in ROWS])
def test_every_function_refuses_wrong_configurations(call):
    """Rows refuse each of their arrays in test_table.py."""
    m = MECHANISMS["machine"]
    q, v, a, _ = random_states(m, 3)
    for wrong in (q[:, :-1], np.where(q == q[1, 2], np.nan, q), q[None], q + 0j):
        with pytest.raises(ValueError, match=r"^q"):
            CALLS[call](m, wrong, v, a)


def test_states_must_be_of_one_number():
    with pytest.raises(ValueError, match=r"v: expected shape \(3, 7\), 3 states, .*, got \(2, 7\)"):
        axode.inverse_dynamics(ARM, np.zeros((3, 7)), np.zeros((2, 7)), np.zeros((3, 7)))
    with pytest.raises(ValueError, match=r"v: expected shape \(3, 7\), 3 states, .*, got \(7,\)"):
        axode.inverse_dynamics(ARM, np.zeros((3, 7)), V, np.zeros((3, 7)))


def test_the_place_of_what_is_not_finite_is_named():
    q = np.zeros((5, 7))
    q[4, 2] = np.inf
    with pytest.raises(ValueError, match=r"q\[4, 2\] is inf; expected finite numbers"):
        axode.mass_matrix(ARM, q)


@pytest.mark.parametrize("representation", ["fast", "body", "hybrid"])
def test_a_quaternion_off_1_is_refused_with_its_state_and_joint(representation):
    m = MECHANISMS["humanoid"]
    q, v, a, _ = random_states(m, 3)
    q[1, m.joint("free_base").q] *= 1.01
    with pytest.raises(ValueError, match=r'state 1: .*"free_base".*'):
        axode.inverse_dynamics(m, q, v, a, representation)
    with pytest.raises(ValueError, match=r'^q.*"free_base".*'):
        axode.inverse_dynamics(m, q[1], v[1], a[1], representation)


def test_unknown_names_are_key_errors_with_the_nearest_name():
    for ask in (lambda: axode.jacobian(ARM, Q, "flang"), lambda: ARM.frame_pose("flang"),
                lambda: axode.inverse_dynamics(ARM, Q, V, A, loads=[{"frame": "flang", "wrench": np.zeros(6)}]),
                lambda: axode.relative_jacobian(ARM, Q, "link 1", "flang")):
        with pytest.raises(KeyError, match='has no frame "flang"; did you mean "flange"?'):
            ask()
    with pytest.raises(KeyError, match='has no joint "A8"'):
        ARM.joint("A8")
    with pytest.raises(KeyError, match='has no body "link"'):
        ARM.body("link")
    with pytest.raises(KeyError, match='has no joint "A8"'):
        ARM.reduced(["A8"], Q)


@pytest.mark.parametrize("frame", [-1, 10, 10**30, np.int64(10), True, 1.0, b"flange", ["flange"]])
def test_what_is_no_frame_is_refused(frame):
    with pytest.raises(ValueError, match="^frame is .*; (expected|model)"):
        axode.jacobian(ARM, Q, frame)


@pytest.mark.parametrize("word", ["Body", "", 3, b"body", "fast "])
def test_unknown_words_are_refused_with_those_there_are(word):
    with pytest.raises(ValueError, match="representation is .*; expected one of 'fast', 'body', 'spatial'"):
        axode.inverse_dynamics(ARM, Q, V, A, word)
    with pytest.raises(ValueError, match="representation is .*; expected one of 'body', 'spatial', 'hybrid', 'mixed'"):
        axode.twists(ARM, Q, V, word)
    with pytest.raises(ValueError, match="form is .*; expected one of 'paper', 'skew', 'spatial', 'christoffel'"):
        axode.coriolis_matrix(ARM, Q, V, word)


LOADS = {
    "no list": (5, "loads: expected a list of dicts"),
    "a dict": ({"frame": "flange", "wrench": np.zeros(6)}, "loads: expected a list of dicts"),
    "no dict": ([np.zeros(6)], r"loads\[0\]: expected a dict, got numpy.ndarray"),
    "short": ([{"frame": "flange", "wrench": np.zeros(5)}], r"loads\[0\].wrench: expected shape \(6,\).*got \(5,\)"),
    "nan": ([{"frame": "flange", "wrench": [0, 0, 0, 0, np.nan, 0]}], r"loads\[0\].wrench\[4\] is nan"),
    "word": ([{"frame": "flange", "wrench": np.zeros(6), "representation": "world"}],
             r"loads\[0\].representation is 'world'; expected one of 'body'"),
    "second": ([{"frame": "flange", "wrench": np.zeros(6)}, {"frame": 99, "wrench": np.zeros(6)}],
               r"loads\[1\].frame is 99"),
}


@pytest.mark.parametrize("kind", LOADS)
def test_a_wrong_load_is_named(kind):
    loads, message = LOADS[kind]
    with pytest.raises(ValueError, match=message):
        axode.inverse_dynamics(ARM, Q, V, A, loads=loads)


def test_wrong_keys_of_a_load_are_key_errors():
    with pytest.raises(KeyError, match="loads.0. has no wrench"):
        axode.inverse_dynamics(ARM, Q, V, A, loads=[{"frame": "flange"}])
    with pytest.raises(KeyError, match="loads.0.: a key is .*wrenhc.*did you mean .*wrench"):
        axode.inverse_dynamics(ARM, Q, V, A, loads=[{"frame": "flange", "wrenhc": np.zeros(6)}])


def test_offsets_are_points_or_poses():
    with pytest.raises(ValueError, match=r"offset: expected shape \(3,\).* in it, got \(2,\)"):
        axode.jacobian(ARM, Q, "flange", offset=[1, 2])
    with pytest.raises(ValueError, match="offset: expected a pose"):
        axode.jacobian(ARM, Q, "flange", offset=np.full((4, 4), 2.0))


def test_the_part_of_the_way_is_a_number():
    for s in (np.nan, "half", [0.5]):
        with pytest.raises(ValueError, match="^s(:| is) "):
            ARM.interpolate(Q, Q, s)


def test_orders_out_of_range_are_refused():
    for order in (-1, 30):
        with pytest.raises(ValueError, match=f"order is {order}; expected 0 to 29, as an array has at most 32 axes"):
            axode.jacobian_partials(ARM, Q, "flange", order=order)
    with pytest.raises(ValueError, match="order is 25; .* are more than an array can have"):
        axode.jacobian_partials(ARM, Q, "flange", order=25)
    with pytest.raises((ValueError, MemoryError)):
        axode.jacobian_partials(ARM, Q, "flange", order=12)
    with pytest.raises(ValueError, match="rates is empty; expected at least one row"):
        axode.twist_derivatives(ARM, Q, np.zeros((0, 7)), "flange")


WRONG_CALLS = {
    "inverse_dynamics has no argument 'load'; did you mean 'loads'?":
        lambda: axode.inverse_dynamics(ARM, Q, V, A, load=[]),
    "mass_matrix has no argument 'wind'; it takes m, q, representation, threads":
        lambda: axode.mass_matrix(ARM, Q, wind=3),
    "inverse_dynamics needs 'a' as well": lambda: axode.inverse_dynamics(ARM, Q, V),
    "inverse_dynamics needs 'q', 'v' and 'a' as well": lambda: axode.inverse_dynamics(ARM),
    "inverse_dynamics takes at most 6 arguments by their places (m, q, v, a, representation, loads), got 7; "
    "write joint_losses=... for an argument by name":
        lambda: axode.inverse_dynamics(ARM, Q, V, A, "fast", None, True),
    "inverse_dynamics is given 'q' twice, by place and by name": lambda: axode.inverse_dynamics(ARM, Q, V, A, q=Q),
    "Model.joint has no argument 'nam'; did you mean 'name'?": lambda: ARM.joint(nam="A1"),
    "Model.interpolate needs 's' as well": lambda: ARM.interpolate(Q, Q),
    "Model.neutral takes at most 0 arguments by their places, got 1": lambda: ARM.neutral(Q),
    "Model.from_bodies has no argument 'bodys'; did you mean 'bodies'?": lambda: axode.Model.from_bodies(bodys=[]),
    "exp needs 'X' as well": lambda: axode.lie.exp(),
    "mass_matrix: m: expected an axode.Model, got int": lambda: axode.mass_matrix(3, Q),
    "mass_matrix: threads: expected a whole number, got float": lambda: axode.mass_matrix(ARM, Q, threads=1.5),
    "mass_matrix: threads is 4294967296; it is too large": lambda: axode.mass_matrix(ARM, Q, threads=2**32),
    "Model.random: seed is -1; it must not be negative": lambda: ARM.random(seed=-1),
    "Model.from_dict: drawing: expected a dict, got list": lambda: axode.Model.from_dict([]),
    "inverse_dynamics: joint_losses: expected True or False, got str":
        lambda: axode.inverse_dynamics(ARM, Q, V, A, joint_losses="no"),
    "mass_matrix: q: expected numpy.typing.ArrayLike, got NoneType": lambda: axode.mass_matrix(ARM, None),
    "simulate has no argument 'metod'; did you mean 'method'?": lambda: axode.simulate(ARM, Q, V, 1.0, metod="rk4"),
    "simulate needs 'v' and 'until' as well": lambda: axode.simulate(ARM, Q),
    "load has no argument 'gravty'; did you mean 'gravity'?": lambda: axode.load("arm.toml", gravty=[0, 0, 0]),
    "Builder.build has no argument 'stric'; did you mean 'strict'?": lambda: axode.Builder("b").build(stric=True),
    "PD has no argument 'k_p'; did you mean 'kp'?": lambda: axode.drives.PD(k_p=1),
    "MassMatrixFactor has no argument 'mm'; did you mean 'm'?": lambda: axode.MassMatrixFactor(mm=ARM, M=None),
    "Viewer has no argument 'moton'; did you mean 'motion'?": lambda: axode.Viewer(ARM, moton=None),
}


@pytest.mark.parametrize("sentence", WRONG_CALLS)
def test_a_wrong_call_says_what_is_wrong_with_it(sentence):
    with pytest.raises(TypeError) as found:
        WRONG_CALLS[sentence]()
    assert str(found.value) == sentence


# What only other functions make.
WITHOUT_CONSTRUCTOR = {axode.Model, axode.Body, axode.Joint, axode.Trajectory, axode.codegen.Specialised}


def public_callables():
    """Functions, constructors and methods of all modules, with the names by which errors call them."""
    modules = [axode, axode.lie, axode.closed_form, axode.codegen, axode.convert, axode.drives, axode.identification,
               axode.calibration]
    for value in {id(x): x for module in modules for x in map(module.__dict__.get, module.__all__)}.values():
        # A dict, whose keys are checked where it is used.
        if not callable(value) or typing.is_typeddict(value):
            continue
        if value not in WITHOUT_CONSTRUCTOR:
            yield value.__qualname__, value
        for name, method in vars(value).items() if isinstance(value, type) else ():
            if isinstance(method, types.FunctionType) and not name.startswith("_"):
                if all(x.kind is not x.VAR_KEYWORD for x in inspect.signature(method).parameters.values()):
                    yield method.__qualname__, functools.partial(method, None)


def test_every_function_constructor_and_method_names_an_argument_that_it_has_not():
    found = list(public_callables())
    assert len(found) > 200
    for name, function in found:
        with pytest.raises(TypeError) as error:
            function(no_such=1)
        assert str(error.value).startswith(f"{name} has no argument 'no_such'; "), f"{name}: {error.value}"


def test_errors_within_what_is_called_stay_what_they_are():
    with pytest.raises(TypeError, match="^mine$"):
        axode.simulate(ARM, Q, V, 0.1, tau=lambda *_: (_ for _ in ()).throw(TypeError("mine")))


@pytest.mark.parametrize("call", CALLS)
def test_what_is_no_model_is_a_type_error(call):
    _, v, a, _ = random_states(ARM, 1)

    class Almost:
        frame_names, body_names, n_bodies = ARM.frame_names, ARM.body_names, ARM.n_bodies
        integrate = difference = interpolate = clamp = staticmethod(lambda *_: axode.poses(None, Q))
        normalize = coordinate_rates = velocities_from_rates = integrate

    with pytest.raises(TypeError):
        CALLS[call](Almost(), Q, v[0], a[0])


def test_singular_states_are_named_and_the_others_are_not_lost():
    m = axode.Model.from_bodies([
        {"name": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [1, 0, 0],
         "inertia": [1, 1, 1]},
        {"name": "wrist", "on": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}}])
    assert [fault.rule for fault in m.warnings] == ["moves_no_mass"]
    q = np.zeros((5, 2))
    for call in (lambda q: axode.forward_dynamics(m, q, 0 * q, 0 * q), lambda q: axode.inverse_mass_matrix(m, q),
                 lambda q: axode.forward_dynamics(m, q, 0 * q, 0 * q, "hybrid"),
                 lambda q: axode.from_momenta(m, q, 0 * q), lambda q: axode.inverse_mass_matrix(m, q, "body")):
        with pytest.raises(axode.SingularError, match='state 0 and 4 others: .*"wrist') as caught:
            call(q)
        assert caught.value.states == [0, 1, 2, 3, 4]
        assert caught.value.result.shape[0] == 5 and np.isnan(caught.value.result).all()
        with pytest.raises(axode.SingularError, match='^the mass matrix is singular: .*"wrist') as caught:
            call(q[0])
        assert caught.value.states == [0]
    with pytest.raises(axode.SingularError):
        axode.MassMatrixFactor(m, axode.mass_matrix(m, q[0]))


def test_a_massless_mechanism_has_no_center_of_mass():
    m = axode.Model.from_bodies([{"name": "slide", "joint": {"kind": "prismatic", "axis": "z"}}])
    with pytest.raises(ValueError, match="mass"):
        axode.center_of_mass(m, [0.0])


def test_the_last_frame_is_a_frame_of_the_tool():
    assert tool(ARM) == "flange"
