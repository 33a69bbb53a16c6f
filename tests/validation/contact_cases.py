"""Distances of motions with contact from the law of contact, in axode and in MuJoCo.

Each case is a motion that is known otherwise: in closed form, from an integration of its sliding equations by SciPy,
or because something that rests must not move. A number is a distance from the law, so that 0 is exact.
"""

import warnings
from collections.abc import Callable
from typing import NamedTuple

import axode
import contact_drawings as drawings
import numpy as np
from contact_drawings import G, at, ball, cube, scene
from numpy.linalg import norm
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

#: Settings of MuJoCo: its options as they are; elliptic cones with impratio 100 and a tolerance of 1e-12;
#: these with iterations that prevent slip; these with contacts as stiff as the step allows; and with both.
SETTINGS = ["default", "elliptic", "elliptic, noslip", "elliptic, stiff", "elliptic, noslip, stiff"]


class Case(NamedTuple):
    """`ours()` is a distance from the law, and `theirs(setting)` that of MuJoCo. `bound` is the largest for axode."""

    what: str
    unit: str
    bound: float
    ours: Callable[[], float]
    theirs: Callable[[str], float]
    settings: list = SETTINGS


def simulated(m, q, v, until, step, **options):
    """A motion of axode with contact whose certificates hold."""
    motion = axode.simulate(m, q, v, until, step=step, contact=True, **options)
    assert motion.certificates.max() <= 1e-9
    return motion


