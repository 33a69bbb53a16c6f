"""Motions with contact in closed form, and by equations of sliding that SciPy integrates."""

import axode
import contact_cases as cases
import contact_drawings as drawings
import contact_events
import contact_laws
import numpy as np
from comparison import Comparison, Scheme
from contact_drawings import at, ball, cube, scene

EXACT = Scheme("contact_exact", rtol=1e-12)


def motion_of(m, q, v, until, scheme, **options):
    return axode.simulate(m, q, v, until, **scheme.options, **options)


def bouncing_ball():
    """A ball that falls from 0.5 m and bounces with e = 0.8."""
    times, law = contact_events.bounces()
    yield Comparison(f"times of {len(law)} impacts, s", times, law, 1e-12, EXACT,
                     "By hand: the speed after each impact is 0.8 of that before.")
    t = np.linspace(0.05, 2.8, 56)
    motion = motion_of(scene(ball(0.8)), at(0.6), np.zeros(6), t[-1], EXACT, times=np.append(0, t))
    yield Comparison("height at 56 times to 2.8 s, m", motion.q[1:, 6] - 0.1,
                     [contact_laws.bounced(0.5, x) for x in t], 1e-10, EXACT,
                     "By hand: the speed after each impact is 0.8 of that before.")


def sliding_ball():
    """A ball that slides with 2 m/s at first, until it rolls."""
    times, law = contact_events.rolling()
    source = "By hand: it rolls after 2 v/(7 μ g), with 5/7 of its speed."
    yield Comparison("time at which it begins to roll, s", times, law, 1e-12, EXACT, source)
    for scheme in (EXACT, Scheme("contact", step=2e-3)):
        m = scene(ball(), friction=0.3)
        motion = motion_of(m, at(0.1), [0, 0, 0, 2, 0, 0], 1, scheme)
        twist = axode.twists(m, motion.q[-1], motion.v[-1], "hybrid")[m.frame_index("ball")]
        yield Comparison("angular velocity and velocity at 1 s, rad/s and m/s", twist[[1, 3]],
                         [100 / 7, 10 / 7], 1e-10, scheme, source)


def dome():
    """A ball that rolls off a dome without friction."""
    times, law = contact_events.separation()
    yield Comparison("time at which it leaves the dome, s", times, law, 1e-12, EXACT,
                     "By hand: it leaves at 2/3 of the height at which it starts; the time is an integral.")


def box_under_a_force():
    """A box under the force 6 sin(3 t) N."""
    times, law = contact_events.swinging_force()
    yield Comparison("times at which four corners slip and stop, s", times, law, 1e-12, EXACT,
                     "By hand: the force exceeds μ m g, and the momentum is used up.")


def box_on_an_incline():
    """A box on a plane of 20°."""
    t = np.array([0.5, 1, 1.5, 2])
    for scheme, bound in ((EXACT, 1e-10), (Scheme("contact", step=4e-3), 1e-10)):
        for mu, what in ((0.5, "place at 4 times to 2 s of a box that sticks, μ 0.5, m"),
                         (0.3, "place at 4 times to 2 s of a box that slides, μ 0.3, m")):
            slope = cases.INCLINE[0] + mu * cases.INCLINE[2]
            m = scene(cube(), friction=mu, gravity=cases.INCLINE)
            motion = motion_of(m, at(0.1), np.zeros(6), 2.0, scheme, times=np.append(0, t))
            yield Comparison(what, motion.q[1:, 4], max(slope, 0) * t**2 / 2, bound, scheme,
                             "By hand: g (sin 20° - μ cos 20°).")


def tippe_top():
    """The tippe top of Leine and Glocker turns over."""
    m, q, v = drawings.tippe_top(drawings.TIPPE_TOP["spin_friction"])
    expected = cases.time_of_stem()
    source = ("R. I. Leine and Ch. Glocker, A set-valued force law for spatial Coulomb-Contensou friction, Eur. "
              "J. Mech. A 22 (2003) 193; the equations of a ball that slides and drills, integrated by SciPy.")
    for scheme, bound in ((Scheme("contact_exact", rtol=1e-10), 1e-6), (Scheme("contact", step=1e-3), 2e-3)):
        motion = motion_of(m, q, v, 1.5, scheme)
        events = [event.t for event in motion.contact_events if '"stem"' in event.of]
        stem = np.linalg.norm(motion.contact_forces("stem"), axis=1)
        yield Comparison("time at which the stem touches, s", (events or motion.t[stem > 0])[:1], [expected], bound,
                         scheme, source)


def sled():
    """A body on three feet slides and turns until it rests."""
    m, v = drawings.sled()
    for scheme, bound in ((Scheme("contact_exact", rtol=1e-10), 1e-6), (Scheme("contact", step=2e-3), 2e-6)):
        q = motion_of(m, at(0.1), v, 0.8, scheme).q[-1, 4:6]
        yield Comparison("x and y at rest, m", q, cases.rest_of_sled(), bound, scheme,
                         "The equations of three feet that slide, integrated by SciPy.")


CASES = {"bouncing_ball": bouncing_ball, "sliding_ball": sliding_ball, "dome": dome,
         "box_under_a_force": box_under_a_force, "box_on_an_incline": box_on_an_incline, "tippe_top": tippe_top,
         "sled": sled}
