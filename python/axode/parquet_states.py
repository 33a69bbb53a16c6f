"""States in Parquet: columns as arrays, functions of states as functions of tables, and files by parts."""

from __future__ import annotations

import difflib
import inspect
import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

import axode

from ._axode import Model, name_here
from .errors import StatesError

try:
    import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
    import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError("axode.distributed needs pyarrow: pip install pyarrow") from error

__all__: list[str] = []

Array = NDArray[Any]
#: States that are read, computed and written at once, at most.
ROWS = 65536
#: Bytes of results that are computed at once, where one state has fewer.
BYTES = 1 << 26
#: Parameters with a number for each velocity.
OF_VELOCITIES = {"v", "a", "tau", "p", "dq", "dv", "da", "dtau"}
#: Parameters of which every state has its own.
OF_STATES = OF_VELOCITIES | {"q", "w", "V", "Pi", "rates", "directions", "more", "multipliers", "w_q", "w_v"}
#: What a result is called that is itself a part of a state.
RESULT_NAMES = {"inverse_dynamics": "tau", "forward_dynamics": "a"}


class RowError(ValueError):
    """What is wrong with one row of a table."""

    def __init__(self, row: int, why: str):
        super().__init__(row, why)
        self.row = row
        self.why = why


# ------------------------------------------------------------------------------------------------- columns as arrays


def _is_number(kind: Any) -> bool:
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind))


def _is_list(kind: Any) -> bool:
    return bool(pa.types.is_fixed_size_list(kind) or pa.types.is_list(kind) or pa.types.is_large_list(kind))


def _one_length(column: Any, name: str, expected: int | None, meaning: str) -> int:
    """Of the lists of a column, which must be the expected one, or else that of the longest."""
    if pa.types.is_fixed_size_list(column.type):
        lengths = np.array([column.type.list_size])
    else:
        lengths = np.asarray(column.value_lengths().fill_null(-1), dtype=np.int64)
    length = int(lengths.max(initial=0)) if expected is None else expected
    wrong = (lengths >= 0) & (lengths != length)
    if wrong.any():
        row = int(np.argmax(wrong))
        rule = meaning if expected is not None else f"in other rows it has {length}"
        raise RowError(row, f'column "{name}" has {lengths[row]} numbers; {rule}')
    return length


def numbers(column: Any, name: str, expected: int | None = None, meaning: str = "") -> tuple[Array, Array]:
    """What stands in a column, of shape (N, ...), NaN where it is null, and which rows have nulls. What is neither numbers nor
    lists of them comes back as it is, where nothing is expected."""
    column = column.combine_chunks() if isinstance(column, pa.ChunkedArray) else column
    shape: tuple[int, ...] = ()
    if pa.types.is_null(column.type):  # as pandas writes what has no rows, or nothing in any
        column = pa.nulls(len(column), pa.float64() if expected is None else pa.list_(pa.float64()))
    if isinstance(column.type, pa.FixedShapeTensorType):
        shape, column = tuple(column.type.shape), column.storage
    elif _is_list(column.type):
        shape = (_one_length(column, name, expected, meaning),)
    values = column.flatten() if shape else column
    missing = np.asarray(column.is_null(), dtype=bool)
    if not _is_number(values.type) or (expected is not None and not shape):
        if shape or expected is not None:
            raise ValueError(f'column "{name}" holds {column.type}; expected lists of numbers')
        return np.asarray(column.to_numpy(zero_copy_only=False)), missing
    flat = values.to_numpy(zero_copy_only=False).astype(np.float64, copy=False)
    if not missing.any() and not values.null_count:
        return flat.reshape(len(column), *shape), missing
    out = np.full((len(column), *shape), np.nan)
    if shape:
        out[~missing] = flat.reshape(-1, *shape)
        missing[~missing] = np.asarray(values.is_null(), dtype=bool).reshape(-1, int(np.prod(shape))).any(axis=1)
    else:
        out[:] = flat
    return out, missing


