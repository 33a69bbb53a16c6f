"""States in Parquet: columns as arrays, functions of states as functions of tables, and files by parts."""

from __future__ import annotations

import contextlib
import difflib
import inspect
import os
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

import axode

from .._axode import Model, name_here
from ..errors import StatesError
from ..support import signatures

try:
    import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import pyarrow.compute as pc  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError("axode.distributed needs pyarrow: pip install pyarrow") from error

__all__: list[str] = []

Array = NDArray[Any]
#: The largest number of states that are read, computed and written at once.
ROWS = 65536
#: The largest number of bytes of results that are computed at once, unless one state has more.
BYTES = 1 << 26
#: Parameters with a number for each velocity.
OF_VELOCITIES = {"v", "a", "tau", "p", "dq", "dv", "da", "dtau"}
#: Parameters that have a value for each state.
OF_STATES = OF_VELOCITIES | {"q", "w", "V", "Pi", "rates", "directions", "more", "multipliers", "w_q", "w_v"}
#: The names of those results that are themselves part of a state.
RESULT_NAMES = {"inverse_dynamics": "tau", "forward_dynamics": "a"}


class RowError(Exception):
    """The number of a row that is refused, why, and the StatesError that refuses it, if there is one."""

    def located(self, where: str = "", first: int = 0) -> Exception:
        """The error to raise, if the table begins at row `first`."""
        row, why, *cause = self.args
        text = f"{where}row {first + row}: {why}"
        return type(cause[0])(text, [first + row], cause[0].result) if cause else ValueError(text)


# ----------------------------------------------------------------------------------------- columns and arrays


def numbers(column: Any, name: str, expected: int | None = None, taker: str = "") -> Any:
    """The numbers in a column of a table, (N, ...), NaN where it is null. If the `taker` expects no lists of a length,
    a column without numbers is returned as it is."""
    column = column.combine_chunks()
    shape: tuple[int, ...] = ()
    if pa.types.is_null(column.type):  # pandas writes columns without rows or values so
        column = column.cast(pa.list_(pa.float64()) if expected else pa.float64())
    if isinstance(column.type, pa.FixedShapeTensorType):
        shape, column = tuple(column.type.shape), column.storage
    elif hasattr(column.type, "value_type") and not pa.types.is_dictionary(column.type):
        lengths = np.asarray(pc.list_value_length(column).fill_null(-1))
        shape = (expected or getattr(column.type, "list_size", lengths.max(initial=0)),)
        if (wrong := (lengths >= 0) & (lengths != shape[0])).any():
            row = int(np.argmax(wrong))
            rule = f"{taker} takes" if expected else "in other rows it has"
            raise RowError(row, f'column "{name}" has {lengths[row]} numbers; {rule} {shape[0]}')
    if shape and column.null_count:
        column = pc.coalesce(column, pa.scalar([None] * int(np.prod(shape)), column.type))
    values = pc.list_flatten(column) if shape else column
    is_number = pa.types.is_floating(values.type) or pa.types.is_integer(values.type)
    if (shape or expected) and not (shape and is_number):
        raise ValueError(f'column "{name}" holds {column.type}; expected lists of numbers')
    flat = values.to_numpy(zero_copy_only=False)
    return flat.astype(np.float64, copy=False).reshape(len(column), *shape) if is_number else flat


def headings(m: Model, what: str) -> list[str]:
    """The columns of a part of a state, one for each of its numbers."""
    names = m.coordinate_names if what == "q" else m.velocity_names if what in OF_VELOCITIES else []
    return [f"{what} {name}" for name in names]


def columns_of(m: Model, what: str, there: Sequence[str]) -> list[str]:
    """The column of a part of a state, or its columns as `axode simulate` writes them. ValueError if one is missing."""
    wanted = [what] if what in there else headings(m, what)
    missing = [name for name in wanted if name not in there]
    if len(missing) == len(wanted):
        others = f', nor columns "{wanted[0]}", ..., "{wanted[-1]}"' if len(wanted) > 1 else ""
        raise ValueError(f'there is no column "{what}"{others}; there are {", ".join(there) or "none"}')
    if missing:
        raise ValueError(f'there is no column "{missing[0]}"')
    return wanted


