"""Times of impacts, separation, slip and stop by the method contact_exact, beside closed forms."""

import axode
import numpy as np
from contact_drawings import G, at, ball, body, cube, scene, shape


def run(m, q, v, until, **options):
    return axode.simulate(m, q, v, until, method="contact_exact", rtol=1e-12, atol=1e-12, **options)


def root(low, high, f):
    """Where f changes its sign."""
    sign = np.sign(f(low))
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if np.sign(f(middle)) == sign else (low, middle)
    return high


def bounces():
    e, height = 0.8, 0.5
    motion = run(scene(ball(e)), at(0.1 + height), np.zeros(6), 3)
    fall = np.sqrt(2 * height / G)
    found = [event.t for event in motion.contact_events if event.kind == "bounce"]
    return found, [fall * (1 + 2 * sum(e**k for k in range(1, n + 1))) for n in range(len(found))]


def rolling():
    mu, speed = 0.3, 2.0
    motion = run(scene(ball(), friction=mu), at(0.1), [0, 0, 0, speed, 0, 0], 1)
    return [event.t for event in motion.contact_events if event.kind == "stick"], [2 * speed / (7 * mu * G)]


def separation():
    """A ball rolls off a dome without friction: the cosine of its place falls to 2/3 of that at the start."""
    start, length = 0.3, 0.6
    drawing = {"format": "axode drawing 1", "gravity": [0, 0, -G], "contact": {"friction": 0.0},
               "shape": [shape("sphere", name="dome", radius=length - 0.1)],
               "body": [body("ball", 1, [0.004] * 3, [shape("sphere", radius=0.1)])]}
    m = axode.Model.from_dict(drawing)
    q = [0, 0, 0, 1, length * np.sin(start), 0, length * np.cos(start)]
    motion = run(m, q, np.zeros(6), 0.6)
    # θ'' = g sin θ/l; with y² = θ - start the time is a smooth integral, by Gauss' rule.
    end = np.arccos(2 / 3 * np.cos(start))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    y = np.sqrt(end - start) * (nodes + 1) / 2
    half = y**2 / 2
    fall = np.sin(start + half) * np.sinc(half / np.pi)  # (cos start - cos θ)/y²
    time = np.sum(weights * 2 / np.sqrt(2 * G / length * fall)) * np.sqrt(end - start) / 2
    return [event.t for event in motion.contact_events if event.kind == "open"], [time]


def swinging_force():
    """A box under a swinging force slips and stops."""
    mu, force, rate = 0.4, 6.0, 3.0
    motion = run(scene(cube(), friction=mu), at(0.1), np.zeros(6), 1.4,
                 tau=lambda t, q, v: np.array([0, 0, 0, force * np.sin(rate * t), 0, 0]))
    slip = np.arcsin(mu * G / force) / rate
    stop = root(slip + 0.1, slip + 1.2, lambda t: force / rate * (np.cos(rate * slip) - np.cos(rate * t)) - mu * G * (t - slip))
    slips, stops = ([event.t for event in motion.contact_events if event.kind in kinds]
                    for kinds in (["slip"], ["stick", "reverse"]))
    return slips[:4] + stops[:4], [slip] * 4 + [stop] * 4


#: Events by what happens: functions that return the times that were found, and those of the law.
EVENTS = {"a ball bounces, e = 0.8": bounces, "a ball that slides begins to roll": rolling,
          "a ball leaves a dome without friction": separation,
          "a box under a swinging force slips and stops": swinging_force}


def rows():
    """For each case: its name, the number of events, the time of the last one, and the largest error of a time, s."""
    for name, case in EVENTS.items():
        found, law = case()
        assert len(found) == len(law) > 0, name
        yield name, len(found), law[-1], float(np.abs(np.subtract(found, law)).max())
