"""A mechanism with each property that a row of the table may count, and the law that no function answers for another
mechanism than the one that it was given."""

import axode
import numpy as np


def arm(shoulder=None, hand=None, **more):
    """A carriage, an upper arm and a hand, with more keys of the shoulder, the hand and the drawing."""
    joint = {"name": "shoulder", "kind": "revolute", "axis": "y", "point": [0, 0, 0]}
    return axode.Model.from_dict({"format": "axode drawing 1", "name": "arm", "body": [
        {"name": "carriage", "joint": {"name": "slide", "kind": "prismatic", "axis": "x"}, "mass": 3, "com": [0, 0, 0],
         "inertia": [1, 1, 1]},
        {"name": "upper arm", "on": "carriage", "joint": joint | (shoulder or {}), "mass": 2, "com": [0.5, 0, 0.1],
         "inertia": [0.1, 0.2, 0.2]},
        {"name": "hand", "on": "upper arm", "joint": {"name": "elbow", "kind": "revolute", "axis": "y", "point": [1, 0, 0]},
         "mass": 1, "com": [1.4, 0.1, 0], "inertia": [0.1, 0.2, 0.15]} | (hand or {})], **more})


TREE = arm()
GEAR = {"name": "gear", "terms": {"shoulder": 1, "elbow": -2}}
MOTOR = {"name": "motor", "joint": "shoulder", "kind": "dc_motor", "resistance": 2, "inductance": 0.01, "torque_constant": 0.1,
         "input": 5}
BALL = {"kind": "sphere", "radius": 10, "position": [1.5, 0, 0], "role": "collision"}
ROD = {"name": "rod", "between": ["hand", "ground"], "kind": "rod", "points": [[1.5, 0, 0], [1.5, 0, 2]]}
# The column of the table, and what the tree has besides.
WITH = {
    "rod": ("loops", arm(loop=[ROD])),
    "coupling": ("loops", arm(coupling=[GEAR])),
    "passive joint": ("passive joints", arm({"passive": True})),
    "spring of a joint": ("springs", arm({"spring": {"stiffness": 10}})),
    "spring": ("springs", arm(spring=[{"name": "wire", "between": ["ground", "hand"], "stiffness": 10}])),
    "damping and friction": ("joint losses", arm({"damping": 2, "friction": 3})),
    "gear with losses": ("joint losses", arm({"gear_loss": 0.2})),
    "motion": ("prescribed motions", arm(motion=[{"of": "shoulder", "kind": "polynomial", "coefficients": [0, 1]}])),
    "motor": ("drives with states", arm(drive=[MOTOR])),
    "play": ("couplings with play", arm(coupling=[GEAR | {"play": 0.1}])),
    "contacts": ("contacts", arm({"limits": [-1, 1], "stop": "hard"}, {"shape": [BALL]}, contact={"friction": 0.5})),
}


def state(m, row, seed=1):
    """The arguments of a row. Loops are closed and stay closed: the accelerations are those without drive forces. The
    directions, and the drive forces of a function that takes them, are random."""
    random = np.random.default_rng(seed)
    q, _ = axode.assemble(m, m.neutral())
    A = axode.loop_jacobian(m, q)
    v, dq, dv, da, dtau, w, a, tau = random.normal(size=(8, m.nv))
    v -= np.linalg.lstsq(A, A @ v, rcond=1e-9)[0] if A.size else 0
    if "motion" not in m.to_dict():
        a = axode.forward_dynamics(m, q, v, 0 * tau)
    values = {"q": q, "v": v, "a": a, "tau": tau, "p": axode.momenta(m, q, v), "dq": dq, "dv": dv, "da": da, "dtau": dtau, "w": w}
    given = {name: values[name] for name in row.arrays}
    if "frame" in row.takes:
        given["frame"] = m.n_frames - 1
    return given | ({"base": 0} if "base" in row.takes else {})


def numbers(result):
    return [np.asarray(x) for x in result] if isinstance(result, tuple) else [np.asarray(result)]


def refusal(call):
    """(the results, None), or (None, the message) if the call is refused."""
    try:
        return numbers(call()), None
    except (ValueError, RuntimeError) as error:
        return None, str(error)


def assert_same_or_refused(name, found, expected):
    """The law for another way to call a function of the table: its results are those of axode, or it refuses in a
    sentence about the function that was called."""
    there, why = refusal(expected)
    here, refused = refusal(found)
    if here is None:
        assert f"{name} does not count" in refused, refused
    else:
        assert there is not None, f"{name} answers, and axode refuses: {why}"
        assert all(x.shape == y.shape and np.allclose(x, y, rtol=1e-9, atol=1e-9) for x, y in zip(here, there, strict=True)), name
