"""A quadruped stands and then trots, on PD control of its joints. Its contact forces go into forces.svg."""

import axode
import numpy as np
from numpy.typing import NDArray

LEGS = {"FL": 0.0, "FR": 0.5, "RL": 0.5, "RR": 0.0}  # diagonal legs swing together; parts of a period
STANDS, UNTIL, PERIOD = 1.0, 4.0, 0.5  # s
LIFT, STRIDE = 0.25, 0.2  # rad
KP, KD = 40.0, 0.8  # N m/rad, N m s/rad

robot = axode.load(axode.robots / "quadruped.toml")
hips = {leg: robot.joint(f"{leg} hip pitch") for leg in LEGS}
knees = {leg: robot.joint(f"{leg} knee") for leg in LEGS}
base = robot.joint("base")
angles, rates = slice(base.q.stop, robot.nq), slice(base.v.stop, robot.nv)


def posture(t: float) -> NDArray[np.float64]:
    """The configuration that the drives follow: the drawn one, or that of a trot, which begins smoothly."""
    q = np.array(robot.neutral())
    size = np.clip((t - STANDS) / PERIOD, 0, 1)
    for leg, part in LEGS.items():
        phase = (t / PERIOD + part) % 1
        swings = phase < 0.5
        s = phase / 0.5 if swings else (phase - 0.5) / 0.5
        swing = STRIDE * np.cos(np.pi * s) * (1 if swings else -1)
        lift = LIFT * np.sin(np.pi * s) ** 2 if swings else 0.0
        q[hips[leg].q] = size * (swing + lift)
        q[knees[leg].q] = -2 * size * lift
    return q


# KP (posture - q) is a drive towards the drawn configuration with the rest fed forward.
drawn, times = robot.neutral(), np.linspace(0, UNTIL, 1601)
driven = np.arange(robot.nv) >= rates.start
ahead = np.zeros((len(times), robot.nv))
ahead[:, rates] = [KP * (posture(t) - drawn)[angles] for t in times]
drive = axode.drives.PD(KP * driven, KD * driven, drawn, feedforward=axode.drives.Sampled(times, ahead))

motion = axode.simulate(robot, drawn, np.zeros(robot.nv), UNTIL, step=4e-3, tau=drive)
forces = {leg: motion.contact_forces(f"{leg} foot") for leg in LEGS}
total = np.sum(list(forces.values()), axis=0)
weight = axode.gravity_torques(robot, drawn)[base.v][5]
standing = np.searchsorted(motion.t, STANDS) - 1
trots = motion.t > STANDS + PERIOD
print(f"it stands: its feet press with {total[standing, 2]:.4f} N, it weighs {weight:.4f} N")
print(f"it trots {motion.q[-1, base.q][4]:.2f} m in {UNTIL - STANDS:.0f} s; "
      f"its feet press with {total[trots, 2].mean():.1f} N on average")
airborne = {leg: float((force[trots, 2] == 0).mean()) for leg, force in forces.items()}
print("its feet are in the air for", ", ".join(f"{leg} {part:.0%}" for leg, part in airborne.items()), "of the time")
print(f"largest certificate {motion.certificates.max():.0e}")

try:
    from matplotlib import pyplot
except ImportError:
    raise SystemExit("pip install matplotlib draws the forces") from None
figure, axes = pyplot.subplots(figsize=(8, 4))
for leg, force in forces.items():
    axes.plot(motion.t, force[:, 2], label=leg, linewidth=0.8)
axes.set(xlabel="t, s", ylabel="normal force, N", ylim=(0, 3 * weight))
axes.legend()
figure.savefig("forces.svg")
