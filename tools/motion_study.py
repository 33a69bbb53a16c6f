"""Measures properties of the integrators, each on one mechanism, and updates the tables and figures of a page.

    build/venv/bin/python tools/motion_study.py docs/integration.md
    build/venv/bin/python tools/motion_study.py docs/integration.md --only heavy_top cost

A table of the page stands between `<!-- name -->` and `<!-- end -->`, figures lie beside it as integration-name.svg. Times
are those of the processor, in which other programs do not count. `cost` needs MuJoCo.
"""

import argparse
import os
import statistics
import sys
import time
from pathlib import Path

import axode
import chart
import numpy as np
from page import Page, processor

METHODS = ["dopri5", "rk4", "euler", "generalized_alpha", "midpoint", "suzuki4", "kahan_li6", "rk4_momenta"]


class IntegrationPage(Page):
    """The page with figures beside it."""

    def figure(self, name, tables):
        """Draws a figure of {title: table}, with a curve for each method."""
        chart.draw(self.file.with_name(f"integration-{name}.svg"), tables, "--log", "xy")


def progress(*words):
    print(*words, "...", file=sys.stderr, flush=True)


def number(x, digits=1):
    """1.2e-5."""
    return f"{x:.{digits}e}".replace("e-0", "e-").replace("e+0", "e") if x else "0"


def slope(steps, errors):
    """The order of a method, from the errors at both ends of a window."""
    return np.log(errors[0] / errors[-1]) / np.log(steps[-1] / steps[0])


# ---- heavy top ---------------------------------------------------------------------------------------------
# Powers of two of the steps per second that are run, and those between which the order shows.
HEAVY_TOP = {"euler": ((9, 18), (16, 18)), "generalized_alpha": ((9, 18), (11, 18)), "midpoint": ((9, 18), (10, 18)),
             "rk4": ((9, 18), (11, 16)), "rk4_momenta": ((9, 18), (11, 16)), "suzuki4": ((9, 15), (9, 12)),
             "kahan_li6": ((7, 15), (7, 9))}
TOLERANCES = [10.0**-k for k in range(4, 13)]


def heavy_top_model():
    b = axode.Builder("heavy top")
    b.body("top", joint={"kind": "spherical", "point": [0, 0, 0]}, mass=15, com=[0, 1, 0],
           inertia=[0.234375, 0.46875, 0.234375])
    return b.build()


def heavy_top(page):
    m = heavy_top_model()

    def end(method, **options):
        motion = axode.simulate(m, m.neutral(), [0, 150, -4.61538], until=1, method=method, **options)
        return motion.steps, motion.evaluations, motion.q[-1]

    exact = end("rk4", step=2.0**-18)[2]
    runs = {}
    for method, (range_of_powers, _) in HEAVY_TOP.items():
        progress("heavy top:", method)
        powers = range(range_of_powers[0], range_of_powers[1] + 1)
        runs[method] = [end(method, step=2.0**-power) for power in powers if (method, power) != ("rk4", 18)]
    runs["dopri5"] = [end("dopri5", rtol=rtol, atol=rtol / 100) for rtol in TOLERANCES]

    rows, by_steps, by_evaluations = [], {}, {}
    for method, found in runs.items():
        steps, evaluations = np.array([run[:2] for run in found]).T
        errors = np.array([np.linalg.norm(m.difference(exact, run[2])) for run in found])
        by_steps[method], by_evaluations[method] = (steps, errors), (evaluations, errors)
        if method == "dopri5":
            first, last, window, shown = 2, 7, "rtol = 1e-6 to 1e-11", TOLERANCES.index(1e-6)
        else:
            (begin, _), powers = HEAVY_TOP[method]
            first, last = powers[0] - begin, powers[1] - begin
            window, shown = f"2^{powers[0]} to 2^{powers[1]}", 12 - begin
        order = slope(steps[first:last + 1], errors[first:last + 1])
        rows.append([f"`{method}`", window, f"{order:.2f}", steps[shown], number(errors[shown]),
                     f"{evaluations[shown] / steps[shown]:.1f}"])
    page.table("heavy top", ["method", "window, steps in 1 s", "order seen in it", "steps", "error, rad",
                             "evaluations a step"], rows)
    page.figure("heavy-top", {"by steps": chart.curves("steps in 1 s", "error of R at 1 s, rad", by_steps),
                              "by evaluations": chart.curves("evaluations", "error of R at 1 s, rad", by_evaluations)})