def creep(x):
    """The largest distance that numbers move in the last half of a motion of 2 s, m/s."""
    return float(np.abs(x[-1] - x[len(x) // 2]).max())


# MuJoCo -----------------------------------------------------------------------------------------------------


def xml_scene(*bodies, friction=0.0, spin=0.0, condim=3, gravity=(0, 0, -G), geom="", floor=True):
    """Free bodies above a plane, each of them a height and its elements."""
    text = "".join(f"<body pos='0 0 {z}'><freejoint/>{inner}</body>" for z, inner in bodies)
    plane = "<geom type='plane' size='50 50 1'/>" if floor else ""
    return (f"<mujoco><option gravity='{gravity[0]} {gravity[1]} {gravity[2]}'/><default><geom "
            f"friction='{friction} {spin} 0' condim='{condim}' {geom}/></default><worldbody>{plane}{text}"
            "</worldbody></mujoco>")


def xml_box(mass=1.0):
    return f"<geom type='box' size='.1 .1 .1' mass='{mass}'/>"


def xml_ball(radius, x=0, y=0, z=0, mass=0):
    return f"<geom type='sphere' size='{radius}' pos='{x} {y} {z}'" + (f" mass='{mass}'/>" if mass else "/>")


def xml_inertial(mass, inertia):
    return f"<inertial pos='0 0 0' mass='{mass}' diaginertia='{inertia[0]} {inertia[1]} {inertia[2]}'/>"


def in_mujoco(xml, until, setting, each, step=2e-3, **start):
    """What each(data) gives after every step. `start` has entries of mjData by name: their indices and values."""
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # a motion that diverges ends as NaN
    model = mujoco.MjModel.from_xml_string(xml)
    model.opt.timestep = step
    if "elliptic" in setting:
        model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        model.opt.impratio, model.opt.tolerance, model.opt.iterations = 100, 1e-12, 200
    if "noslip" in setting:
        model.opt.noslip_iterations, model.opt.noslip_tolerance = 50, 1e-12
    if "stiff" in setting:
        model.geom_solref[:] = 2 * step, 1
    data = mujoco.MjData(model)
    for name, (index, values) in start.items():
        getattr(data, name)[index] = values
    seen = []
    for _ in range(round(until / step)):
        mujoco.mj_step(model, data)
        seen.append(each(data))
    return np.array(seen)


# One body ---------------------------------------------------------------------------------------------------

INCLINE = (G * np.sin(np.radians(20)), 0, -G * np.cos(np.radians(20)))


def box_sticks():
    m = scene(cube(), friction=0.5, gravity=INCLINE)
    return creep(simulated(m, at(0.1), np.zeros(6), 2.0, 4e-3).q[:, 4])


def box_sticks_there(setting):
    xml = xml_scene((0.1, xml_box()), friction=0.5, gravity=INCLINE)
    return creep(in_mujoco(xml, 2.0, setting, lambda d: d.qpos[0]))


SLIDES = 2 * (INCLINE[0] + 0.3 * INCLINE[2])  # in 2 s, m


def box_slides():
    m = scene(cube(), friction=0.3, gravity=INCLINE)
    return abs(simulated(m, at(0.1), np.zeros(6), 2.0, 4e-3).q[-1, 4] - SLIDES)


def box_slides_there(setting):
    xml = xml_scene((0.1, xml_box()), friction=0.3, gravity=INCLINE)
    return abs(in_mujoco(xml, 2.0, setting, lambda d: d.qpos[0])[-1] - SLIDES)


def bowling_ball():
    motion = simulated(scene(ball(), friction=0.3), at(0.1), [0, 0, 0, 1, 0, 0], 0.5, 2e-3)
    return abs((motion.q[-1, 4] - motion.q[-2, 4]) / (motion.t[-1] - motion.t[-2]) - 5 / 7)


def bowling_ball_there(setting):
    xml = xml_scene((0.1, xml_ball(0.1, mass=1)), friction=0.3)
    return abs(in_mujoco(xml, 0.5, setting, lambda d: d.qvel[0], qvel=(0, 1.0))[-1] - 5 / 7)


def tops(z):
    """The largest relative error of up to four tops above 5 cm of a ball that falls from 1 m, e = 0.8."""
    inner = (z[:-2] < z[1:-1]) & (z[1:-1] >= z[2:]) & (z[1:-1] > 0.05)
    heights = z[1:-1][inner][:4]
    return float(np.abs(heights / 0.8 ** (2 * np.arange(1, len(heights) + 1)) - 1).max()) if len(heights) else np.nan


def bouncing_ball():
    return tops(simulated(scene(ball(0.8)), at(1.1), np.zeros(6), 3.0, 1e-3).q[:, 6] - 0.1)


SPRINGS = {"default": (1e5, ""), **{f"stiffness {k:.0e} 1/s²".replace("e+0", "e"): (
    k, "solimp='.9999 .9999 .001'") for k in (1e4, 1e5, 1e6)}}


def bouncing_ball_there(setting):
    stiffness, solimp = SPRINGS[setting]
    damping = 2 * np.sqrt(stiffness) * -np.log(0.8) / np.hypot(np.pi, np.log(0.8))
    xml = xml_scene((1.1, xml_ball(0.1, mass=1)), geom=f"solref='{-stiffness} {-damping}' {solimp}")
    return tops(in_mujoco(xml, 3.0, "", lambda d: d.qpos[2] - 0.1, 1e-3))


# A tippe top, and a sled ------------------------------------------------------------------------------------


def event_of(rates, y, until, event):
    """The time and the state at which an event ends a motion."""
    event.terminal = True
    found = solve_ivp(rates, (0, until), y, method="DOP853", rtol=1e-10, atol=1e-12, events=event)
    return found.t[-1], found.y[:, -1]


def time_of_stem():
    """When the stem of the tippe top touches, by the equations of a ball that slides and drills."""
    top = drawings.TIPPE_TOP
    mass, I, (R1, R2), (a1, a2) = top["mass"], np.array(top["inertia"]), top["radii"], top["centres"]
    mu, spin, z = top["friction"], top["spin_friction"], np.array([0, 0, 1.0])

    def rates(t, y):
        """Quaternion x y z w, angular velocity in the body, velocity of the centre of mass in the plane."""
        R, w = Rotation.from_quat(y[:4]).as_matrix(), y[4:7]
        axis, omega = R[:, 2], R @ w
        arm = a1 * axis - R1 * z
        slip = (np.append(y[7:], 0) + np.cross(omega, arm)) * [1, 1, 0]
        size = np.sqrt(mu**2 * slip @ slip + spin**2 * omega[2]**2)
        force, moment = z - mu**2 * slip / size, -spin**2 * omega[2] / size * z  # for a normal force of 1
        free, by_force = np.cross(I * w, w) / I, R.T @ (np.cross(arm, force) + moment) / I
        height = np.cross(R @ free, axis) + np.cross(omega, np.cross(omega, axis))
        N = (G - a1 * height[2]) / (1 / mass + a1 * np.cross(R @ by_force, axis)[2])
        turn = np.append(y[3] * w / 2 + np.cross(y[:3], w) / 2, -y[:3] @ w / 2)
        return np.concatenate([turn, free + N * by_force, N / mass * force[:2]])

    half = top["inclination"] / 2
    start = np.array([np.sin(half), 0, 0, np.cos(half), 0, 0, top["spin"], 0, 0])
    return event_of(rates, start, 3.0, lambda t, y: R1 - R2 + (a2 - a1) * Rotation.from_quat(y[:4]).as_matrix()[2, 2])[0]


def tippe_top():
    m, q, v = drawings.tippe_top(drawings.TIPPE_TOP["spin_friction"])
    motion = simulated(m, q, v, 3.0, 1e-3)
    stem = norm(motion.contact_forces("stem"), axis=1)
    return abs(motion.t[np.flatnonzero(stem)[0]] - time_of_stem()) if stem.any() else np.inf


def tippe_top_there(setting):
    top = drawings.TIPPE_TOP
    q = drawings.tippe_top(0)[1]
    balls = "".join(xml_ball(r, z=z) for r, z in zip(top["radii"], top["centres"]))
    xml = xml_scene((q[6], xml_inertial(top["mass"], top["inertia"]) + balls), friction=top["friction"],
                    spin=top["spin_friction"], condim=4)
    touches = in_mujoco(xml, 3.0, setting, lambda d: any(2 in contact.geom for contact in d.contact), 1e-3,
                        qpos=(range(3, 7), np.roll(q[:4], 1)), qvel=(5, top["spin"]))
    return abs((np.flatnonzero(touches)[0] + 1) * 1e-3 - time_of_stem()) if touches.any() else np.inf


def rest_of_sled():
    """Where the sled comes to rest, by the equations of three feet that slide."""
    feet, height, mu, I = drawings.FEET, drawings.SLED["height"], drawings.SLED["friction"], drawings.SLED["inertia"]

    def rates(t, y):
        """Place and angle, and their rates."""
        c, s = np.cos(y[2]), np.sin(y[2])
        arms = feet @ np.array([[c, s], [-s, c]])
        slip = y[3:5] + y[5] * arms[:, ::-1] * [-1, 1]
        F = -mu * slip / norm(slip, axis=1)[:, None]  # for normal forces of 1
        N = np.linalg.solve([np.ones(3), arms[:, 1] + height * F[:, 1], arms[:, 0] + height * F[:, 0]], [G, 0, 0])
        return np.concatenate([y[3:], N @ F, [N @ (arms[:, 0] * F[:, 1] - arms[:, 1] * F[:, 0]) / I[2]]])

    return event_of(rates, [0, 0, 0, *drawings.SLED["start"]], 2.0, lambda t, y: norm(y[3:]) - 1e-7)[1][:2]


def sled():
    m, v = drawings.sled()
    return norm(simulated(m, at(0.1), v, 0.8, 2e-3).q[-1, 4:6] - rest_of_sled())


def sled_there(setting):
    sizes = drawings.SLED
    feet = "".join(xml_ball(sizes["foot"], x, y, sizes["foot"] - sizes["height"]) for x, y in drawings.FEET)
    xml = xml_scene((sizes["height"], xml_inertial(1, sizes["inertia"]) + feet), friction=sizes["friction"])
    return norm(in_mujoco(xml, 0.8, setting, lambda d: d.qpos[:2].copy(), qvel=([0, 1, 5], sizes["start"]))[-1]
                - rest_of_sled())


# Several bodies ---------------------------------------------------------------------------------------------

LEAST = G / 20  # coefficient of friction by which two fingers with 10 N each just hold 1 kg


def grasped_box():
    m = drawings.grasp(1.1 * LEAST)
    tau = np.zeros(m.nv)
    tau[[m.joint("finger at -0.12_joint").v.start, m.joint("finger at 0.12_joint").v.start]] = 10
    height = m.joint("box_joint").q.start + 6
    return creep(simulated(m, m.neutral(), np.zeros(m.nv), 2.0, 5e-3, tau=tau).q[:, height])


def grasped_box_there(setting):
    def finger(x):
        return (f"<body pos='{x} 0 0'><joint type='slide' axis='{-np.sign(x)} 0 0'/>"
                "<geom type='box' size='.02 .05 .05' mass='.2'/></body>")

    xml = xml_scene((0, xml_box()), friction=1.1 * LEAST, floor=False).replace(
        "</worldbody>", f"{finger(-0.12)}{finger(0.12)}</worldbody>")
    return creep(in_mujoco(xml, 2.0, setting, lambda d: d.qpos[2], qfrc_applied=([6, 7], 10.0)))


MASSES = [1.0] * 9 + [1000.0]
HEIGHTS = [0.1 + 0.2 * k for k in range(10)]


def heavy_tower():
    m = scene(*(cube(f"box {k}", mass) for k, mass in enumerate(MASSES)), friction=0.5)
    motion = simulated(m, at(*HEIGHTS), np.zeros(m.nv), 1.0, 1e-2)
    return max(0.0, -min(contact.gap for contacts in motion.contacts for contact in contacts))


def heavy_tower_there(setting):
    xml = xml_scene(*((z, xml_box(mass)) for z, mass in zip(HEIGHTS, MASSES)), friction=0.5)
    return max(0.0, -in_mujoco(xml, 1.0, setting, lambda d: min(d.contact.dist, default=0.0)).min())


GAINS, PUSH = (40.0, 0.8), np.array([3.0, 2.0, 0.0])  # N m/rad, N m s/rad; N


def quadruped():
    m = axode.load(axode.robots / "quadruped.toml")
    gains = np.array([[0.0] * 6 + [gain] * 12 for gain in GAINS])
    push = axode.Load(frame="trunk", representation="hybrid", wrench=np.append(np.zeros(3), PUSH))
    feet = [m.frame_index(f"{leg} sole") for leg in ("FL", "FR", "RL", "RR")]
    motion = simulated(m, m.neutral(), np.zeros(m.nv), 2.0, 2e-3, loads=[push],
                       tau=axode.drives.PD(*gains, m.neutral()))
    return creep(axode.poses(m, motion.q)[:, feet][:, :, :2, 3].reshape(len(motion.t), -1))


def quadruped_there(setting):
    m = axode.load(axode.robots / "quadruped.toml")
    joints = [joint.name for joint in m.joints[1:]]
    kp, kd = GAINS
    drives = "".join(f'<position joint="{name}" kp="{kp}" kv="{kd}"/>' for name in joints)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # MJCF has no word for a margin
        written = axode.mjcf(m)
    xml = written.replace("<worldbody>", '<option integrator="implicitfast"/><worldbody>').replace(
        "</mujoco>", f"<actuator>{drives}</actuator></mujoco>")
    import mujoco

    names = mujoco.MjModel.from_xml_string(xml)
    soles = [names.body(f"{leg} shank").id for leg in ("FL", "FR", "RL", "RR")]
    offset = axode.poses(m, m.neutral())
    sole = np.array([(np.linalg.inv(offset[m.frame_index(f"{leg} shank")]) @ offset[m.frame_index(f"{leg} sole")])[:3, 3]
                     for leg in ("FL", "FR", "RL", "RR")])

    def feet(d):
        return np.concatenate([(d.xpos[k] + d.xmat[k].reshape(3, 3) @ r)[:2] for k, r in zip(soles, sole)])

    return creep(in_mujoco(xml, 2.0, setting, feet, qfrc_applied=(range(3), PUSH)))


CASES = {
    "box sticks": Case("a box on an incline of 20°, μ 0.5, creeps with", "m/s", 1e-12, box_sticks, box_sticks_there),
    "box slides": Case("the same with μ 0.3 slides 1.18 m; off by", "m", 1e-11, box_slides, box_slides_there),
    "sled": Case("a box on three feet slides 0.21 m and turns; its place of rest is off by", "m", 2e-6, sled, sled_there),
    "bowling ball": Case("a ball that slid rolls with 5/7 of its speed; off by", "m/s", 1e-11, bowling_ball,
                         bowling_ball_there),
    "tippe top": Case("a tippe top touches with its stem after 1.43 s; off by (1 ms)", "s", 2e-3, tippe_top,
                      tippe_top_there),
    "quadruped": Case("a quadruped that stands on PD control is pushed; its feet creep with", "m/s", 1e-7, quadruped,
                      quadruped_there),
    "grasp": Case("a box between two fingers, μ 1.1 of the least, creeps with", "m/s", 1e-12, grasped_box,
                  grasped_box_there),
    "tower": Case("ten boxes, the top one of 1000 kg, overlap by at most", "m", 1e-11, heavy_tower, heavy_tower_there),
    "bouncing ball": Case("a ball bounces with e = 0.8; its first tops are off by (1 ms)", "of their heights", 1.5e-2,
                          bouncing_ball, bouncing_ball_there, list(SPRINGS)),
}
