"""Motions in closed form: a free body, orbits, and a planetary gear by hand."""

import axode
import numpy as np
from comparison import Comparison, Scheme
from scipy.special import ellipj, ellipkinc


def free_body_rates(I, rates, t):
    """Angular rates of a free body with inertias I_1 < I_2 < I_3 whose |L|² exceeds 2 E I_2, shape (N, 3)."""
    I1, I2, I3 = I
    two_E, L2 = I @ rates**2, I**2 @ rates**2
    sizes = np.sqrt([(two_E * I3 - L2) / (I1 * (I3 - I1)), (two_E * I3 - L2) / (I2 * (I3 - I2)),
                     (L2 - two_E * I1) / (I3 * (I3 - I1))])
    k2 = (I2 - I1) * (two_E * I3 - L2) / ((I3 - I2) * (L2 - two_E * I1))
    start = ellipkinc(np.arctan2(rates[1] / sizes[1], rates[0] / sizes[0]), k2)
    sn, cn, dn, _ = ellipj(start + t * np.sqrt((I3 - I2) * (L2 - two_E * I1) / (I1 * I2 * I3)), k2)
    return sizes * np.array([cn, sn, dn]).T


def tumbling_brick():
    """The brick of the check cases of flight, without weight."""
    I, rates = np.array([0.001894220, 0.006211019, 0.007194665]), np.radians([10, 20, 30])
    b = axode.Builder("brick", [0, 0, 0])
    m = b.body("brick", joint="free", mass=1, com=[0, 0, 0], inertia=I).build()
    t = np.arange(1, 31)
    for scheme in (Scheme(rtol=1e-12), Scheme("kahan_li6", step=0.05)):
        v = scheme.states(m, m.neutral(), np.append(rates, np.zeros(3)), t)[1]
        yield Comparison("three angular rates at 30 times to 30 s, rad/s", v[:, :3],
                         free_body_rates(I, rates, t), 1e-10, scheme,
                         "L. D. Landau and E. M. Lifshitz, Mechanics, section 37: Jacobi's functions.")


def orbits():
    """Ellipses about a centre, by a load that falls with the square of the distance, and by a spring."""
    e, t, scheme = 0.6, np.arange(1, 21), Scheme(rtol=1e-12)
    q, v = np.array([0, 0, 0, 1, 1 - e, 0, 0]), np.array([0, 0, 0, 0, np.sqrt((1 + e) / (1 - e)), 0])

    def particle():
        b = axode.Builder("particle", [0, 0, 0])
        return b.body("particle", joint="free", mass=1, com=[0, 0, 0], inertia=[1, 1, 1])

    def attraction(t, q, v):
        force = -q[4:] / np.linalg.norm(q[4:])**3
        return [axode.Load(frame="particle", representation="hybrid", wrench=np.append(np.zeros(3), force))]

    position = scheme.states(particle().build(), q, v, t, loads=attraction)[0][:, 4:6]
    E = t.astype(float)
    for _ in range(50):
        E -= (E - e * np.sin(E) - t) / (1 - e * np.cos(E))
    exact = np.array([np.cos(E) - e, np.sqrt(1 - e**2) * np.sin(E)]).T
    yield Comparison("x and y at 20 times in 3.2 turns, m", position, exact, 2e-9, scheme,
                     "Kepler's equation, for the eccentricity 0.6, a semi-major axis of 1 m and 1 m³/s².")

    m = particle().spring("ground", "particle", points=[[0, 0, 0], [0, 0, 0]], stiffness=4).build()
    position = scheme.states(m, q, v, t)[0][:, 4:6]
    exact = np.array([q[4] * np.cos(2 * t), v[4] / 2 * np.sin(2 * t)]).T
    yield Comparison("x and y at 20 times in 6.4 turns, m", position, exact, 1e-10, scheme,
                     "A spring of 4 N/m without a length at rest: 1 kg oscillates along each axis alone.")


def planetary_gear():
    """A sun drives three planets on a carrier within a ring that is at rest."""
    sun, planet, ring = 24, 18, 60  # teeth
    J_sun, J_carrier, J_planet, mass, radius, torque = 2e-4, 8e-4, 3e-5, 0.15, 0.042, 0.5
    b = axode.Builder("planetary gear", [0, 0, 0])

    def wheel(name, J, point=(0, 0, 0), on="ground", passive=True):
        hinge = {"kind": "revolute", "axis": "z", "point": point, "passive": passive}
        b.body(name, on=on, joint=hinge, mass=mass, com=point, inertia=[J, J, J])

    wheel("sun", J_sun, passive=False)
    wheel("carrier", J_carrier)
    for i, angle in enumerate(2 * np.pi / 3 * np.arange(3)):
        center = [radius * np.cos(angle), radius * np.sin(angle), 0]
        wheel(f"planet {i}", J_planet, center, on="carrier")
        # Relative to the carrier the teeth of sun, planet and ring pass at the same rate.
        b.coupling({f"planet {i}_joint": planet, "sun_joint": sun, "carrier_joint": -sun})
        b.coupling({f"planet {i}_joint": planet, "carrier_joint": ring})
    m = b.build()

    carrier = sun / (sun + ring)  # angle for one of the sun: Willis' equation
    on_carrier = -ring / planet * carrier
    J = J_sun + (J_carrier + 3 * mass * radius**2) * carrier**2 + 3 * J_planet * (carrier + on_carrier)**2
    expected = torque / J * np.array([1, carrier, on_carrier, on_carrier, on_carrier])
    by_hand = "By hand: Willis' equation, and the inertia of all wheels reduced to the sun."
    tau = torque * (np.array(m.joint_names) == "sun_joint")
    scheme = Scheme(rtol=1e-8)
    q, v = scheme.states(m, m.neutral(), np.zeros(m.nv), [1], tau=tau)
    yield Comparison("velocities of sun, carrier and planets at 1 s, rad/s", v[0], expected, 1e-8, scheme,
                     by_hand)
    yield Comparison("their angles at 1 s, rad", q[0], expected / 2, 1e-8, scheme, by_hand)


CASES = {"tumbling_brick": tumbling_brick, "orbits": orbits, "planetary_gear": planetary_gear}