# ---- free top ----------------------------------------------------------------------------------------------
def top(gravity=(0, 0, -9.81), inertia=(1, 2, 3)):
    b = axode.Builder("top", gravity)
    b.body("top", joint="free", mass=1, com=[0, 0, 0], inertia=list(inertia))
    return b.build()


def free_top(page):
    m = top(gravity=(0, 0, 0))
    start = m.neutral(), [0.001, 1, 0.002, 0, 0, 0], 100
    progress("free top")
    exact = axode.simulate(m, *start, rtol=1e-13, atol=1e-15).q[-1]
    runs = [("dopri5", f"rtol = {number(rtol, 0)}", {"rtol": rtol, "atol": rtol / 100}) for rtol in (1e-6, 1e-8, 1e-10)]
    runs += [(method, f"{step} s", {"step": step}) for method in METHODS if method != "dopri5"
             for step in (0.1, 0.05, 0.025)]
    rows = []
    for method, choice, options in runs:
        motion = axode.simulate(m, *start, method=method, **options)
        energy, momentum = motion.energy, motion.momentum[:, :3]
        drift = np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0])
        error = np.linalg.norm(m.difference(exact, motion.q[-1]))
        rows.append([f"`{method}`", choice, motion.steps, motion.evaluations, number(error),
                     number(np.abs(energy / energy[0] - 1).max()), number(drift)])
    page.table("free top", ["method", "step", "steps", "evaluations", "attitude, rad", "energy", "angular momentum"], rows)


# ---- Cayley's map ------------------------------------------------------------------------------------------
def satellite():
    b = axode.Builder("satellite", gravity=(0, 0, 0))
    b.body("hub", joint="free", mass=5, com=[0.1, 0, 0], inertia=[1, 2, 2.5])
    for k, point in enumerate(np.eye(3)):
        b.body(f"arm {k + 1}", on="hub", joint={"kind": "spherical", "point": list(point)}, mass=1 + k / 2,
               com=list(1.5 * point), inertia=[0.2, 0.3, 0.25])
    return b.build()


def cayley(page):
    free = satellite()
    motions = [("heavy top, 150 rad/s", heavy_top_model(), [0, 150, -4.61538], 0.25, 1024),
               ("satellite, 2 rad/s", free, 2 * np.sin(3.0 * np.arange(free.nv) + 1), 1, 128)]
    rows = []
    for name, m, v, until, steps in motions:
        progress("Cayley:", name)
        exact = axode.simulate(m, m.neutral(), v, until, rtol=1e-13, atol=1e-14).q[-1]
        for method in ("rk4", "midpoint", "suzuki4", "generalized_alpha"):
            of_both = []
            for coordinates in ("exponential", "cayley"):
                found = [axode.simulate(m, m.neutral(), v, until, method=method, step=until / n, local_coordinates=coordinates)
                         for n in (steps, 2 * steps)]
                errors = [np.linalg.norm(m.difference(exact, motion.q[-1])) for motion in found]
                of_both.append((number(errors[0]), f"{np.log2(errors[0] / errors[1]):.2f}", found[0].evaluations))
            (of_exp, order_of_exp, calls), (of_cay, order_of_cay, calls_of_cay) = of_both
            rows.append([name, f"`{method}`", steps, of_exp, of_cay, order_of_exp, order_of_cay, calls, calls_of_cay])
    progress("Cayley: reconstruction")

    def twist(t):
        return np.array([np.sin(2 * t), 1 + t, np.cos(3 * t), t, 0.5, -t])
    exact = axode.reconstruct(np.eye(4), twist, np.linspace(0, 1, 4001))[-1]

    def end(method, n):
        found = axode.reconstruct(np.eye(4), twist, np.linspace(0, 1, n + 1), method=method)[-1]
        return np.linalg.norm(axode.lie.log(axode.lie.inverse(exact) @ found))
    errors = {method: (end(method, 32), end(method, 64)) for method in ("munthe_kaas", "cayley")}
    orders = [f"{np.log2(coarse / fine):.2f}" for coarse, fine in errors.values()]
    rows.append(["a pose from its twist", "`reconstruct`", 32, *(number(coarse) for coarse, _ in errors.values()), *orders, 128, 128])
    page.table("Cayley", ["motion", "method", "steps", "error with exp", "with cay", "order with exp", "with cay",
                          "evaluations with exp", "with cay"], rows)


