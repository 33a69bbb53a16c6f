"""States in Parquet: columns as arrays, functions of states as functions of tables, and files by parts."""

from __future__ import annotations

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

try:
    import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import pyarrow.compute as pc  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError("axode.distributed needs pyarrow: pip install pyarrow") from error

__all__: list[str] = []

Array = NDArray[Any]
#: How many states are read, computed and written at once, at most.
ROWS = 65536
#: How many bytes of results are computed at once, unless one state has more.
BYTES = 1 << 26
#: Parameters with a number for each velocity.
OF_VELOCITIES = {"v", "a", "tau", "p", "dq", "dv", "da", "dtau"}
#: Parameters of which every state has its own.
OF_STATES = OF_VELOCITIES | {"q", "w", "V", "Pi", "rates", "directions", "more", "multipliers", "w_q", "w_v"}
#: Names of results that are themselves a part of a state.
RESULT_NAMES = {"inverse_dynamics": "tau", "forward_dynamics": "a"}


class RowError(Exception):
    """A row of a table that is refused, and why."""

    def __init__(self, row: int, why: str, cause: StatesError | None = None):
        super().__init__(row, why, cause)
        self.row, self.why, self.cause = row, why, cause

    def located(self, where: str, first: int = 0) -> Exception:
        """The error to raise, which names the row, counted from the first row of the table."""
        row = first + self.row
        text = f"{where}row {row}: {self.why}"
        return ValueError(text) if self.cause is None else type(self.cause)(text, [row], self.cause.result)


# ------------------------------------------------------------------------------------------------- columns and arrays


def numbers(column: Any, name: str, expected: int | None = None, meaning: str = "") -> tuple[Array, Array]:
    """The numbers in a column, (N, ...), NaN where it is null, and which rows have nulls. Unless lists of a length are
    expected, a column without numbers is returned as it is."""
    column = column.combine_chunks() if isinstance(column, pa.ChunkedArray) else column
    shape: tuple[int, ...] = ()
    if pa.types.is_null(column.type):  # pandas writes columns without rows or values so
        column = pa.nulls(len(column), pa.float64() if expected is None else pa.list_(pa.float64()))
    if isinstance(column.type, pa.FixedShapeTensorType):
        shape, column = tuple(column.type.shape), column.storage
    elif hasattr(column.type, "value_type") and not pa.types.is_dictionary(column.type):
        lengths = np.asarray(pc.list_value_length(column).fill_null(-1), dtype=np.int64)
        longest = column.type.list_size if pa.types.is_fixed_size_list(column.type) else int(lengths.max(initial=0))
        shape = (longest if expected is None else expected,)
        if (wrong := (lengths >= 0) & (lengths != shape[0])).any():
            row = int(np.argmax(wrong))
            rule = meaning if expected is not None else f"in other rows it has {shape[0]}"
            raise RowError(row, f'column "{name}" has {lengths[row]} numbers; {rule}')
    values = column.flatten() if shape else column
    missing = np.asarray(column.is_null(), dtype=bool)
    is_number = pa.types.is_floating(values.type) or pa.types.is_integer(values.type)
    if not is_number or (expected is not None and not shape):
        if shape or expected is not None:
            raise ValueError(f'column "{name}" holds {column.type}; expected lists of numbers')
        return np.asarray(column.to_numpy(zero_copy_only=False)), missing
    flat = values.to_numpy(zero_copy_only=False).astype(np.float64, copy=False)
    if not missing.any() and not values.null_count:
        return flat.reshape(len(column), *shape), missing
    if not shape:
        return flat, missing
    out = np.full((len(column), *shape), np.nan)
    out[~missing] = flat.reshape(-1, *shape)
    missing[~missing] = np.asarray(values.is_null(), dtype=bool).reshape(-1, int(np.prod(shape))).any(axis=1)
    return out, missing


