"""The mechanisms with loops that come with the package: closed as drawn, and moving as published."""

import tomllib
import warnings
from typing import NamedTuple

import axode
import numpy as np
import pytest


class Expected(NamedTuple):
    """Expected numbers of a mechanism: `size` is a length in m, `v` are initial velocities, which are changed such
    that the loops stay closed, and energies are in J."""

    rows: int
    rank: int
    degrees_of_freedom: int
    size: float
    v: list[float]
    until: float
    step: float
    rk4: float
    dopri5: float


EXPECTED = {
    "slider_crank": Expected(5, 2, 1, 0.3, [20, 0, 0], 0.5, 1e-3, 5e-9, 1e-8),
    "four_bar": Expected(5, 2, 1, 0.25, [10, 0, 0], 0.5, 1e-3, 1e-6, 3e-8),
    "n_four_bar": Expected(10, 4, 1, 1, [-1, 1, 0, -1, -1], 0.5, 2e-3, 5e-10, 1e-7),
    "bricard": Expected(5, 4, 1, 1, [0] * 5, 0.5, 2e-3, 5e-11, 2e-7),
    "andrews": Expected(15, 6, 1, 0.03, [100, 0, 0, 0, 0, 0, 0], 0.05, 5e-5, 1e-7, 1e-8),
    "governor": Expected(2, 2, 2, 1, [2 * np.pi, 0, 0, 0], 0.5, 2e-3, 2e-8, 2e-7),
    "gough": Expected(18, 18, 6, 1, [0.3, -0.2, 0.5, 0.1, 0.2, 0.4] + [0] * 18, 0.3, 2e-3, 2e-8, 2e-7),
    "five_bar_arm": Expected(5, 2, 2, 0.4, [3, 0, 1, 0], 0.5, 2e-3, 5e-11, 5e-10),
    "leg": Expected(1, 1, 10, 0.4, [0.1, 0.3, 0.2, 0.4, 0, 0.3, 0.5, -1, 2, 0, 1], 0.5, 2e-3, 2e-10, 1e-7),
    "cart": Expected(9, 8, 3, 0.2, [0, 0, 1, 0.3, 0, 0, 0, 0, 0, 0, 0], 0.5, 2e-3, 5e-13, 2e-12)}
MODELS = {name: axode.load(axode.robots / f"{name}.toml") for name in EXPECTED}
each = pytest.mark.parametrize("name", EXPECTED)

# Of Andrews' squeezer at the start and after 0.03 s: Test Set for IVP Solvers.
ANGLES = {"beta": (-0.0617138900142764496, 15.81077119629904), "Theta": (0, -15.75637105984298),
          "gamma": (0.455279819163070380, 0.04082224013073101), "Phi": (0.222668390165885885, -0.5347301163226948),
          "delta": (0.487364979543842550, 0.5244099658805304), "Omega": (-0.222668390165885885, 0.5347301163226948),
          "epsilon": (1.23054744454982119, 1.048080741042263)}
MOTOR = 0.033


def energy(m, q, v):
    return axode.kinetic_energy(m, q, v) + axode.potential_energy(m, q) + axode.elastic_energy(m, q)


def largest_error(m, motion, taken=0.0):
    E = energy(m, motion.q, motion.v) - taken
    return np.abs(E - E[0]).max()


def stay_closed(m, motion, size):
    A_v = np.einsum("nij,nj->ni", axode.loop_jacobian(m, motion.q), motion.v)
    return np.abs(axode.loop_residual(m, motion.q)).max() < 1e-10 * size and np.abs(A_v).max() < 1e-10 * size


