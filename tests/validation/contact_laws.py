"""Orders of the step with contact, energy that contact makes, openness of loops, and certificates."""

import tomllib

import axode
import contact_drawings as drawings
import numpy as np
from contact_drawings import at, ball, body, cube, scene, shape, solid_box


def run(m, q, v, until, step, **options):
    return axode.simulate(m, q, v, until, step=step, contact=True, **options)


def tumbling_box():
    """A box in flight, high above the floor."""
    edges = [0.2, 0.3, 0.4]
    return scene(body("box", 1, solid_box(1, edges), [shape("box", size=edges)]), friction=0.5), at(3), [3, 1, 2, 1, 0, 0]


def unround_ball():
    """A ball that rolls, with its centre of mass beside its centre."""
    rolling = body("ball", 1, [0.004, 0.005, 0.006], [shape("sphere", radius=0.1)], com=(0.02, 0, 0))
    return scene(rolling, friction=1.0), at(0.1), [0, 5, 0, 0.5, 0, 0]


def sliding_sled():
    m, v = drawings.sled()
    return m, at(0.1), v


def bounced(height, t, e=0.8, g=drawings.G):
    """The height at t of a ball that falls from a height and bounces."""
    begin, speed = np.sqrt(2 * height / g), e * np.sqrt(2 * g * height)
    if t < begin:
        return height - g * t**2 / 2
    while t > begin + 2 * speed / g:
        begin, speed = begin + 2 * speed / g, e * speed
    return speed * (t - begin) - g * (t - begin) ** 2 / 2


#: Motions of a step by name, with a time (s).
MOTIONS = {"a box tumbles in flight": (tumbling_box, 0.3), "a sled slides and turns": (sliding_sled, 0.15),
           "an eccentric ball rolls": (unround_ball, 0.3)}
IMPACTS = "a ball bounces 3 times (mean of 60)"
STEPS = (4e-3, 2e-3, 1e-3)


def errors(name, finest=1.25e-4):
    """Errors of the coordinates at the end of a motion, against steps of 0.125 ms extrapolated to steps of 0."""
    make, until = MOTIONS[name]
    m, q, v = make()
    fine, finer = (run(m, q, v, until, step).q[-1] for step in (finest, finest / 2))
    exact = finer + (finer - fine) / 3
    return [float(np.abs(run(m, q, v, until, step).q[-1] - exact).max()) for step in STEPS]


def errors_of_impacts():
    """Mean errors of the height of a ball after three impacts, which fall into any part of a step."""
    m, heights = scene(ball(0.8)), np.linspace(0.17, 0.25, 60)
    until = 0.9
    return [float(np.mean([abs(run(m, at(0.1 + height), np.zeros(6), until, step).q[-1, 6] - 0.1 - bounced(height, until))
                           for height in heights])) for step in STEPS]


def energy_made(restitution, step):
    """The largest increase of energy in a step of a box that falls, tumbles, bounces and slides, and its energy, J."""
    m = scene(cube(), friction=0.4, restitution=restitution)
    q = at(0.4)
    q[:4] = np.array([0.3, 0.2, 0.1, np.sqrt(1 - 0.14)])
    motion = run(m, q, [3, -2, 1, 1, 0.5, 0], 1.5, step)
    return float(max(0.0, np.diff(motion.energy).max())), float(motion.energy[0])


def stopped_four_bar():
    """The linkage of four_bar.toml with hard stops at its crank."""
    drawing = tomllib.loads((axode.robots / "four_bar.toml").read_text())
    drawing["body"][0]["joint"] |= {"limits": [-0.6, 0.6], "stop": "hard", "restitution": 0.5}
    return axode.Model.from_dict(drawing)


def loops_open(step):
    """The largest residual of the loops at the ends of steps of a four-bar that hits its stops, m and rad."""
    m = stopped_four_bar()
    motion = run(m, m.neutral(), np.zeros(m.nv), 2.0, step)
    return float(np.abs(axode.loop_residual(m, motion.q)).max()), motion


def dominoes(count=8):
    """Dominoes in a row, the first of which is pushed."""
    edges = [0.02, 0.06, 0.12]
    pieces = [body(f"domino {k}", 0.1, solid_box(0.1, edges), [shape("box", size=edges)]) for k in range(count)]
    q = at(*[0.06] * count)
    q[4::7] = 0.06 * np.arange(count)
    v = np.zeros(6 * count)
    v[1] = 4.0
    return run(scene(*pieces, friction=0.3), q, v, 1.0, 2.5e-3)


def tower():
    return run(scene(*(cube(f"box {k}") for k in range(6)), friction=0.5), at(*(0.1 + 0.2 * np.arange(6))),
               np.zeros(36), 1.0, 5e-3)


def certificates():
    """The certificates of motions by name."""
    yield "eight dominoes fall, 2.5 ms", dominoes().certificates
    yield "six boxes on each other, 5 ms", tower().certificates
    m, q, v = sliding_sled()
    yield "a sled slides and turns to rest, 2 ms", run(m, q, v, 0.8, 2e-3).certificates
    yield "a four-bar hits its stops, 5 ms", loops_open(5e-3)[1].certificates