def columns_of(m: Model, what: str, there: Sequence[str]) -> list[str]:
    """The column of a part of a state, or its columns as `axode simulate` writes them. ValueError if there are none."""
    if what in there:
        return [what]
    wanted = headings(m, what)
    missing = [name for name in wanted if name not in there]
    if len(missing) == len(wanted):
        others = f', nor columns "{wanted[0]}", ..., "{wanted[-1]}"' if len(wanted) > 1 else ""
        raise ValueError(f'there is no column "{what}"{others}; there are {", ".join(there) or "none"}')
    if missing:
        raise ValueError(f'there is no column "{missing[0]}"')
    return wanted


def headings(m: Model, what: str) -> list[str]:
    """The columns of a part of a state, one for each of its numbers."""
    names = m.coordinate_names if what == "q" else m.velocity_names if what in OF_VELOCITIES else []
    return [f"{what} {name}" for name in names]


def part_of_state(table: Any, m: Model, what: str) -> tuple[Array, Array]:
    """The numbers of all states in a table, and which rows have nulls."""
    names = columns_of(m, what, table.column_names)
    if names == [what]:
        expected = len(headings(m, what)) or None
        return numbers(table.column(what), what, expected, f'model "{m.name}" takes {expected}')
    columns = [numbers(table.column(name), name) for name in names]
    for name, (x, _) in zip(names, columns):
        if x.ndim != 1 or x.dtype != np.float64:
            raise ValueError(f'column "{name}" holds {table.column(name).type}; expected numbers')
    return np.stack([x for x, _ in columns], axis=1), np.any([missing for _, missing in columns], axis=0)


def as_column(name: str, x: Any, rows: int, dtype: str = "float64") -> Any:
    """Numbers (N,) as they are, (N, k) as lists of k, and (N, k, l, ...) as tensors, which are lists to other
    readers."""
    array = np.asarray(x)
    if array.shape[:1] != (rows,):
        raise ValueError(f'"{name}" has shape {array.shape}; expected ({rows}, ...), an entry for each state')
    if np.issubdtype(array.dtype, np.floating):
        array = array.astype(dtype, copy=False)
    if array.ndim == 1:
        return pa.array(array)
    if 0 in array.shape[1:]:
        raise ValueError(f'"{name}" has no numbers: its shape is {array.shape[1:]} for each state')
    width = int(np.prod(array.shape[1:]))
    lists = pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(array).reshape(-1)), width)
    if array.ndim == 2:
        return lists
    return pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(lists.type.value_type, array.shape[1:]), lists)


def named_results(result: Any, name: str) -> dict[str, Any]:
    """Arrays by name: the keys of a dict, or fields and entries of tuples, appended to the name of the function."""
    if isinstance(result, Mapping):
        return {str(key): value for key, value in result.items()}
    if isinstance(result, tuple):
        fields = getattr(result, "_fields", range(len(result)))
        return {f"{name}.{field}": value for field, value in zip(fields, result)}
    return {name: result}


# ------------------------------------------------------------------------------------------------- functions of states


def functions() -> list[str]:
    """The names of the functions of this package that take many states."""
    found = []
    for name in axode.__all__:
        function = getattr(axode, name)
        if callable(function) and not inspect.isclass(function):
            parameters = list(inspect.signature(function).parameters)
            if parameters[:2] == ["m", "q"] and "threads" in parameters:
                found.append(name)
    return found


def _known_name(function: str | Callable[..., Any]) -> str | None:
    """The name of a function of this package; KeyError with the nearest one for other names."""
    known = functions()
    if not isinstance(function, str):
        name = getattr(function, "__name__", "")
        return name if name in known and getattr(axode, name) is function else None
    if function in known:
        return function
    near = [name for name in (name_here(function), *difflib.get_close_matches(function, known, n=1)) if name in known]
    raise KeyError(f'there is no function of states "{function}"' + (f'; did you mean "{near[0]}"?' if near else ""))


