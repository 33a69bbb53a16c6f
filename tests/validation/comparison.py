"""What the cases of the page of evidence share: comparisons, schemes and published numbers."""

import json
from pathlib import Path
from typing import NamedTuple

import axode
import numpy as np

FOLDER = Path(__file__).resolve().parent


class Scheme:
    """A method of `axode.simulate` with its step (s) or its relative tolerance, and its coordinates."""

    def __init__(self, method="dopri5", *, step=None, rtol=None, coordinates="relative"):
        self.options = {"method": method, "coordinates": coordinates}
        self.options |= {"step": step} if step else {"rtol": rtol, "atol": rtol / 100}
        self.name = f"`{method}`, " + (f"{step:g} s" if step else f"rtol = {rtol:.0e}".replace("e-0", "e-"))
        if coordinates != "relative":
            self.name += f", `{coordinates}`"

    def states(self, m, q, v, times, **forces):
        """q and v at times after 0, shapes (N, nq) and (N, nv)."""
        motion = axode.simulate(m, q, v, times[-1], times=np.append(0, times), **self.options, **forces)
        return motion.q[1:], motion.v[1:]


class Comparison(NamedTuple):
    """Numbers of axode beside those of a reference. The largest difference must not exceed the bound."""

    quantity: str  # with its unit
    ours: np.ndarray
    reference: np.ndarray
    bound: float
    scheme: Scheme
    source: str  # where the reference is from

    @property
    def error(self):
        return float(np.abs(np.asarray(self.ours) - np.asarray(self.reference)).max())


class Published:
    """Rows of numbers from a file of this folder, with their source and licence."""

    def __init__(self, file, name):
        entry = json.loads((FOLDER / file).read_text(encoding="utf-8"))[name]
        self.source = entry["source"] + "."
        if "licence" in entry:
            self.source += f" Licence: {entry['licence']}."
        self.columns = entry["columns"]
        self.rows = entry["rows"]

    def column(self, name):
        return np.array([row[self.columns.index(name)] for row in self.rows])

    def array(self):
        return np.array(self.rows, dtype=float)