def as_column(name: str, x: Any, rows: int, dtype: str = "float64") -> Any:
    """Numbers (N,) as they are, (N, k) as lists of k, and (N, k, l, ...) as tensors (lists to other readers)."""
    array = np.asarray(x)
    if array.shape[:1] != (rows,):
        raise ValueError(f'"{name}" has shape {array.shape}; expected ({rows}, ...), an entry for each state')
    if np.issubdtype(array.dtype, np.floating):
        array = array.astype(dtype, copy=False)
    if array.ndim == 1:
        return pa.array(array)
    shape = array.shape[1:]
    if 0 in shape:
        raise ValueError(f'"{name}" has no numbers: its shape is {shape} for each state')
    lists = pa.FixedSizeListArray.from_arrays(pa.array(array.ravel()), int(np.prod(shape)))
    if array.ndim == 2:
        return lists
    return pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(lists.type.value_type, shape), lists)


def named_results(result: Any, name: str) -> dict[str, Any]:
    """Arrays by name: the keys of a dict, or fields and entries of tuples, appended to the name of the function."""
    if isinstance(result, Mapping):
        return {str(key): value for key, value in result.items()}
    if isinstance(result, tuple):
        return {f"{name}.{field}": x for field, x in zip(getattr(result, "_fields", range(len(result))), result)}
    return {name: result}


# ---------------------------------------------------------------------------------------- functions of states


def functions() -> list[str]:
    """The names of the functions of this package that take many states."""
    there = {name: getattr(axode, name) for name in axode.__all__}
    parameters = {name: list(inspect.signature(function).parameters) for name, function in there.items()
                  if callable(function) and not inspect.isclass(function)}
    return [name for name, names in parameters.items() if names[:2] == ["m", "q"] and "threads" in names]


def _known_name(function: str | Callable[..., Any]) -> str | None:
    """The name of a function of this package; KeyError with the nearest one for other names."""
    known = functions()
    if not isinstance(function, str):
        return next((name for name in known if getattr(axode, name) is function), None)
    if function in known:
        return function
    near = [name for name in (name_here(function), *difflib.get_close_matches(function, known, n=1)) if name in known]
    raise KeyError(f'there is no function of states "{function}"' + (f'; did you mean "{near[0]}"?' if near else ""))