# ---- chain -------------------------------------------------------------------------------------------------
STARTS, SHORT, LONG = 20, 20, 100
CHAIN = {"dopri5": LONG, "rk4": LONG, "rk4_momenta": LONG, "midpoint": LONG, "generalized_alpha": LONG, "suzuki4": SHORT,
         "kahan_li6": SHORT}  # until when, s


def links(n):
    """Rods of 1 m and 1 kg on parallel hinges; they hang at q = 0."""
    b = axode.Builder(f"chain of {n}")
    for i in range(n):
        hinge = {"kind": "revolute", "axis": "y", "point": [0, 0, -i]}
        b.body(f"rod {i}", on=f"rod {i - 1}" if i else "ground", joint=hinge, mass=1, com=[0, 0, -i - 0.5],
               inertia=[1 / 12, 1 / 12, 1e-3])
    return b.build()


def nearly_level(m, seed):
    q = np.random.default_rng(seed).uniform(-0.1, 0.1, m.nq)
    q[0] -= np.pi / 2
    return q


def chain(page):
    m, times = links(10), np.sort(np.append(np.geomspace(0.1, LONG, 40), SHORT))
    rows, medians_of = [], {}
    for method, until in CHAIN.items():
        errors, evaluations = [], []
        for seed in range(STARTS):
            progress(f"chain: {method}, start {seed + 1} of {STARTS}")
            q = nearly_level(m, seed)
            step = None if method == "dopri5" else 1e-3
            motion = axode.simulate(m, q, np.zeros(m.nv), until, method=method, step=step)
            height = axode.potential_energy(m, q) - axode.potential_energy(m, np.zeros(m.nq))
            energy, t = motion.energy, motion.t
            largest = np.maximum.accumulate(np.abs(energy - energy[0])) / height
            errors.append(largest[np.searchsorted(t, times[times <= until] + 1e-9) - 1])
            evaluations.append(motion.evaluations / until)
        shown = times[times <= until]
        medians_of[method] = shown, np.median(errors, axis=0)
        for end in (SHORT, LONG)[:1 + (until == LONG)]:
            quantiles = np.quantile([error[shown == end][0] for error in errors], [0.1, 0.5, 0.9, 1])
            rows.append([f"`{method}`", f"{end} s", f"{statistics.mean(evaluations) / 1000:.1f}", *map(number, quantiles)])
    rows.sort(key=lambda row: row[1], reverse=True)
    page.table("chain", ["method", "until", "evaluations per ms", "10 %", "50 %", "90 %", "100 %"], rows)
    page.figure("chain", {"medians of 20 starts": chart.curves("t, s", "energy error / height", medians_of)})


# ---- humanoid ----------------------------------------------------------------------------------------------
HUMANOID = ["rk4", "dopri5", "midpoint", "rk4_momenta"]


def parts(momenta):
    """Sizes of the angular and linear parts, (..., 2)."""
    return np.stack([np.linalg.norm(momenta[..., :3], axis=-1), np.linalg.norm(momenta[..., 3:], axis=-1)], -1)


