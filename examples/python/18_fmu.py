"""A four-bar becomes an FMU. fmpy, a simulator that knows nothing of axode, runs it with a heavier coupler and a torque on
the crank, and axode simulates the same mechanism."""

import tempfile
from pathlib import Path

import axode
import numpy as np

TORQUE, MASS, UNTIL = 0.5, 3.0, 1.0  # N m, kg, s

try:
    import fmpy  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError:
    raise SystemExit("pip install fmpy runs the FMU") from None

m = axode.load(axode.robots / "four_bar.toml")
start = m.initial_state()
drawing = m.to_dict()
next(body for body in drawing["body"] if body["name"] == "coupler")["mass"] = MASS
motion = axode.simulate(axode.Model.from_dict(drawing), *start, UNTIL, tau=[TORQUE, 0, 0], rtol=1e-12, atol=1e-13)

with tempfile.TemporaryDirectory() as folder:
    fmu = Path(folder, "four_bar.fmu")
    axode.fmi.export(m, fmu)
    print(f"the FMU has {fmu.stat().st_size / 1e6:.1f} MB")
    for kind, tolerance in [("ModelExchange", 1e-10), ("CoSimulation", 1e-11)]:
        result = fmpy.simulate_fmu(
            str(fmu), fmi_type=kind, stop_time=UNTIL, output_interval=0.005, relative_tolerance=tolerance,
            start_values={"body.coupler.mass": MASS, "tau.crank_joint": TORQUE})
        end = np.array([result[f"q.{name}"][-1] for name in m.coordinate_names])
        print(f"{kind}: crank at {end[0]:.6f} rad, off by {np.abs(end - motion.q[-1]).max():.0e} rad from axode")
