"""Initial states and prescribed motions of a mechanism: told, copied, followed and refused."""

import math
import pickle

import axode
import numpy as np
import pytest

LINK = {"mass": 1.2, "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.01]}


def pendulum():
    """A pendulum on a slider that is shaken."""
    builder = axode.Builder("shaken pendulum")
    builder.body("shaker", joint={"kind": "prismatic", "axis": "x", "name": "shake"}, mass=1, com=[0, 0, 0],
                 inertia=[0.1, 0.1, 0.1])
    builder.body("rod", on="shaker", joint={"kind": "revolute", "axis": "-y", "point": [0, 0, 0], "name": "pin"}, **LINK)
    return builder


def wave(t):
    return 0.1 * math.sin(3 * t), 0.3 * math.cos(3 * t), -0.9 * math.sin(3 * t), -2.7 * math.cos(3 * t)


def test_the_initial_state_is_that_of_the_drawing_and_every_copy_has_it():
    m = pendulum().motion("shake", "harmonic", amplitude=0.1, frequency=2).state(q={"pin": 0.2}, v={"shake": 1}).build()
    for copy in [m, axode.read_drawing(axode.drawing(m)), axode.Model.from_dict(m.to_dict()), pickle.loads(pickle.dumps(m))]:
        q, v = copy.initial_state()
        assert q.tolist() == [0, 0.2] and v.tolist() == [1, 0]
        assert copy.motion_names == ["motion of shake"]
    assert not any(np.any(x) for x in pendulum().build().initial_state())


def test_a_function_of_pythons_moves_a_joint():
    m = pendulum().build()
    motion = axode.simulate(m, [0, 0.2], [0.3, 0], 1, motions={"shake": wave}, rtol=1e-10)
    assert np.allclose(motion.q[:, 0], [wave(t)[0] for t in motion.t], rtol=0, atol=1e-11)
    same = pendulum().motion("shake", "harmonic", amplitude=0.1, frequency=1.5 / math.pi).build()
    other = axode.simulate(same, [0, 0.2], [0.3, 0], 1, rtol=1e-10)
    assert np.allclose(motion.q[-1], other.q[-1], rtol=0, atol=1e-8)


def test_the_force_of_a_motion_is_the_drive_force_of_its_joint():
    m = pendulum().build()
    q, v = np.array([0, 0.2]), np.array([0.3, -0.4])
    found = axode.forward_dynamics_at(m, 0.0, q, v, [0, 0.5], motions={"shake": wave})
    assert found.a[0] == pytest.approx(wave(0)[2], abs=1e-12)
    assert np.allclose(axode.inverse_dynamics(m, q, v, found.a), [found.motion_forces[0], 0.5], rtol=0, atol=1e-10)


def test_motions_that_use_up_the_mobility_need_no_dynamics():
    m = pendulum().build()
    found = axode.kinematic_motion(m, [0, 0.5, 1], motions={"shake": wave, "pin": lambda t: (t, 1, 0, 0)})
    assert found.complete and found.q[:, 1].tolist() == [0, 0.5, 1]
    assert np.allclose(found.jerk[:, 0], [wave(t)[3] for t in found.t])
    with pytest.raises(ValueError, match="the motions leave the mechanism 1 velocity"):
        axode.kinematic_motion(m, [0, 1], motions={"shake": wave})


def test_wrong_motions_are_refused_by_name():
    m = pendulum().build()
    with pytest.raises(ValueError, match=r'no joint and no rod "shak"; did you mean "shake"'):
        axode.simulate(m, [0, 0], [0, 0], 1, motions={"shak": wave})
    with pytest.raises(ValueError, match=r'motions\["shake"\]\(t\)'):
        axode.simulate(m, [0, 0], [0, 0], 1, motions={"shake": lambda t: 1.0})
    moved = pendulum().motion("shake", "polynomial", coefficients=[0]).build()
    with pytest.raises(ValueError, match="forward_dynamics does not count prescribed motions"):
        axode.forward_dynamics(moved, [0, 0], [0, 0], [0, 0])
    with pytest.raises(axode.ModelError, match="which is neither a joint nor a rod"):
        pendulum().motion("nothing", "polynomial", coefficients=[0]).build()