def sum_of_bodies(m, q, v):
    return parts(axode.body_momenta(m, q, v, "spatial")).sum(axis=1)


def weightless_error(m, t, q, v):
    """The error of Pi^s about the inertial origin, relative to the sum of the momenta of the bodies."""
    Pi = axode.spatial_momentum(m, q, v)
    return (parts(Pi - Pi[0]) / sum_of_bodies(m, q, v)).max(axis=1)


def falling_error(m, t, q, v):
    """The errors of L_c and P - m g t, relative to the sums of the momenta of the bodies. L_c does not depend on the
    position and velocity of the centre. It is computed relative to a frame that falls with the centre, so that no
    digits are lost."""
    P = axode.spatial_momentum(m, q, v)[:, 3:]
    expected = P[0] + m.total_mass * t[:, None] * np.array(m.gravity)
    linear = np.linalg.norm(P - expected, axis=1) / sum_of_bodies(m, q, v)[:, 1]
    base, R = m.joint("free_base"), axode.poses(m, q)[:, m.frame_index("pelvis"), :3, :3]
    near, slow = q.copy(), v.copy()
    near[:, base.q][:, 4:] -= axode.center_of_mass(m, q)
    slow[:, base.v][:, 3:] -= np.einsum("nji,nj->ni", R, expected / m.total_mass)
    L = axode.centroidal_momentum(m, near, slow)[:, :3]
    return np.maximum(linear, np.linalg.norm(L - L[0], axis=1) / sum_of_bodies(m, near, slow)[:, 0])


def humanoid(page):
    rows, tables = [], {}
    for title, gravity, error_of in (("weightless", 0, weightless_error), ("in free fall", -9.81, falling_error)):
        m = axode.load(axode.robots / "humanoid.urdf", base="free", gravity=[0, 0, gravity])
        q, v = m.random(seed=3), 0.3 * np.random.default_rng(1).normal(size=m.nv)
        curves = {}
        for method in HUMANOID:
            progress(f"humanoid {title}: {method}")
            motion = axode.simulate(m, q, v, 100, method=method, step=None if method == "dopri5" else 1e-3)
            t = motion.t
            ends = np.searchsorted(t, np.geomspace(1e-3, 100, 61) - 1e-9)  # the ends of steps that are next
            ends = np.unique(np.r_[0, ends, np.searchsorted(t, [1 - 1e-9, 10 - 1e-9, 100 - 1e-9])])
            errors = error_of(m, t[ends], motion.q[ends], motion.v[ends])
            curves[method] = t[ends[1:]], np.maximum(errors[1:], 1e-17)
            energy = motion.energy
            drift = np.abs(energy - energy[0]).max() / axode.kinetic_energy(m, q, v)
            at = [errors[np.searchsorted(t[ends], until - 1e-9)] for until in (1, 10, 100)]
            rows.append([title, f"`{method}`", motion.steps, *map(number, at), number(drift)])
        tables[title] = chart.curves("t, s", "momentum error / sum over bodies", curves)
    page.table("humanoid", ["", "method", "steps in 100 s", "1 s", "10 s", "100 s", "energy, largest"], rows)
    page.figure("humanoid", tables)


# ---- loops -------------------------------------------------------------------------------------------------
# Velocities at the start, and steps, s.
LOOPS = {"n_four_bar": ([-1, 1, 0, -1, -1], (0.02, 0.01, 0.005)), "bricard": ([0] * 5, (0.02, 0.01, 0.005))}
# Published coordinates of Andrews' squeezer at the start and
# after 0.03 s: Hairer and Wanner; Test Set for IVP Solvers.
ANDREWS = {"beta": (-0.0617138900142764496, 15.81077119629904), "Theta": (0, -15.75637105984298),
           "gamma": (0.455279819163070380, 0.04082224013073101), "Phi": (0.222668390165885885, -0.5347301163226948),
           "delta": (0.487364979543842550, 0.5244099658805304), "Omega": (-0.222668390165885885, 0.5347301163226948),
           "epsilon": (1.23054744454982119, 1.048080741042263)}
