"""The table of functions of a state: arguments, results, and the parts of a mechanism that each function counts.

C++, the command, this package and its bridges are made from the same rows.

>>> row = axode.table.ROWS["forward_dynamics"]
>>> row.takes
('q', 'v', 'tau', 'loads')
>>> row.item(arm)
(7,)
>>> row.counts["loops"]
('counted', '')
"""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ["ROWS", "Row"]

#: Arguments that are not numbers of a state.
SETTINGS = ("loads", "frame", "base", "form", "at")


class Row(NamedTuple):
    """A function of a state.

    >>> axode.table.ROWS["mass_matrix"].purpose
    'The mass matrix M gives the kinetic energy v^T M v / 2, and includes armatures.'
    """

    name: str
    purpose: str
    units: str
    takes: tuple[str, ...]
    choice: str
    """The representation that the caller chooses: "none", that of the result ("representation"), or that of the recursion
    ("recursion")."""
    entry: int
    """Number of numbers in an entry of the result."""
    shape: tuple[str, ...]
    """Extents of the result, outermost first: "nv", "n_bodies", ..."""
    symbols: tuple[str, ...]
    """Symbols of the results, which are stored one after the other."""
    derivative_of: str
    may_fail: bool
    """Whether it fails if the mass matrix is singular."""
    recorded: bool
    """Whether code can be generated for it, see axode.codegen."""
    counts: dict[str, tuple[str, str]]
    """For loops, passive joints, springs, joint losses, prescribed motions, drives with states, couplings with play and
    contacts: "counted", "of_the_tree", "optional", "partly" or "refused", with a sentence that names another function if there
    is one."""

    @property
    def arrays(self) -> tuple[str, ...]:
        """The arguments that are numbers of a state.

        >>> axode.table.ROWS["inverse_dynamics"].arrays
        ('q', 'v', 'a')
        """
        return tuple(name for name in self.takes if name not in SETTINGS)

    def item(self, sizes: Any) -> tuple[int, ...]:
        """The shape of the results of one state, for an object with the attributes nv, n_bodies and so on.

        >>> axode.table.ROWS["inverse_dynamics_derivatives"].item(arm)
        (3, 7, 7)
        """
        several = () if len(self.symbols) == 1 else (len(self.symbols),)
        numbers = () if self.entry == 1 else (self.entry,)
        return (*several, *(_extent(name, sizes) for name in self.shape), *numbers)


def _extent(name: str, sizes: Any) -> int:
    if name == "6":
        return 6
    if name == "n_parameters":
        return 10 * int(sizes.n_bodies)
    return int(getattr(sizes, "n_bodies" if name == "n_joints" else name))


def _rows() -> dict[str, Row]:
    from . import _axode

    return {row.name: row for row in _axode.rows()}


ROWS: dict[str, Row] = _rows()