@each
def test_they_are_read_without_a_warning(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        axode.load(axode.robots / f"{name}.toml")
    assert axode.check(axode.robots / f"{name}.toml", strict=True) == []


@each
def test_they_are_drawn_closed_and_move_as_expected(name):
    m, expected = MODELS[name], EXPECTED[name]
    assert np.abs(axode.loop_residual(m, m.neutral())).max() < 1e-12 * expected.size
    A = axode.loop_jacobian(m, m.neutral())
    found = axode.loop_mobility(m, m.neutral())
    assert A.shape == (expected.rows, m.nv)
    assert (found.rank, found.degrees_of_freedom) == (expected.rank, expected.degrees_of_freedom)
    assert np.linalg.matrix_rank(A, 1e-9) == expected.rank
    assert len(found.redundant) == expected.rows - expected.rank
    assert found.mobility == "regular"


@each
@pytest.mark.parametrize("method", ["rk4", "dopri5"])
def test_they_keep_their_energy_and_stay_closed(name, method):
    m, expected = MODELS[name], EXPECTED[name]
    q, v = axode.assemble(m, m.neutral(), expected.v)
    motion = axode.simulate(m, q, v, expected.until, method=method, step=expected.step if method == "rk4" else None)
    assert np.abs(m.difference(q, motion.q[-1])).max() > 0.1
    assert largest_error(m, motion) < (expected.rk4 if method == "rk4" else expected.dopri5)
    assert stay_closed(m, motion, expected.size)


def test_what_is_redundant_is_named():
    def found(name):
        m = MODELS[name]
        return [row.wrench for row in axode.loop_mobility(m, m.neutral()).redundant]

    assert found("four_bar") == ["couple about (1, 0, 0)", "couple about (0, 1, 0)",
                                 "force along (0, 0, 1) through (0.05, 0.2, 0)"]
    assert found("bricard") == ["force along (0.5774, 0.5774, 0.5774) through (0.3333, -0.6667, 0.3333)"]
    assert found("cart") == ["force along (0, 1, 0) through (0, 0, 0)"]


def test_the_lambda_linkage_leads_its_tip_nearly_along_a_line():
    m, q, tips = MODELS["four_bar"], np.zeros(3), []
    for crank in np.linspace(0, 1.5, 16):
        q, _ = axode.assemble(m, [crank, *q[1:]], hold=["crank_joint"])
        tips.append(axode.poses(m, q)[m.frame_index("tip"), :2, 3])
    tips = np.array(tips)
    assert np.abs(tips[:, 1] - 0.4).max() < 0.001 and np.ptp(tips[:, 0]) > 0.18


def test_andrews_squeezer_is_where_it_is_published():
    m = MODELS["andrews"]
    start, end = np.array([ANGLES[name] for name in m.joint_names]).T
    tau = MOTOR * (np.array(m.joint_names) == "beta")
    motion = axode.simulate(m, m.neutral(), np.zeros(7), 0.03, tau=tau, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(start + motion.q[-1], end, atol=3e-9)
    assert motion.v[-1][0] == pytest.approx(1139.920302151208, rel=1e-7)
    assert largest_error(m, motion, taken=MOTOR * motion.q[:, 0]) < 2e-10
    assert stay_closed(m, motion, 0.03)


def test_the_slider_crank_obeys_its_closed_form():
    m, l_1, l_2 = MODELS["slider_crank"], 0.15, 0.3
    motion = axode.simulate(m, *axode.assemble(m, m.neutral(), [20, 0, 0]), 0.5, rtol=1e-10)
    crank = np.pi / 2 + motion.q[:, 0]
    x = l_1 * np.cos(crank) + np.sqrt(l_2**2 - (l_1 * np.sin(crank))**2)
    np.testing.assert_allclose(motion.q[:, 2], x - np.sqrt(l_2**2 - l_1**2), atol=1e-12)


def test_the_n_four_bar_passes_where_it_is_flat():
    m = MODELS["n_four_bar"]
    errors = []
    for step in (0.02, 0.01):
        motion = axode.simulate(m, m.neutral(), EXPECTED["n_four_bar"].v, 10, method="rk4", step=step)
        errors.append(largest_error(m, motion))
        assert stay_closed(m, motion, 1)
        assert motion.q[-1, 0] == pytest.approx(-31.75060, abs=2e-5)
        np.testing.assert_allclose(motion.q[:, [3, 4]], motion.q[:, [0, 0]], atol=1e-10)
    assert errors[0] < 5e-5 and errors[1] < 2e-6
    flat = axode.loop_mobility(m, [-np.pi / 2, np.pi / 2, 0, -np.pi / 2, -np.pi / 2])
    assert (flat.degrees_of_freedom, flat.mobility) == (3, "branches")


def test_the_sleeve_moves_as_if_stiff_springs_held_it():
    m = MODELS["governor"]
    drawn = tomllib.loads((axode.robots / "governor.toml").read_text())
    stiff_spring = {"rest": 0.5, "stiffness": 8e5, "damping": 4e4}
    drawn["spring"] = [{"between": rod["between"], "points": rod["points"]} | stiff_spring
                       for rod in drawn.pop("loop")]
    stiff = axode.Model.from_dict(drawn)
    v, times = [2 * np.pi, 0, 0, 0], np.linspace(0, 1, 101)
    by_rods = axode.simulate(m, m.neutral(), v, 1, times=times)
    by_springs = axode.simulate(stiff, m.neutral(), v, 1, method="generalized_alpha", step=1e-3, times=times)
    sleeve = m.joint("slide").q
    assert np.ptp(by_rods.q[:, sleeve]) > 0.2
    np.testing.assert_allclose(by_rods.q[:, sleeve], by_springs.q[:, sleeve], atol=2e-4)


def test_the_cart_turns_about_its_axle():
    m = MODELS["cart"]
    speed, turn, radius, track = 0.3, 1.0, 0.033, 0.16
    q, v = axode.assemble(m, m.neutral(), EXPECTED["cart"].v)
    kernel = axode.loop_mobility(m, q).kernel
    v = kernel @ np.linalg.lstsq(kernel[[2, 3]], [turn, speed], rcond=None)[0]
    np.testing.assert_allclose(v[m.joint("left wheel_joint").v], (speed - turn * track / 2) / radius, rtol=1e-12)
    np.testing.assert_allclose(v[m.joint("right wheel_joint").v], (speed + turn * track / 2) / radius, rtol=1e-12)
    np.testing.assert_allclose(v[[0, 1, 4, 5]], 0, atol=1e-14)
