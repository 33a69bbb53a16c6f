"""The heavy top of Brüls and Cardona, and the spatial slider-crank of the IFToMM library."""

import axode
import numpy as np
from comparison import Comparison, Published, Scheme
from scipy.special import ellipj

MASS, DISTANCE, TRANSVERSE, AXIAL, GRAVITY = 15, 1, 0.234375, 0.46875, 9.81  # kg, m, kg m^2, m/s^2
TOP_RATES = np.array([0, 150, -4.61538])  # rad/s


def height_of_top(t):
    """Height u of the unit vector along the axis of the top, with u = 0 and u' = 0 at t = 0.

    Energy E and the vertical momentum L give u'^2 = 2 (E - W u) (1 - u^2) / A - ((L - S u) / A)^2 with the
    moment W of the weight, the spin S and the transverse inertia A about the support. The motion lies between
    the two lower roots of this cubic, of which the upper one is 0: u = u_1 + (u_2 - u_1) cd^2(w t).
    """
    A = TRANSVERSE + MASS * DISTANCE**2
    W, S = MASS * GRAVITY * DISTANCE, AXIAL * TOP_RATES[1]
    L, E = A * TOP_RATES[2], A * TOP_RATES[2]**2 / 2
    cubic = [2 * W / A, -2 * E / A - (S / A)**2, 2 * L * S / A**2 - 2 * W / A, 2 * E / A - (L / A)**2]
    u_1, u_2, u_3 = np.sort(np.roots(cubic).real)
    _, cn, dn, _ = ellipj(np.sqrt(W * (u_3 - u_1) / (2 * A)) * t, (u_2 - u_1) / (u_3 - u_1))
    return u_1 + (u_2 - u_1) * (cn / dn)**2


def heavy_top():
    """A fast Lagrange top: its height in closed form, and a published motion."""
    b = axode.Builder("heavy top", [0, 0, -GRAVITY])
    m = b.body("top", joint={"kind": "spherical", "point": [0, 0, 0]}, mass=MASS, com=[0, DISTANCE, 0],
               inertia=[TRANSVERSE, AXIAL, TRANSVERSE]).build()
    scheme = Scheme(rtol=1e-12)
    t = np.linspace(0.05, 1, 20)
    for chosen, bound in ((scheme, 1e-9), (Scheme("kahan_li6", step=0.001), 1e-9),
                          (Scheme("rattle_suzuki4", step=0.0005, coordinates="absolute_SO3xR3"), 1e-8)):
        q, _ = chosen.states(m, m.neutral(), TOP_RATES, t)
        height = axode.poses(m, q)[:, m.frame_index("top"), 2, 1]
        yield Comparison("height of the centre of mass at 20 times to 1 s, m", DISTANCE * height,
                         DISTANCE * height_of_top(t), bound, chosen, "Closed form in Jacobi's functions.")

    published = Published("spatial.json", "heavy_top")
    rows = published.array()
    q, v = scheme.states(m, m.neutral(), TOP_RATES, rows[:, 0])
    quaternions = q[:, [3, 0, 1, 2]]
    quaternions *= np.sign(np.sum(quaternions * rows[:, 1:5], axis=1))[:, None]
    yield Comparison("quaternions at 3 times to 2 s", quaternions, rows[:, 1:5], 1e-5, scheme,
                     published.source)
    yield Comparison("ω_x and ω_z at 3 times to 2 s, rad/s", v[:, ::2], rows[:, 5::2], 1e-4, scheme,
                     published.source)


def slider_crank(along, about_pin, across):
    """The mechanism for the principal inertias of its rod, and velocities for 6 rad/s of the crank.

    The rod hangs on the crank by a ball joint and on the slider by a universal joint, whose first axis is the
    guide and whose pin is perpendicular to guide and rod.
    """
    A, B, C = np.array([[0, 0.1, 0.12], [0, 0.1, 0.2], [0.2, 0, 0]])
    guide, rod = np.array([1, 0, 0]), (C - B) / np.linalg.norm(C - B)
    pin = np.cross(rod, guide) / np.linalg.norm(np.cross(rod, guide))
    axes = np.array([rod, pin, np.cross(rod, pin)])
    b = axode.Builder("spatial slider-crank")
    b.body("crank", joint={"kind": "revolute", "axis": "x", "point": A}, mass=0.12, com=(A + B) / 2,
           inertia=[1e-4, 1e-4, 1e-5])
    b.body("rod", on="crank", joint={"kind": "spherical", "point": B, "passive": True}, mass=0.5,
           com=(B + C) / 2, inertia=axes.T @ np.diag([along, about_pin, across]) @ axes)
    b.body("slider", joint={"kind": "prismatic", "axis": "x", "passive": True}, mass=2, com=C,
           inertia=[1e-4, 1e-4, 1e-4])
    b.loop("slider", "rod", "universal", axis=guide, second_axis=pin, point=C)
    m = b.build()
    crank = m.joint("crank_joint").v
    others = np.delete(np.arange(m.nv), crank)
    rows, v = axode.loop_jacobian(m, m.neutral()), np.zeros(m.nv)
    v[crank] = 6
    v[others] = np.linalg.lstsq(rows[:, others], -rows @ v, rcond=None)[0]
    return m, v


def spatial_slider_crank():
    """Solutions in the library follow two readings of the rod's inertia; axode reproduces both."""
    relative, absolute = Scheme(rtol=1e-10), Scheme("rk4", step=0.001, coordinates="absolute")
    along = "small inertia along the rod", [4e-4, 4e-3, 4e-3]
    across = "small inertia across the rod", [4e-3, 4e-3, 4e-4]
    for name, (reading, inertia), bound, scheme in (
            ("gonzalez", along, 1e-4, relative), ("gonzalez", along, 1e-4, absolute),
            ("masarati", along, 1e-3, relative), ("masoudi", across, 5e-5, relative)):
        published = Published("spatial.json", name)
        t, position = published.array().T
        m, v = slider_crank(*inertia)
        slider = scheme.states(m, m.neutral(), v, t)[0][:, m.joint("slider_joint").q.start]
        yield Comparison(f"x of the slider at {len(t)} times to {t[-1]:g} s, m; {reading}", 0.2 + slider,
                         position, bound, scheme, published.source)


CASES = {"heavy_top": heavy_top, "slider_crank": spatial_slider_crank}
