"""Mechanisms as FMUs (Functional Mock-up Units), which other simulators run: `export`.

An FMU contains the mechanism as a drawing, and a binary for this platform with the parts of axode that simulate it.
docs/fmi.md describes its variables.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from .. import _axode
from .._axode import Model
from ..support import signatures, written_files

__all__ = ["export"]

BINARY = Path(__file__).parents[1] / "lib/axode/axode_fmu.so"
#: Who integrates: the simulator that runs the FMU, or the FMU itself.
Kind = Literal["model_exchange", "co_simulation"]


def export(m: Model, file: str | os.PathLike[str], *, version: Literal["3.0", "2.0"] = "3.0",
           kinds: Sequence[Kind] = ("model_exchange", "co_simulation"), joint_losses: bool = False,
           frames: Sequence[str] = (), loads: Sequence[str] = ()) -> None:
    """Writes a mechanism as an FMU for a version of FMI, for model exchange, co-simulation or both.

    Loops stay closed. Springs, prescribed motions and drives act as in `simulate`, and with `joint_losses` so do damping,
    friction and losses of gears of the joints. Poses of the frames in `frames` are outputs, and wrenches on those in
    `loads` are inputs. In co-simulation, shapes touch if the mechanism has settings of contact, and hard stops stop. In
    model exchange dry friction, play and hard stops are events, and contact raises ValueError.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     axode.fmi.export(arm, f"{folder}/arm7.fmu", version="2.0", frames=["flange"])
    """
    if not BINARY.is_file():
        raise RuntimeError(f"this build of axode has no binary for FMUs: there is no {BINARY}")
    contents = _axode.fmu_files(m, version, list(kinds), bool(joint_losses), list(frames), list(loads),
                                BINARY.read_bytes())
    with (written_files.replacing(Path(os.fspath(file))) as unfinished,
          zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as archive):
        for name, data in contents:
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)


signatures.explain_calls(__name__)
