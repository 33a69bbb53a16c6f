"""Problems A01 to A05 of the Library of Computational Benchmark Problems (IFToMM)."""

import axode
import numpy as np
from comparison import FOLDER, Comparison, Published, Scheme
from scipy.special import ellipj


def pendulum():
    """A01: a point of 1 kg on a rod of 1 m falls from the level."""
    published = Published("iftomm.json", "A01")
    t, x, y = published.array().T
    hinge = {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}
    b = axode.Builder("pendulum", [0, -9.81, 0])
    m = b.body("rod", joint=hinge, mass=1, com=[-1, 0, 0], inertia=[0, 0, 0]).build()
    scheme = Scheme(rtol=1e-12)

    def position(times):
        q = scheme.states(m, [0], [0], times)[0][:, 0]
        return [-np.cos(q), -np.sin(q)]

    yield Comparison(f"x and y of the mass at {len(t)} times to {t[-1]:g} s, m", position(t), [x, y], 5e-6,
                     scheme, published.source)

    # The angle φ from the hanging position obeys sin(φ / 2) = k cd(ω t) with k = sin(90° / 2).
    t = np.linspace(0.5, 10, 20)
    _, cn, dn, _ = ellipj(np.sqrt(9.81) * t, 0.5)
    phi = -2 * np.arcsin(np.sqrt(0.5) * cn / dn)
    yield Comparison("x and y of the mass at 20 times to 10 s, m", position(t), [np.sin(phi), -np.cos(phi)],
                     1e-9, scheme, "Closed form in Jacobi's functions.")


def four_bars(n):
    """N four-bars side by side, upright, and velocities for 1 m/s of B0 along x."""
    b = axode.Builder("N-four-bar", [0, -9.81, 0])
    upright = {"mass": 1, "inertia": [1 / 12, 0, 1 / 12]}
    level = {"mass": 1, "inertia": [0, 1 / 12, 1 / 12]}

    def hinge(x, y):
        return {"kind": "revolute", "axis": "z", "point": [x, y, 0], "passive": True}

    b.body("bar 0", joint=hinge(0, 0), com=[0, 0.5, 0], **upright)
    for i in range(1, n + 1):
        before = f"coupler {i - 1}" if i > 1 else "bar 0"
        b.body(f"coupler {i}", on=before, joint=hinge(i - 1, 1), com=[i - 0.5, 1, 0], **level)
        b.body(f"bar {i}", joint=hinge(i, 0), com=[i, 0.5, 0], **upright)
        b.loop(f"coupler {i}", f"bar {i}", axis="z", point=[i, 1, 0])
    m = b.build()
    v = np.zeros(m.nv)
    for i in range(n + 1):
        v[m.joint(f"bar {i}_joint").v] = -1
    v[m.joint("coupler 1_joint").v] = 1
    return m, v


def n_four_bar():
    """A02: forty four-bars, which are singular where they are flat."""
    published = Published("iftomm.json", "A02")
    t, x, y = published.array().T
    m, v = four_bars(40)
    scheme = Scheme("rk4", step=0.01)
    angle = scheme.states(m, m.neutral(), v, t)[0][:, m.joint("bar 0_joint").q.start]
    yield Comparison(f"x and y of B0 at {len(t)} times to {t[-1]:g} s, m", [-np.sin(angle), np.cos(angle)],
                     [x, y], 1e-5, scheme, published.source)


def andrews():
    """A03: Andrews' squeezer, whose crank begins at -0.0620 rad here."""
    published = Published("iftomm.json", "A03")
    t, x = published.array().T
    m = axode.load(axode.robots / "andrews.toml")
    drawn = -0.0617138900142764496
    crank = m.joint("beta").q.start
    q = m.neutral()
    while abs(q[crank] - (-0.0620 - drawn)) > 1e-15:  # assembly moves the crank as well, each time by less
        q[crank] = -0.0620 - drawn
        q = axode.assemble(m, q, np.zeros(m.nv))[0]
    scheme = Scheme(rtol=1e-10)
    tau = 0.033 * (np.array(m.joint_names) == "beta")
    angle = drawn + scheme.states(m, q, np.zeros(m.nv), t, tau=tau)[0][:, crank]
    yield Comparison(f"x of F at {len(t)} times to {t[-1]:g} s, m", 0.007 * np.cos(angle), x, 5e-8, scheme,
                     published.source)


def bricard():
    """A04: Bricard's ring of rods without thickness."""
    published = Published("iftomm.json", "A04")
    t, *positions = published.array().T
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]], dtype=float)
    b = axode.Builder("Bricard", [0, -9.81, 0])
    for i, axis in enumerate("yzxyz"):
        start, end = corners[i:i + 2]
        b.body(f"rod {i + 1}", on=f"rod {i}" if i else "ground", mass=1, com=(start + end) / 2,
               joint={"kind": "revolute", "axis": axis, "point": start, "passive": True},
               inertia=(1 - (end - start)**2) / 12)
    b.loop("rod 5", "ground", axis="x", point=corners[5])
    m = b.frame("P3", on="rod 2", position=corners[2]).build()
    for scheme in (Scheme(rtol=1e-10), Scheme("rk4", step=0.002, coordinates="absolute")):
        q, _ = scheme.states(m, m.neutral(), np.zeros(m.nv), t)
        P3 = axode.poses(m, q)[:, m.frame_index("P3"), :3, 3]
        yield Comparison(f"x, y and z of P3 at {len(t)} times to {t[-1]:g} s, m", P3.T, positions, 2e-6,
                         scheme, published.source)


def governor():
    """A05: a flyball governor with springs in place of its rods."""
    published = Published("iftomm.json", "A05")
    t, s = published.array().T
    m = axode.load(FOLDER / "stiff_governor.toml")
    v = np.zeros(m.nv)
    v[m.joint("bearing").v] = 2 * np.pi
    for scheme in (Scheme(rtol=1e-7), Scheme("generalized_alpha", step=0.0005)):
        slide = scheme.states(m, m.neutral(), v, t)[0][:, m.joint("slide").q.start]
        yield Comparison(f"s of the sleeve at {len(t)} times to {t[-1]:g} s, m", 0.5 + slide, s, 5e-6, scheme,
                         published.source)


CASES = {"A01": pendulum, "A02": n_four_bar, "A03": andrews, "A04": bricard, "A05": governor}