MOTOR = 0.033  # N m


def ways_to_go(steps, tolerances=(1e-6, 1e-8, 1e-10)):
    """For each run: the method, the text about its steps, and the options of `simulate`."""
    return ([("rk4", f"{step:g} s", {"method": "rk4", "step": step}) for step in steps] +
            [("dopri5", f"rtol = {number(rtol, 0)}", {"rtol": rtol, "atol": rtol / 100}) for rtol in tolerances])


def loops(page):
    rows = []
    for name, (v, steps) in LOOPS.items():
        m = axode.load(axode.robots / f"{name}.toml")
        for method, choice, options in ways_to_go(steps):
            progress("loops:", m.name, method, choice)
            motion = axode.simulate(m, m.neutral(), v, 10, **options)
            rates = np.einsum("nij,nj->ni", axode.loop_jacobian(m, motion.q), motion.v)
            energy = axode.kinetic_energy(m, motion.q, motion.v)
            rows.append([m.name, f"`{method}`", choice, motion.steps, motion.evaluations,
                         number(np.abs(motion.energy - motion.energy[0]).max()), f"{energy.max():.3g}",
                         number(np.abs(axode.loop_residual(m, motion.q)).max(), 0), number(np.abs(rates).max(), 0)])
    page.table("loops", ["", "method", "step", "steps", "evaluations", "energy, J", "largest kinetic energy, J",
                         "open by, rad or m", "A v, rad/s or m/s"], rows)
    andrews(page)


def andrews(page):
    m = axode.load(axode.robots / "andrews.toml")
    start, end = np.array([ANDREWS[name] for name in m.joint_names]).T
    tau = MOTOR * (np.array(m.joint_names) == "beta")

    def run(**options):
        return axode.simulate(m, m.neutral(), np.zeros(m.nv), 0.03, tau=tau, **options)

    exact, rows = run(rtol=1e-13, atol=1e-15).q[-1], []
    for method, choice, options in ways_to_go((2e-5, 1e-5, 5e-6), (1e-6, 1e-8, 1e-10, 1e-12)):
        progress("loops: andrews", method, choice)
        motion = run(**options)
        missing = motion.energy - MOTOR * motion.q[:, m.joint("beta").q.start]
        rows.append([f"`{method}`", choice, motion.steps, motion.evaluations,
                     number(np.abs(motion.q[-1] - exact).max()), number(np.abs(start + motion.q[-1] - end).max()),
                     number(np.abs(missing - missing[0]).max())])
    page.table("andrews", ["method", "step", "steps", "evaluations", "angles, rad", "against the published ones, rad",
                           "energy less work, J"], rows)


# ---- absolute coordinates ----------------------------------------------------------------------------------
GROUPS = {"absolute": "SE(3)", "absolute_SO3xR3": "SO(3) × R³"}
HELD = {"generalized_alpha_index3": {"spectral_radius": 0.9}, "generalized_alpha": {"spectral_radius": 0.9},
        "rattle": {}, "rattle_suzuki4": {}, "half_explicit": {}, "rk4": {}}


def absolute(page):
    heavy_top_of_bodies(page)
    four_bar_of_bodies(page)
    mechanisms_of_bodies(page)


