"""Motion in absolute coordinates: bodies that move freely, with constraints in place of their joints."""

import axode
import numpy as np
import pytest

KINDS = ["absolute", "absolute_SO3xR3", "absolute_by_joint"]
ARM = axode.load(axode.robots / "arm7.toml")
HUMANOID = axode.load(axode.robots / "humanoid.urdf", base="free")
METHODS = {"dopri5": (None, 1e-6), "rk4": (1e-3, 1e-6), "euler": (1e-4, 2e-2), "generalized_alpha": (1e-3, 2e-3),
           "generalized_alpha_index3": (1e-3, 2e-3), "rattle": (1e-3, 2e-3), "rattle_suzuki4": (1e-3, 1e-6),
           "rattle_kahan_li6": (2e-3, 1e-6), "half_explicit": (1e-3, 1e-4)}


@pytest.mark.parametrize("coordinates", KINDS)
@pytest.mark.parametrize("method", METHODS)
def test_methods_agree_on_trees(method, coordinates):
    m, q = HUMANOID, HUMANOID.random(seed=2)
    step, tolerance = METHODS[method]
    v = 0.1 * np.random.default_rng(1).normal(size=m.nv)
    tau = 0.1 * np.cos(np.arange(m.nv))
    exact = axode.simulate(m, q, v, 0.1, tau=tau, rtol=1e-11)
    motion = axode.simulate(m, q, v, 0.1, tau=tau, method=method, step=step, coordinates=coordinates)
    assert np.abs(m.difference(exact.q[-1], motion.q[-1])).max() < tolerance
    assert motion.position_residuals.max() < 1e-9
    assert motion.complete and motion.t[-1] == 0.1 and motion.steps == len(motion.t) - 1
    np.testing.assert_allclose(axode.forward_dynamics(m, motion.q, motion.v, motion.tau), motion.a, atol=1e-6)


@pytest.mark.parametrize("coordinates", KINDS)
def test_drives_losses_loads_events_and_times(coordinates):
    loads = [axode.Load(frame="flange", representation="hybrid", wrench=[0, 0, 0.2, 1, 2, 3])]
    arguments = dict(tau=lambda t, q, v: np.sin(t + np.arange(7)) - 0.3 * v, loads=loads, joint_losses=True,
                     times=np.linspace(0, 0.3, 7), rtol=1e-9)
    relative = axode.simulate(ARM, np.full(7, 0.3), np.zeros(7), 0.3, **arguments)
    absolute = axode.simulate(ARM, np.full(7, 0.3), np.zeros(7), 0.3, coordinates=coordinates, **arguments)
    for a, b in zip((relative.q, relative.v, relative.tau), (absolute.q, absolute.v, absolute.tau)):
        np.testing.assert_allclose(b, a, atol=1e-5)

    def lower(t, q, v):
        return q[1] - 0.31

    lower.terminal = True
    ends = [axode.simulate(ARM, np.full(7, 0.3), np.zeros(7), 5, events=[lower], coordinates=kind).t[-1]
            for kind in ("relative", coordinates)]
    assert ends[0] < 5 and abs(ends[1] - ends[0]) < 1e-6


@pytest.mark.parametrize("arguments, words", [
    (dict(coordinates="cartesian"), "coordinates is 'cartesian'; expected one of 'relative', 'absolute', 'absolute_SO3xR3', "
     "'absolute_by_joint'"),
    (dict(method="rattle", step=1e-3), 'RATTLE needs coordinates = "absolute"; got "relative"'),
    (dict(method="half_explicit", step=1e-3), 'the half-explicit method needs coordinates = "absolute"; got "relative"'),
    (dict(method="rattle", coordinates="absolute"), "takes fixed steps"),
    (dict(method="midpoint", step=1e-3, coordinates="absolute"),
     'method "midpoint" needs coordinates = "relative"; got "absolute"; in absolute coordinates use rattle'),
    (dict(method="generalized_alpha_index3", step=1e-3), 'generalised-alpha of index 3 needs coordinates = "absolute"; got "relative"')])
def test_what_does_not_go_together(arguments, words):
    with pytest.raises(ValueError, match=words):
        axode.simulate(ARM, np.full(7, 0.3), np.zeros(7), 0.1, **arguments)


def test_what_rolls_has_nothing_symplectic():
    m = axode.load(axode.robots / "cart.toml")
    with pytest.raises(ValueError, match='loop "left contact" is of kind "rolling", '
                       'which method "midpoint" does not support; use rattle in'):
        axode.simulate(m, m.neutral(), np.zeros(m.nv), 0.1, method="midpoint", step=1e-3)
