"""Random states of robots, and the comparison of what two libraries say of them."""

import numpy as np
from axode_command import FREE_BASE, REPRESENTATIONS


def assert_equal(quantity, ours, theirs, bound=1e-10):
    """Both map names to numbers: the same names, and the same numbers to a part of the largest one."""
    assert ours.keys() == theirs.keys(), quantity
    scale = max(np.max(np.abs(x), initial=0) for x in theirs.values())
    worst = max(ours, key=lambda name: np.max(np.abs(ours[name] - theirs[name]), initial=0))
    error = np.max(np.abs(ours[worst] - theirs[worst]))
    assert error <= bound * scale, f"{quantity} of {worst} differs by {error} in {scale}"


def assert_close(quantity, ours, theirs, scale=0.0, bound=1e-9):
    """Two arrays are the same to a part of the largest entry, or of a scale."""
    ours, theirs = np.array(ours), np.array(theirs)
    assert ours.shape == theirs.shape, quantity
    size = max(np.max(np.abs(theirs), initial=0), scale)
    error = np.max(np.abs(ours - theirs), initial=0)
    assert error <= bound * size, f"{quantity} differs by {error} in {size}"


def random_state(robot, random):
    """Numbers by joint, and a few loads on links."""
    values = {key: {name: random.uniform(-1, 1, 6 if name == FREE_BASE else 1).tolist()
                    for name in robot.independent_joints()} for key in ("q", "v", "a", "tau")}
    for name in robot.independent_joints():
        if name == FREE_BASE:
            quaternion = random.normal(size=4)
            position = random.uniform(-1, 1, 3)
            values["q"][name] = [*(quaternion / np.linalg.norm(quaternion)).tolist(), *position.tolist()]
        else:
            values["q"][name] = [np.pi * values["q"][name][0]]
    loads = [(str(random.choice(list(robot.links))), str(random.choice(REPRESENTATIONS)),
              random.uniform(-20, 20, 6).tolist()) for _ in range(4)]
    return values, loads


def arrays(by_name, names=None):
    return {name: np.array(by_name[name]) for name in names or by_name}


def as_json(values, loads):
    """The state for `axode eval`."""
    keys = ("frame", "representation", "wrench")
    return {**values, "loads": [dict(zip(keys, load)) for load in loads]}