class TableFunction:
    """A function of states as one of tables of pyarrow: states in, results out, row by row.

    It is what `map_states` calls, and what `ray.data.Dataset.map_batches` takes with batch_format="pyarrow".
    The arguments are those of `map_states`. A table with a state that cannot be computed is a ValueError or a
    StatesError, which names the row.

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
        self.m, self.dtype, self.faulty = m, dtype, faulty
        self.known = _known_name(function)
        self.function = self.known or function
        self.name = self.known or str(getattr(function, "__name__", "result"))
        self.arguments = dict(arguments or {})
        self.takes = self._parameters()
        self.keep = keep if keep is None or keep == "all" else list(keep)
        if self.known and set(self.takes) <= OF_VELOCITIES | {"q"} and not self.known.startswith("rollout"):
            self._call({what: np.empty((0, len(headings(m, what)))) for what in self.takes})  # refuses wrong arguments

    def _parameters(self) -> list[str]:
        """The parameters that a column is for: those without a default and without an argument."""
        callee: Any = getattr(axode, self.known) if self.known else self.function
        parameters = list(inspect.signature(callee).parameters.values())[1:]
        names = [x.name for x in parameters]
        for name in self.arguments:
            if name not in names or name == "threads":
                near = difflib.get_close_matches(name, names, n=1)
                raise TypeError(f"{self.name} has no argument {name!r}"
                                + (f"; did you mean {near[0]!r}?" if near else ""))
        takes = [x.name for x in parameters if x.default is x.empty and x.name not in self.arguments
                 and x.kind in (x.POSITIONAL_OR_KEYWORD, x.KEYWORD_ONLY)]
        if self.known and (missing := [name for name in takes if name not in OF_STATES]):
            raise TypeError(f"{self.name} needs an argument {missing[0]!r}")
        return takes

    def columns(self, there: Sequence[str]) -> tuple[list[str], list[str]]:
        """The columns that are read for the function, and those that are carried over. ValueError if one is missing."""
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
            raise error.located("") from error.cause

    def pieces(self, table: Any) -> Iterator[tuple[Any, int]]:
        """Yields consecutive tables of results of limited size, each with its number of states without a result."""
        kept = self.columns(table.column_names)[1]
        given, bad = self._states(table)
        step = max(len(bad), 1)
        if self.known and len(bad) > 1:
            one, _ = self._results({name: x[:1] for name, x in given.items()}, bad[:1], 0)
            step = max(1, min(step, BYTES // max(sum(np.asarray(x).nbytes for x in one.values()), 1)))
        for start in range(0, max(table.num_rows, 1), step):
            rows = slice(start, start + step)
            results, without = self._results({name: x[rows] for name, x in given.items()}, bad[rows], start)
            columns = {name: table.column(name).slice(start, step) for name in kept}
            for name, x in results.items():
                if name in columns:
                    raise ValueError(f'the result "{name}" and a column that is kept have the same name; '
                                     "choose the columns by `keep`")
                columns[name] = as_column(name, x, len(bad[rows]), self.dtype)
            yield pa.table(columns), int(without.sum())

    def _states(self, table: Any) -> tuple[dict[str, Array], Array]:
        """The numbers that the function is given, and which rows have nulls or NaN: these become a neutral state at
        rest."""
        given, bad = {}, np.zeros(table.num_rows, dtype=bool)
        for what in self.takes:
            x, missing = part_of_state(table, self.m, what)
            wrong = missing.copy()
            if x.dtype == np.float64:
                wrong |= ~np.isfinite(x.reshape(len(x), int(np.prod(x.shape[1:])))).all(axis=1)
            if wrong.any() and self.faulty == "refuse":
                row = int(np.argmax(wrong))
                value = "null" if missing[row] else next(str(y) for y in np.ravel(x[row]) if not np.isfinite(y))
                raise RowError(row, f"{what} has {value} in it; expected finite numbers")
            if wrong.any():
                x = np.where(wrong.reshape(-1, *[1] * (x.ndim - 1)), self.m.neutral() if what == "q" else 0.0, x)
            given[what], bad = x, bad | wrong
        return given, bad

    def _call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        function: Any = getattr(axode, self.known) if self.known else self.function
        return named_results(function(self.m, **given, **self.arguments), RESULT_NAMES.get(self.name, self.name))

    def _results(self, given: dict[str, Array], bad: Array, first: int) -> tuple[dict[str, Any], Array]:
        """Results of all states, and which have none: their rows are NaN, or the first of them is a RowError."""
        good = np.flatnonzero(~bad)
        try:
            some = self._call({name: x[good] for name, x in given.items()} if bad.any() else given)
        except StatesError as error:
            if self.faulty == "refuse":
                raise RowError(first + error.states[0], re.sub(r"^states? [^:]*: ", "", str(error)), error) from error
            bad = bad.copy()
            bad[good[error.states]] = True
            return self._results(given, bad, first)
        except ValueError as error:
            if self.known and (at := re.match(r"state (\d+): ", str(error))):
                raise RowError(first + int(good[int(at[1])]), str(error)[at.end():]) from error
            raise
        if not bad.any():
            return some, bad
        results = {name: np.full((len(bad), *np.shape(x)[1:]), np.nan) for name, x in some.items()}
        for name, x in some.items():
            results[name][good] = x
        return results, bad


# ------------------------------------------------------------------------------------------------- files by parts


class Slice(NamedTuple):
    """Rows of a row group of a file."""

    file: str
    group: int
    start: int  # within the row group
    first: int  # in the file
    rows: int


def _open(file: str) -> Any:
    return pq.ParquetFile(file, buffer_size=1 << 22)


def unreadable(file: str, error: Exception) -> Exception:
    if isinstance(error, (FileNotFoundError, PermissionError)):
        return error
    return ValueError(f"{file}: it cannot be read as Parquet: {' '.join(str(error).split()) or 'it is cut short'}")


def files_in(states: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[str]:
    """Parquet files by their names: one, a list, or all in a folder and below it in the order of their paths."""
    if not isinstance(states, (str, os.PathLike)):
        if not states:
            raise ValueError("states is empty; expected at least one file")
        return [file for one in states for file in files_in(one)]
    if not os.fspath(states):
        raise ValueError("states is empty; expected the name of a file or folder")
    path = Path(states)
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file or folder")
    found = [path] if not path.is_dir() else [
        file for file in sorted(path.rglob("*.parquet"))
        if not any(part.startswith((".", "_")) for part in file.relative_to(path).parts)]
    if not found:
        raise FileNotFoundError(f"{path}: there are no files *.parquet in this folder")
    return [str(file) for file in found]


#: The row group that this thread reads: its key, the batches to come, the rows that were read last, and the number of
#  the first.
_reading = threading.local()


def read(part: Slice, columns: list[str]) -> Any:
    """The rows of a part. Parts of one row group that a thread reads in their order are read once."""
    key = (part.file, part.group, tuple(columns))
    try:
        if getattr(_reading, "key", None) != key or _reading.row > part.start:
            opened = _open(part.file)
            _reading.table, _reading.row = opened.schema_arrow.empty_table().select(columns), 0
            groups = [part.group] if part.rows else []
            _reading.batches = opened.iter_batches(batch_size=ROWS, row_groups=groups, columns=columns)
            _reading.key = key
        while _reading.row + _reading.table.num_rows < part.start + part.rows:
            skip = min(part.start - _reading.row, _reading.table.num_rows)
            following = pa.Table.from_batches([next(_reading.batches)]).select(columns)
            _reading.table = pa.concat_tables([_reading.table.slice(skip), following])
            _reading.row += skip
        return _reading.table.slice(part.start - _reading.row, part.rows)
    except (pa.ArrowException, OSError, StopIteration) as error:
        stop_reading()
        raise unreadable(part.file, error) from error


def stop_reading() -> None:
    vars(_reading).clear()


def slices(file: str, rows_per_part: int, use: Callable[[Any], object]) -> list[Slice]:
    """The parts of a file, whose schema is shown to `use`."""
    try:
        opened = _open(file)
    except (pa.ArrowException, OSError) as error:
        raise unreadable(file, error) from error
    try:
        use(opened.schema_arrow)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error
    parts, first = [], 0
    for group in range(opened.num_row_groups):
        rows = opened.metadata.row_group(group).num_rows
        parts += [Slice(file, group, start, first + start, min(rows_per_part, rows - start))
                  for start in range(0, rows, rows_per_part)]
        first += rows
    return parts