class TableFunction:
    """A function of states as a function of tables of pyarrow: it maps a table of states to a table of results, row
    by row.

    `map_states` calls it, and `ray.data.Dataset.map_batches` takes it with batch_format="pyarrow". The arguments are
    those of `map_states`. A table with a state that cannot be computed is a ValueError or a StatesError, which names
    the row.

    >>> import pyarrow as pa
    >>> torques = axode.distributed.TableFunction(arm, "gravity_torques")
    >>> torques(pa.table({"t": [0.0, 0.1], "q": arm.random(n=2, seed=1).tolist()})).column_names
    ['t', 'gravity_torques']
    """

    def __init__(self, m: Model, function: str | Callable[..., Any], arguments: Mapping[str, Any] | None = None, *,
                 keep: Sequence[str] | Literal["all"] | None = None, dtype: Literal["float64", "float32"] = "float64",
                 faulty: Literal["refuse", "nan"] = "refuse"):
        for name, word, words in (("dtype", dtype, ("float64", "float32")), ("faulty", faulty, ("refuse", "nan"))):
            if word not in words:
                raise ValueError(f"{name} is {word!r}; expected one of {', '.join(map(repr, words))}")
        if not isinstance(m, Model):
            raise TypeError(f"m is {m!r:.60}; expected an axode.Model")
        if m.nq == 0:
            raise ValueError(f'model "{m.name}" has no coordinates; there are no states of it')
        self.m, self.dtype, self.faulty, self.arguments = m, dtype, faulty, dict(arguments or {})
        self.known = _known_name(function)
        self.function = self.known or function
        self.name = self.known or str(getattr(function, "__name__", "result"))
        self.takes = self._parameters()
        self.keep = keep if keep is None or keep == "all" else list(keep)
        if self.known and set(self.takes) <= OF_VELOCITIES | {"q"} and not self.known.startswith("rollout"):
            # Refuses wrong arguments.
            self._call({what: np.empty((0, len(headings(m, what)))) for what in self.takes})

    @property
    def _callee(self) -> Any:
        return getattr(axode, self.known) if self.known else self.function

    def _call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        return named_results(self._callee(self.m, **given, **self.arguments), RESULT_NAMES.get(self.name, self.name))

    def _parameters(self) -> list[str]:
        """The parameters that a column is for: those without a default and without an argument."""
        parameters = [x for x in inspect.signature(self._callee).parameters.values() if x.name != "threads"][1:]
        takes = [x.name for x in parameters if x.default is x.empty and x.name not in self.arguments
                 and x.kind in (x.POSITIONAL_OR_KEYWORD, x.KEYWORD_ONLY)]
        if wrong := signatures.wrong_names(self.name, parameters, [], {**self.arguments, **dict.fromkeys(takes)}):
            raise TypeError(wrong)
        if self.known and (missing := [name for name in takes if name not in OF_STATES]):
            raise TypeError(f"{self.name} needs an argument {missing[0]!r}")
        return takes

    def columns(self, there: Sequence[str]) -> tuple[list[str], list[str]]:
        """The columns that the function takes, and those that are carried over. ValueError if one is missing."""
        taken = [name for what in self.takes for name in columns_of(self.m, what, there)]
        if self.keep is None:
            parts = {*OF_STATES, *(name for what in OF_STATES for name in headings(self.m, what))}
            return taken, [name for name in there if name not in parts]
        kept = list(there if self.keep == "all" else self.keep)
        for name in kept:
            if name not in there:
                raise ValueError(f'there is no column "{name}" to keep; there are {", ".join(there)}')
        return taken, kept

    def __call__(self, table: Any) -> Any:
        try:
            return pa.concat_tables([piece for piece, _ in self.pieces(table)])
        except RowError as error:
            raise error.located() from error.__cause__

    def pieces(self, table: Any) -> Iterator[tuple[Any, int]]:
        """Yields consecutive tables of results of limited size, each with its number of states without a result."""
        kept = self.columns(table.column_names)[1]
        given, bad = self._states(table)
        step = max(len(bad), 1)
        if self.known and step > 1:
            one, _ = self._results(given, bad, slice(1))
            step = max(1, min(step, BYTES // max(sum(np.asarray(x).nbytes for x in one.values()), 1)))
        for start in range(0, max(len(bad), 1), step):
            results, without = self._results(given, bad, slice(start, start + step))
            columns = {name: table.column(name).slice(start, step) for name in kept}
            for name, x in results.items():
                if name in columns:
                    raise ValueError(f'the result "{name}" and a column that is kept have the same name; '
                                     "choose the columns by `keep`")
                columns[name] = as_column(name, x, len(without), self.dtype)
            yield pa.table(columns), int(without.sum())

    def _states(self, table: Any) -> tuple[dict[str, Array], Array]:
        """The arguments of the function, and which rows have a null, NaN or infinity."""
        given, bad = {}, np.zeros(table.num_rows, dtype=bool)
        for what in self.takes:
            names, expected = columns_of(self.m, what, table.column_names), len(headings(self.m, what)) or None
            if names == [what]:
                x = numbers(table.column(what), what, expected, f'model "{self.m.name}"')
            else:
                columns = [numbers(table.column(name), name) for name in names]
                for name, x in zip(names, columns):
                    if x.ndim != 1 or x.dtype != np.float64:
                        raise ValueError(f'column "{name}" holds {table.column(name).type}; expected numbers')
                x = np.stack(columns, axis=1)
            wrong = np.any([np.asarray(table.column(name).is_null()) for name in names], axis=0)
            if x.dtype == np.float64:
                wrong |= ~np.isfinite(x).all(axis=tuple(range(1, x.ndim)))
            if wrong.any() and self.faulty == "refuse":
                row = int(np.argmax(wrong))
                entries = np.ravel(np.array([table.column(name)[row].as_py() for name in names], dtype=object))
                value = next(y for y in entries if y is None or not np.isfinite(y))
                raise RowError(row, f"{what} has {'null' if value is None else value} in it; expected finite numbers")
            given[what], bad = x, bad | wrong
        return given, bad

    def _results(self, given: dict[str, Array], bad: Array, rows: slice) -> tuple[dict[str, Any], Array]:
        """Results of some rows, and which of them have none: these are NaN, or the first of them is a RowError."""
        without = bad[rows].copy()
        good = np.flatnonzero(~without)
        first = rows.start or 0
        try:
            some = self._call({name: x[rows][good] if without.any() else x[rows] for name, x in given.items()})
        except StatesError as error:
            if self.faulty == "refuse":
                why = re.sub(r"^states? [^:]*: ", "", str(error))
                raise RowError(first + error.states[0], why, error) from error
            bad[first + good[error.states]] = True
            return self._results(given, bad, rows)
        except ValueError as error:
            if self.known and (at := re.match(r"state (\d+): ", str(error))):
                raise RowError(first + int(good[int(at[1])]), str(error)[at.end():]) from error
            raise
        if not without.any():
            return some, without
        results = {name: np.full((len(without), *np.shape(x)[1:]), np.nan) for name, x in some.items()}
        for name, x in some.items():
            results[name][good] = x
        return results, without


# --------------------------------------------------------------------------------------------- files by parts


class Slice(NamedTuple):
    """Rows of a row group of a file."""

    file: str
    group: int
    start: int  # index within the row group
    first: int  # index in the file
    rows: int


def files_in(states: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[str]:
    """Parquet files by their names: one, a list, or all in a folder and below it in the order of their paths."""
    if not isinstance(states, os.PathLike) and not states:
        expected = "the name of a file or folder" if isinstance(states, str) else "at least one file"
        raise ValueError(f"states is empty; expected {expected}")
    if not isinstance(states, (str, os.PathLike)):
        return [file for one in states for file in files_in(one)]
    path = Path(states)
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    below = sorted(path.rglob("*.parquet")) if path.is_dir() else [path]
    found = [str(file) for file in below
             if not any(part.startswith((".", "_")) for part in file.relative_to(path).parts)]
    if not found:
        raise FileNotFoundError(f"{path}: there are no files *.parquet in this folder")
    return found


@contextlib.contextmanager
def _unreadable_is_named(file: str) -> Iterator[None]:
    try:
        yield
    except (FileNotFoundError, PermissionError):
        raise
    except (pa.ArrowException, OSError, StopIteration) as error:
        why = " ".join(str(error).split()) or "it is cut short"
        raise ValueError(f"{file}: it cannot be read as Parquet: {why}") from error


def slices(file: str, rows_per_part: int) -> tuple[Any, list[Slice]]:
    """Returns the schema of a file and the row ranges of its parts."""
    with _unreadable_is_named(file):
        opened = pq.ParquetFile(file)
    parts, first = [], 0
    for group in range(opened.num_row_groups):
        rows = opened.metadata.row_group(group).num_rows
        parts += [Slice(file, group, start, first + start, min(rows_per_part, rows - start))
                  for start in range(0, rows, rows_per_part)]
        first += rows
    return opened.schema_arrow, parts


#: The row group that this thread reads: its key, its remaining batches, and the number of their first row.
reading = threading.local()


def read(part: Slice, columns: list[str], rows_per_part: int) -> Any:
    """The rows of a part. A row group whose parts a thread reads in their order is read once."""
    with _unreadable_is_named(part.file):
        key = (part.file, os.stat(part.file).st_mtime_ns, part.group, columns, rows_per_part)
        if vars(reading).pop("key", None) != key or reading.row > part.start:  # without a key after an error
            opened = pq.ParquetFile(part.file, buffer_size=1 << 22)
            groups = [part.group] if part.rows else []
            reading.batches, reading.row = opened.iter_batches(rows_per_part, groups, columns), 0
            reading.empty = opened.schema_arrow.empty_table()
        found = []
        while reading.row < part.start + part.rows:
            batch = next(reading.batches)  # does not cross the end of a part
            if reading.row >= part.start:
                found.append(pa.Table.from_batches([batch]))
            reading.row += batch.num_rows
        reading.key = key
        return pa.concat_tables([table.select(columns) for table in (reading.empty, *found)])