def names_of(m: Model, what: str) -> list[str]:
    """Of the numbers of a part of a state; none where it has no such numbers."""
    return m.coordinate_names if what == "q" else m.velocity_names if what in OF_VELOCITIES else []


def headings(m: Model, what: str) -> list[str]:
    """The columns that a part of a state has where each coordinate has a column of its own, as `axode simulate` writes them."""
    return [f"{what} {name}" for name in names_of(m, what)]


def columns_of(m: Model, what: str, there: Sequence[str]) -> list[str]:
    """The column of a part of a state, or its columns, of those that are there. ValueError where there are none."""
    if what in there:
        return [what]
    wanted = headings(m, what)
    if not any(name in there for name in wanted):
        others = f', nor columns "{wanted[0]}", ..., "{wanted[-1]}"' if len(wanted) > 1 else ""
        raise ValueError(f'there is no column "{what}"{others}; there are {", ".join(there) or "none"}')
    for name in wanted:
        if name not in there:
            raise ValueError(f'there is no column "{name}"')
    return wanted


def part_of_state(table: Any, m: Model, what: str) -> tuple[Array, Array]:
    """The numbers of all states in a table, and which rows have nulls."""
    names = columns_of(m, what, table.column_names)
    if names == [what]:
        expected = len(names_of(m, what)) if what in OF_VELOCITIES | {"q"} else None
        return numbers(table.column(what), what, expected, f'model "{m.name}" takes {expected}')
    columns = [numbers(table.column(name), name) for name in names]
    for name, (x, _) in zip(names, columns):
        if x.ndim != 1 or x.dtype != np.float64:
            raise ValueError(f'column "{name}" holds {table.column(name).type}; expected numbers')
    return np.stack([x for x, _ in columns], axis=1), np.any([missing for _, missing in columns], axis=0)


# ------------------------------------------------------------------------------------------------- arrays as columns


def as_column(name: str, x: Any, rows: int, dtype: str) -> Any:
    """Numbers of shape (N,) as they are, (N, k) as lists of k, (N, k, l, ...) as tensors, which are lists to other readers."""
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
    """Arrays under names: keys of a dict as they are, fields and entries of tuples behind that of the function."""
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
    if not isinstance(function, str):
        name = getattr(function, "__name__", "")
        return name if getattr(axode, name, None) is function and name in functions() else None
    known = functions()
    if function in known:
        return function
    near = name_here(function) or next(iter(difflib.get_close_matches(function, known, n=1)), None)
    if near not in known:
        near = None
    raise KeyError(f'there is no function of states "{function}"' + (f'; did you mean "{near}"?' if near else ""))


