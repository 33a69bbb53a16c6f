"""Multibody problems of the Test Set for IVP Solvers."""

import axode
import numpy as np
from comparison import Comparison, Published, Scheme


def andrews():
    """Andrews' squeezer for 0.03 s."""
    published = Published("ivp.json", "andrews")
    end = dict(published.rows)
    start = {"beta": -0.0617138900142764496, "Theta": 0, "gamma": 0.455279819163070380,
             "Phi": 0.222668390165885885, "delta": 0.487364979543842550,
             "Omega": -0.222668390165885885, "epsilon": 1.23054744454982119}
    m = axode.load(axode.robots / "andrews.toml")
    scheme = Scheme(rtol=1e-11)
    tau = 0.033 * (np.array(m.joint_names) == "beta")
    q = scheme.states(m, m.neutral(), np.zeros(m.nv), [0.03], tau=tau)[0][-1]
    angles = [start[name] + q[m.joint(name).q.start] for name in end]
    yield Comparison("seven angles at 0.03 s, rad", angles, list(end.values()), 1e-6, scheme,
                     published.source)


def car_axis():
    """The car axis for 3 s, whose wheels follow the road: a drive gives the axle its acceleration."""
    published = Published("ivp.json", "caraxis")
    l, l_0, k, M, r, omega = 1, 0.5, 1e4, 10, 0.1, 10
    end = {"mass": M / 2, "inertia": [0, 0, 0]}
    b = axode.Builder("car axis", [0, -1, 0])
    b.body("axle", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, mass=1, com=[0, 0, 0],
           inertia=[1, 1, 1])
    b.body("left", on="axle", joint={"kind": "prismatic", "axis": "y", "spring": {"stiffness": k}},
           com=[0, l_0, 0], **end)
    b.body("chassis", on="left", joint={"kind": "revolute", "axis": "z", "point": [0, l_0, 0]},
           com=[l, l_0, 0], **end)
    b.spring("axle", "chassis", points=[[l, 0, 0], [l, l_0, 0]], stiffness=k, rest=l_0)
    b.frame("l", on="left", position=[0, l_0, 0]).frame("r", on="chassis", position=[l, l_0, 0])
    m = b.build()

    def road(t):
        """Second derivative of the angle of the axle, for l sin(angle) = r sin(omega t)."""
        sine = r / l * np.sin(omega * t)
        cosine = np.sqrt(1 - sine**2)
        rate = r / l * omega * np.cos(omega * t) / cosine
        return (rate**2 - omega**2) * sine / cosine

    def drive(t, q, v):
        springs, unit = axode.spring_forces(m, q, v), np.array([1, 0, 0])
        free, pushed = (axode.forward_dynamics(m, q, v, tau)[0] for tau in (springs, springs + unit))
        return (road(t) - free) / (pushed - free) * unit

    scheme = Scheme(rtol=1e-11)
    q, v = scheme.states(m, np.zeros(3), [r * omega / l, 0, -r * omega / l], [3], tau=drive)
    frames = [m.frame_index("l"), m.frame_index("r")]
    positions = axode.poses(m, q[0])[frames, :2, 3]
    velocities = axode.twists(m, q[0], v[0], "hybrid")[frames, 3:5]
    yield Comparison("four positions (m) and four velocities (m/s) at 3 s", np.append(positions, velocities),
                     published.column("value at 3 s"), 2e-9, scheme, published.source)


CASES = {"andrews": andrews, "caraxis": car_axis}
