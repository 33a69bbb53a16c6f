"""Reading of mechanisms from files of any format."""

from __future__ import annotations

import importlib
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from xml.etree import ElementTree

from numpy.typing import ArrayLike

from .support import mujoco_model, signatures
from ._axode import Model, check_file, load_dict, load_file, load_urdf, syntax_fault
from .errors import ModelError

if TYPE_CHECKING:
    from .errors import Fault

__all__ = ["check", "load"]

def load(path: str | os.PathLike[str], base: Literal["fixed", "free"] | None = None, *,
         gravity: ArrayLike | None = None, strict: bool = False) -> Model:
    """Loads the mechanism of a file: a drawing (.toml), a URDF (.urdf), SDFormat (.sdf, .world), MJCF (.xml) or xacro (.xacro).

    For any other file the root element decides. MJCF is compiled by MuJoCo (`pip install mujoco`), and xacro is
    expanded by xacro (`pip install xacro`). docs/formats.md says what each format carries over.

    base="free" gives the body that is fixed to the ground a free joint `free_base`; base="fixed" fixes the bodies
    that are on free joints on the ground. If base is left out, the file decides. ModelError lists every fault of a
    file with its line. Defects that do not prevent a computation, such as an inertia that no mass distribution has,
    and elements that are not carried over, are reported in `Model.warnings`; with strict=True such defects are
    faults. `gravity` (3,), m/s^2, replaces the gravity of the file.

    >>> arm = axode.load(axode.robots / "arm7.toml")
    >>> arm.nv
    7
    """
    file = Path(os.fspath(path))
    if file.suffix == ".xacro":
        return load_urdf(_expanded(file), str(file), base, gravity, strict)
    if _is_mjcf(file):
        drawing, warnings = mujoco_model.read(_compiled(file))
        return load_dict(drawing, str(file), warnings, base, gravity, strict)
    return load_file(path, base, gravity, strict)


def check(path: str | os.PathLike[str], base: Literal["fixed", "free"] | None = None, *,
          strict: bool = False) -> list[Fault]:
    """Lists all errors and warnings of `load` for a file, by line. A file that cannot be read is a fault as well.

    >>> axode.check(axode.robots / "arm7.toml")
    []
    """
    file = Path(os.fspath(path))
    if file.suffix != ".xacro" and not _is_mjcf(file):
        return check_file(path, base, strict)
    try:
        return list(load(path, base, strict=strict).warnings)
    except ModelError as error:
        return error.faults


def _is_mjcf(file: Path) -> bool:
    if file.suffix in (".toml", ".urdf", ".sdf", ".world") or not file.is_file():
        return False
    try:
        with file.open("rb") as stream:
            _, root = next(ElementTree.iterparse(stream, events=("start",)))
    except (ElementTree.ParseError, OSError, StopIteration, ValueError, LookupError):
        return False  # the other readers find its faults
    return str(root.tag) == "mujoco"


def _compiled(file: Path) -> Any:
    mujoco = mujoco_model.import_mujoco(f"{file} is MJCF, which")
    try:
        return mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        raise _refused(f"MuJoCo does not compile it: {error}", file) from error


def _expanded(file: Path) -> str:
    try:
        xacro = importlib.import_module("xacro")
    except ImportError as error:
        raise ImportError(f"{file} is a xacro file, which needs xacro: pip install xacro") from error
    try:
        return str(xacro.process_file(str(file)).toxml())
    except Exception as error:  # xacro raises exceptions of Python, of XML and its own
        raise _refused(f"xacro does not expand it: {type(error).__name__}: {error}", file) from error


def _refused(text: str, file: Path) -> ModelError:
    line = re.search(r"\bline (\d+)", text)
    fault = syntax_fault(" ".join(text.split()), str(file), int(line[1]) if line else 0)
    return ModelError(str(fault), [fault])


signatures.explain_calls(__name__)