def heavy_top_of_bodies(page):
    m, rows = heavy_top_model(), []
    for name, v in (("fast", [0, 150, -4.61538]), ("slow", [0, 1.5, -0.0461538])):
        exact = axode.simulate(m, m.neutral(), v, 1, method="kahan_li6", step=2.0**-14)
        for coordinates, group in GROUPS.items():
            for method, options in HELD.items():
                progress("absolute: heavy top", name, method, group)
                runs = [axode.simulate(m, m.neutral(), v, 1, method=method, step=2.0**-power, coordinates=coordinates,
                                       **options) for power in (10, 11)]
                errors = np.array([[np.linalg.norm(m.difference(exact.q[-1], run.q[-1])),
                                    np.abs(exact.v[-1] - run.v[-1]).max()] for run in runs])
                orders = np.log2(errors[0] / errors[1])
                rows.append([name, group, f"`{method}`", number(errors[1, 0]), number(errors[1, 1]),
                             f"{orders[0]:.2f}, {orders[1]:.2f}", number(runs[1].position_residuals.max(), 0),
                             number(runs[1].velocity_residuals.max(), 0)])
    page.table("heavy top of bodies", ["top", "group", "method", "R, rad", "ω, rad/s", "orders", "Φ, m", "B v, m/s"],
               rows)


def four_bar_of_bodies(page):
    m, rows = axode.load(axode.robots / "n_four_bar.toml"), []
    q, v = axode.assemble(m, m.neutral(), [-1, 1, 0, -1, -1])
    for method in HELD:
        options = {"spectral_radius": 0.95} if "alpha" in method else {}
        cells = []
        for step in (1e-2, 1e-3, 5e-4):
            progress("absolute: N-four-bar", method, step)
            begin = time.process_time()
            motion = axode.simulate(m, q, v, 10, method=method, step=step, coordinates="absolute_SO3xR3", **options)
            cost = (time.process_time() - begin) / motion.steps * 1e6
            cells.append(number(np.abs(motion.body_energy - motion.body_energy[0]).max(), 2))
        rows.append([f"`{method}`", *cells, f"{cost:.0f}"])
    page.table("four-bar of bodies", ["method", "10 ms", "1 ms", "0.5 ms", "µs a step"], rows)


def mechanisms_of_bodies(page):
    rows = []
    for name, speed, until, step in (("bricard", None, 10, 5e-3), ("governor", {0: 2 * np.pi}, 2, 1e-3),
                                     ("gough", {0: 0.3, 1: -0.2, 2: 0.5, 3: 0.1, 4: 0.2, 5: 0.4}, 1, 2e-3)):
        m = axode.load(axode.robots / f"{name}.toml")
        v = np.zeros(m.nv)
        for c, speed_c in (speed or {}).items():
            v[c] = speed_c
        q, v = axode.assemble(m, m.neutral(), v)
        exact = axode.simulate(m, q, v, until, rtol=1e-12, atol=1e-13)
        choices = [("rk4", "relative"), *((method, kind) for kind in GROUPS for method in HELD)]
        for method, coordinates in choices:
            progress("absolute:", name, method, coordinates)
            options = HELD[method] if coordinates != "relative" else {}
            try:
                motion = axode.simulate(m, q, v, until, method=method, step=step, coordinates=coordinates, **options)
            except axode.SimulationError as stopped:
                rows.append([name, GROUPS.get(coordinates, "joints"), f"`{method}`", f"{step} s",
                             f"stopped at {stopped.trajectory.t[-1]:.2f} s", "", ""])
                continue
            rows.append([name, GROUPS.get(coordinates, "joints"), f"`{method}`", f"{step} s",
                         number(np.abs(m.difference(exact.q[-1], motion.q[-1])).max()),
                         number(np.abs(motion.energy - motion.energy[0]).max()),
                         number(np.abs(axode.loop_residual(m, motion.q)).max(), 0)])
    page.table("mechanisms of bodies", ["", "coordinates", "method", "step", "q, rad or m", "energy, J",
                                        "open by, rad or m"], rows)


# ---- what rolls --------------------------------------------------------------------------------------------
def coin():
    b = axode.Builder("coin")
    b.body("coin", joint="free", mass=2, com=[0, 0, 0.3], inertia=[0.045, 0.09, 0.045])
    b.loop("ground", "coin", "rolling", axis="z", point=[0, 0, 0], center=[0, 0, 0.3], wheel_axis="y")
    return b.build()