class TableFunction:
    """A function of states as one of tables of pyarrow: states in, results out, row by row.

    It is what `map_states` calls, and what `ray.data.Dataset.map_batches` takes with batch_format="pyarrow".
    The arguments are those of `map_states`. A table with a state that cannot be computed is a ValueError or a StatesError, which
    names the row.

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
        of_known_shape = self.known and set(self.takes) <= OF_VELOCITIES | {"q"} and not self.known.startswith("rollout")
        if of_known_shape:  # what is wrong with the arguments shows without states
            self._call({what: np.empty((0, m.nq if what == "q" else m.nv)) for what in self.takes})

    def _parameters(self) -> list[str]:
        """What the function takes of each state: what has no default and is no argument."""
        callee: Any = getattr(axode, self.known) if self.known else self.function
        parameters = list(inspect.signature(callee).parameters.values())[1:]
        names = [x.name for x in parameters]
        for name in self.arguments:
            if name not in names or name == "threads":
                near = difflib.get_close_matches(name, names, n=1)
                raise TypeError(f"{self.name} has no argument {name!r}" + (f"; did you mean {near[0]!r}?" if near else ""))
        takes = [x.name for x in parameters if x.default is inspect.Parameter.empty and x.name not in self.arguments
                 and x.kind in (x.POSITIONAL_OR_KEYWORD, x.KEYWORD_ONLY)]
        if self.known and (missing := [name for name in takes if name not in OF_STATES]):
            raise TypeError(f"{self.name} needs an argument {missing[0]!r}")
        return takes

    def columns(self, there: Sequence[str]) -> tuple[list[str], list[str]]:
        """The columns that are read for the function, and those that are carried over. ValueError where one is missing."""
        taken = [name for what in self.takes for name in columns_of(self.m, what, there)]
        if self.keep == "all":
            return taken, list(there)
        if self.keep is not None:
            for name in self.keep:
                if name not in there:
                    raise ValueError(f'there is no column "{name}" to keep; there are {", ".join(there)}')
            return taken, list(self.keep)
        parts = {*OF_STATES, *(name for what in OF_STATES for name in headings(self.m, what))}
        return taken, [name for name in there if name not in parts]

    def __call__(self, table: Any) -> Any:
        try:
            pieces = list(self.pieces(table))
        except RowError as error:
            raise ValueError(f"row {error.row}: {error.why}") from error
        except StatesError as error:
            raise type(error)(f"row {error.states[0]}: {error}", error.states, error.result) from error
        return pa.concat_tables([piece for piece, _ in pieces])

    def pieces(self, table: Any) -> Iterator[tuple[Any, int]]:
        """Tables of results, one behind the other, of which none is large, and how many states of each have none."""
        kept = self.columns(table.column_names)[1]
        given, bad = self._states(table)
        step = self._at_once(given, bad)
        for start in range(0, max(table.num_rows, 1), step):
            rows = slice(start, start + step)
            try:
                results, without = self._results({name: x[rows] for name, x in given.items()}, bad[rows])
            except StatesError as error:
                error.states[:] = [start + k for k in error.states]
                raise
            except RowError as error:
                raise RowError(start + error.row, error.why) from error
            columns = {name: table.column(name).slice(start, step) for name in kept}
            for name, x in results.items():
                if name in columns:
                    raise ValueError(f'the result "{name}" and a column that is kept have the same name; '
                                     "say with `keep` which columns are kept")
                columns[name] = as_column(name, x, len(bad[rows]), self.dtype)
            yield pa.table(columns), int(without.sum())

    def _states(self, table: Any) -> tuple[dict[str, Array], Array]:
        """What the function is given, and which rows have nulls or NaN. These are of a neutral state at rest."""
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

    def _at_once(self, given: dict[str, Array], bad: Array) -> int:
        """How many states are computed in one call; a function of somebody else is given all."""
        if not self.known or len(bad) <= 1:
            return max(len(bad), 1)
        one, _ = self._results({name: x[:1] for name, x in given.items()}, bad[:1])
        size = sum(np.asarray(x).nbytes for x in one.values())
        return max(1, min(len(bad), BYTES // max(size, 1)))

    def _call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        if self.known:
            result = getattr(axode, self.known)(self.m, **given, **self.arguments)
        else:
            assert callable(self.function)
            result = self.function(self.m, **given, **self.arguments)
        return named_results(result, RESULT_NAMES.get(self.name, self.name))

    def _results(self, given: dict[str, Array], bad: Array) -> tuple[dict[str, Any], Array]:
        """Results of all states, and which have none: their rows are NaN."""
        if self.faulty == "refuse":
            try:
                return self._call(given), bad
            except (StatesError, ValueError) as error:
                if self.known:
                    self._name_row(given, error)
                raise
        good = np.flatnonzero(~bad)
        try:
            some = self._call({name: x[good] for name, x in given.items()})
        except StatesError as error:
            bad = bad.copy()
            bad[good[error.states]] = True
            good = np.flatnonzero(~bad)
            some = self._call({name: x[good] for name, x in given.items()})
        results = {}
        for name, x in some.items():
            results[name] = np.full((len(bad), *np.shape(x)[1:]), np.nan)
            results[name][good] = x
        return results, bad

    def _name_row(self, given: dict[str, Array], error: Exception) -> None:
        """Raises what is wrong with the first state that is refused, in the words for a single state."""
        if isinstance(error, StatesError):
            row = error.states[0]
        else:  # the first k states are refused where k is above its number
            row, end = 0, len(next(iter(given.values())))
            while end - row > 1:
                middle = (row + end) // 2
                try:
                    self._call({name: x[row:middle] for name, x in given.items()})
                    row = middle
                except ValueError:
                    end = middle
        try:
            self._call({name: x[row] for name, x in given.items()})
        except StatesError as one:
            raise type(one)(str(one), [row], one.result) from error
        except ValueError as one:
            raise RowError(row, str(one)) from error


# ------------------------------------------------------------------------------------------------- files by parts


class Slice(NamedTuple):
    """Rows of a row group of a file."""

    file: str
    group: int
    start: int  # within the row group
    first: int  # in the file
    rows: int


def _open(file: str) -> Any:
    try:
        return pq.ParquetFile(file, buffer_size=1 << 22)
    except (pa.ArrowException, OSError) as error:
        if isinstance(error, (FileNotFoundError, PermissionError)):
            raise
        raise _unreadable(file, error) from error


def _unreadable(file: str, error: Exception) -> ValueError:
    return ValueError(f"{file}: it cannot be read as Parquet: {' '.join(str(error).split()) or 'it is cut short'}")


def files_in(states: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]) -> list[str]:
    """Parquet files by their names: one, a list, or all in a folder and below it in the order of their paths."""
    if not isinstance(states, (str, os.PathLike)):
        if not states:
            raise ValueError("states names no file")
        return [file for one in states for file in files_in(one)]
    if not os.fspath(states):
        raise ValueError("states is empty; expected the name of a file or folder")
    path = Path(states)
    if not path.is_dir():
        if not path.exists():
            raise FileNotFoundError(f"{path}: there is no such file or folder")
        return [str(path)]
    found = [file for file in sorted(path.rglob("*.parquet"))
             if not any(part.startswith((".", "_")) for part in file.relative_to(path).parts)]
    if not found:
        raise FileNotFoundError(f"{path}: there are no files *.parquet in this folder")
    return [str(file) for file in found]


class Cursor:
    """Reads a row group from its beginning to its end, not all of it at once."""

    def __init__(self, file: str, group: int, columns: list[str]):
        self.key = (file, group, tuple(columns))
        self.row = 0
        self.batches = _open(file).iter_batches(batch_size=ROWS, row_groups=[group], columns=columns)
        self.rest: Any = None

    def read(self, start: int, rows: int) -> Any:
        taken = []
        while self.row < start + rows:
            if self.rest is None or self.rest.num_rows == 0:
                self.rest = next(self.batches)
            skip = max(0, min(start - self.row, self.rest.num_rows))
            here = self.rest.slice(skip, start + rows - self.row - skip)
            if here.num_rows:
                taken.append(here)
            self.row += skip + here.num_rows
            self.rest = self.rest.slice(skip + here.num_rows)
        return pa.Table.from_batches(taken)


#: Where this thread reads.
_reading = threading.local()


def read(part: Slice, columns: list[str]) -> Any:
    """The rows of a part. Parts of one row group that are read in their order are read once."""
    cursor = getattr(_reading, "cursor", None)
    key = (part.file, part.group, tuple(columns))
    try:
        if part.rows == 0:
            return _open(part.file).schema_arrow.empty_table().select(columns)
        if cursor is None or cursor.key != key or cursor.row > part.start:
            cursor = _reading.cursor = Cursor(part.file, part.group, columns)
        return cursor.read(part.start, part.rows).select(columns)
    except (pa.ArrowException, OSError, StopIteration) as error:
        stop_reading()
        raise _unreadable(part.file, error) from error


def stop_reading() -> None:
    _reading.cursor = None


def slices(file: str, rows_per_part: int, use: Callable[[Any], object]) -> list[Slice]:
    """The parts of a file, whose schema is shown to `use`."""
    opened = _open(file)
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
