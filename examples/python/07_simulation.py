"""Motions of an arm: it falls, and keeps its energy; a controller draws it to a target."""

import axode
import numpy as np
from numpy.typing import NDArray

arm = axode.load(axode.robots / "arm7.toml")
target = np.array([0.0, 0.5, 0.0, -1.0, 0.0, 0.8, 0.0])


def drive(t: float, q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Gravity is compensated; springs and dampers draw the joints to the target."""
    return np.asarray(axode.gravity_torques(arm, q) + 100 * (target - q) - 20 * v)


fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=1.0)
print(f"it falls: {fall.steps} steps, energy within {np.ptp(fall.energy):.0e} J")

reached = axode.simulate(arm, np.full(7, 0.2), np.zeros(7), until=3.0, tau=drive, times=np.linspace(0, 3, 7))
for t, q in zip(reached.t, reached.q):
    print(f"t = {t:.1f} s: {np.linalg.norm(q - target):.4f} rad from the target")

flange = axode.poses(arm, reached.q)[:, arm.frame_index("flange"), :3, 3]
print("the flange ends at", flange[-1].round(3))