def rolling(page):
    rows = []
    for m, v, step in ((coin(), [0.4, 6, 0.7, 0, 0, 0], 1e-2),
                       (axode.load(axode.robots / "cart.toml"), [0, 0, 1, 0.3, 0, 0, 0, 0, 0, 0, 0], 2e-3)):
        q, v = axode.assemble(m, m.neutral(), v)
        exact = axode.simulate(m, q, v, 1, rtol=1e-13, atol=1e-14).q[-1]
        for coordinates, group in GROUPS.items():
            for method, options in HELD.items():
                progress("rolling:", m.name, method, group)
                coarse, fine, far = (axode.simulate(m, q, v, until, method=method, step=h, coordinates=coordinates,
                                                    **options) for until, h in ((1, step), (1, step / 2), (40, step)))
                errors = [np.abs(m.difference(exact, motion.q[-1])).max() for motion in (coarse, fine)]
                lost = np.abs(far.body_energy - far.body_energy[0])
                rows.append([m.name, group, f"`{method}`", f"{step:g} s", number(errors[0]),
                             f"{np.log2(errors[0] / errors[1]):.2f}", number(lost[far.t <= 10].max()),
                             number(lost.max()), number(far.position_residuals.max(), 0),
                             number(far.velocity_residuals.max(), 0)])
    page.table("rolling", ["", "group", "method", "step", "q, rad or m", "order", "energy in 10 s, J", "in 40 s, J",
                           "open by, rad or m", "B v, rad/s or m/s"], rows)


# ---- cost --------------------------------------------------------------------------------------------------
COST = ["rk4", "rk4_momenta", "generalized_alpha", "midpoint", "suzuki4", "kahan_li6"]
STEPS = 300


def medians(calls, repetitions=9):
    """The median processor time of each function, s; the functions take turns."""
    seconds = [[] for _ in calls]
    for repetition in range(repetitions + 1):
        for call, times in zip(calls, seconds, strict=True):
            begin = time.process_time()
            call()
            if repetition > 0:  # the first one finds cold caches
                times.append(time.process_time() - begin)
    return [statistics.median(times) for times in seconds]


def machine():
    return f"{processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


def peer(m, step):
    """The same mechanism in MuJoCo: no contacts, no limits, no losses."""
    import mujoco

    options = '<mujoco><compiler fusestatic="true" balanceinertia="false"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(axode.urdf(m).replace("</robot>", options))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, step
    model.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_damping[:] = model.dof_frictionloss[:] = 0
    return model


def peer_end(m, model, q, v, steps):
    import mujoco
    from mujoco import rollout

    begin = np.hstack([0, *axode.convert.to_mujoco(m, q, v)])
    states, _ = rollout.rollout(model, mujoco.MjData(model), initial_state=begin, nstep=steps)
    return axode.convert.from_mujoco(m, states[0, -1, 1:1 + model.nq], states[0, -1, 1 + model.nq:])[0]


def cost(page):
    progress("cost on", machine())
    falling = axode.load(axode.robots / "humanoid.urdf", base="free")
    starts = {"humanoid": (falling, falling.random(seed=3), 0.3 * np.random.default_rng(1).normal(size=falling.nv))}
    for m in (links(36), links(10)):  # while they whip about
        motion = axode.simulate(m, nearly_level(m, 0), np.zeros(m.nv), 5)
        starts = {m.name: (m, motion.q[-1], motion.v[-1])} | starts
    columns = []
    for name, (m, q, v) in starts.items():
        progress("cost:", name)

        def run(method, m=m, q=q, v=v):
            return axode.simulate(m, q, v, STEPS * 1e-3, method=method, step=1e-3)

        seconds = medians([lambda method=method: run(method) for method in COST])
        columns.append([f"{time / STEPS / m.nv * 1e6:.2f} ({run(method).evaluations / STEPS:.1f})"
                        for method, time in zip(COST, seconds, strict=True)])
    page.table("cost", ["method", *(f"{name}, {m.nv} dof" for name, (m, _, _) in starts.items())],
               [[f"`{method}`", *cells] for method, *cells in zip(COST, *columns, strict=True)])
    beside_mujoco(page, falling)
    falling_top_beside_mujoco(page)


def beside_mujoco(page, falling):
    import mujoco
    from mujoco import rollout

    rows = []
    for m in (axode.load(axode.robots / "arm7.toml"), falling):
        model = peer(m, 1e-3)
        data = mujoco.MjData(model)
        q, v = m.random(seed=1), np.random.default_rng(1).uniform(-1, 1, m.nv)
        ours_end = axode.rollout(m, q, v, np.zeros((100, m.nv)), 1e-3)[0][-1]
        if not np.abs(m.difference(ours_end, peer_end(m, model, q, v, 100))).max() < 1e-7:
            raise SystemExit(f"{m.name} does not move in MuJoCo as it does here")
        progress(f"cost: {m.name} beside MuJoCo")
        tau, begin = np.zeros((1000, m.nv)), np.hstack([0, *axode.convert.to_mujoco(m, q, v)])
        ours, theirs = medians([lambda: axode.rollout(m, q, v, tau, 1e-3),
                                lambda: rollout.rollout(model, data, initial_state=begin, nstep=1000)])
        rows.append([f"{m.name}, {m.nv} dof", "1", f"{ours * 1e3:.1f}", f"{theirs * 1e3:.1f}", f"{ours / theirs:.2f}"])

        count, steps = 64, 200
        q, v = m.random(n=count, seed=2), np.random.default_rng(2).uniform(-1, 1, (count, m.nv))
        taus = np.zeros((count, steps, m.nv))
        begins = np.array([np.hstack([0, *axode.convert.to_mujoco(m, *state)]) for state in zip(q, v, strict=True)])
        ours, theirs = (time / (count * steps) * 1e6 for time in medians(
            [lambda: axode.rollout(m, q, v, taus, 1e-3),
             lambda: rollout.rollout(model, data, initial_state=begins, nstep=steps)]))
        rows.append([f"{m.name}, {m.nv} dof", f"{count}", f"{ours:.1f}", f"{theirs:.1f}", f"{ours / theirs:.2f}"])
    page.table("mujoco", ["", "motions", "axode, µs a step", "MuJoCo, µs a step", "ratio"], rows)


def falling_top_beside_mujoco(page):
    m, v, until = top(inertia=(1, 2, 2.5)), np.array([0.3, 1, 0.5, 0, 0, 0]), 10
    exact = axode.simulate(m, m.neutral(), v, until, method="kahan_li6", step=1e-2).q[-1]
    rows = []
    for step in (0.1, 0.05, 0.025):
        ends = [axode.simulate(m, m.neutral(), v, until, method=method, step=step).q[-1]
                for method in ("rk4", "rk4_momenta")]
        ends.append(peer_end(m, peer(m, step), m.neutral(), v, round(until / step)))
        rows.append([f"{step} s", *(f"{number(angular)}, {number(linear)}"
                                    for angular, linear in (parts(m.difference(exact, end)) for end in ends))])
    page.table("falling top", ["step", "`rk4`: rad, m", "`rk4_momenta`: rad, m", "MuJoCo's RK4: rad, m"], rows)


SECTIONS = {section.__name__: section for section in (heavy_top, free_top, cayley, chain, humanoid, loops, absolute, rolling, cost)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, help="the page, docs/integration.md")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=list(SECTIONS), help="sections to measure again")
    arguments = parser.parse_args()
    page = IntegrationPage(arguments.page)
    try:
        for name in arguments.only:
            SECTIONS[name](page)
    except KeyboardInterrupt:
        raise SystemExit(f"stopped; {arguments.page} has what was finished") from None


if __name__ == "__main__":
    main()
