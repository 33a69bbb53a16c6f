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

#: Parameters with a number for each velocity.
OF_VELOCITIES = {"v", "a", "tau", "p", "dq", "dv", "da", "dtau"}
#: Parameters that have a value for each state.
OF_STATES = OF_VELOCITIES | {"q", "w", "V", "Pi", "rates", "directions", "more", "multipliers", "w_q", "w_v"}


class RowError(ValueError):
    """A row is refused: its number, why, and the StatesError that refuses it, if there is one; once the row is located,
    the message alone."""


def numbers(column: Any, name: str, width: int | None = None, taker: str = "") -> Any:
    """The numbers in a column of a table, (N, ...), NaN where it is null: lists of `width` numbers, which the `taker`
    expects, or single numbers if the width is 0. Without a width, a column without numbers is returned as it is."""
    column = column.combine_chunks()
    N, shape = len(column), tuple[int, ...]()
    if pa.types.is_null(kind := column.type):  # pandas writes columns without rows or values so
        column = column.cast(pa.list_(pa.float64()) if width else pa.float64())
    if isinstance(kind, pa.FixedShapeTensorType):
        shape, column = tuple(kind.shape), column.storage
    elif hasattr(column.type, "value_type") and not pa.types.is_dictionary(kind):
        lengths = np.asarray(pc.list_value_length(column).fill_null(-1))
        shape = (width or getattr(kind, "list_size", lengths.max(initial=0)),)
        if (wrong := (lengths >= 0) & (lengths != shape[0])).any():
            row, rule = int(np.argmax(wrong)), f"{taker} takes" if width else "in other rows it has"
            raise RowError(row, f'column "{name}" has {lengths[row]} numbers; {rule} {shape[0]}')
    if shape:
        nulls = pa.scalar([None] * int(np.prod(shape)), column.type)
        column = pc.list_flatten(pc.coalesce(column, nulls) if column.null_count else column)
    is_number = pa.types.is_floating(column.type) or pa.types.is_integer(column.type)
    if width is not None and not (is_number and bool(shape) == bool(width)):
        raise ValueError(f'column "{name}" holds {kind}; expected {"lists of " if width else ""}numbers')
    flat = column.to_numpy(zero_copy_only=False)
    return flat.astype(np.float64, copy=False).reshape(N, *shape) if is_number else flat


def headings(m: Model, what: str) -> list[str]:
    """The columns of a part of a state, one for each of its numbers."""
    names = m.coordinate_names if what == "q" else m.velocity_names if what in OF_VELOCITIES else []
    return [f"{what} {name}" for name in names]


def as_column(name: str, x: Any, rows: int, dtype: str = "float64") -> Any:
    """Numbers (N,) as they are, (N, k) as lists of k, and (N, k, l, ...) as tensors (lists to other readers)."""
    array = np.asarray(x)
    shape = array.shape[1:]
    if array.shape[:1] != (rows,):
        raise ValueError(f'"{name}" has shape {array.shape}; expected ({rows}, ...), an entry for each state')
    if 0 in shape:
        raise ValueError(f'"{name}" has no numbers: its shape is {shape} for each state')
    values = pa.array(array.ravel().astype(dtype, copy=False) if array.dtype.kind == "f" else array.ravel())
    lists = pa.FixedSizeListArray.from_arrays(values, int(np.prod(shape))) if shape else values
    return lists if len(shape) < 2 else pa.ExtensionArray.from_storage(pa.fixed_shape_tensor(values.type, shape), lists)


def named_results(result: Any, name: str) -> dict[str, Any]:
    """Arrays by name: the keys of a dict, or fields and entries of tuples, appended to the name of the function."""
    if isinstance(result, Mapping):
        return {str(key): value for key, value in result.items()}
    if isinstance(result, tuple):
        return {f"{name}.{field}": x for field, x in zip(getattr(result, "_fields", range(len(result))), result)}
    return {name: result}


def functions() -> list[str]:
    """The names of the functions of this package that take many states."""
    there = {name: getattr(axode, name) for name in axode.__all__}
    takes = {name: list(inspect.signature(function).parameters) for name, function in there.items()
             if callable(function) and not inspect.isclass(function)}
    return [name for name, names in takes.items() if names[:2] == ["m", "q"] and "threads" in names]


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
        self.keep = keep if keep is None or keep == "all" else list(keep)
        known = functions()
        if isinstance(function, str) and function not in known:
            near = [name for name in (name_here(function), *difflib.get_close_matches(function, known)) if name in known]
            raise KeyError(f'there is no function of states "{function}"'
                           + (f'; did you mean "{near[0]}"?' if near else ""))
        self.known = next((name for name in known if function in (name, getattr(axode, name))), None)
        self.function = self.known or function
        self.name = self.known or str(getattr(function, "__name__", "result"))
        # A column is for each parameter without a default and without an argument.
        parameters = [x for x in inspect.signature(self._callee).parameters.values() if x.name != "threads"][1:]
        self.takes = [x.name for x in parameters if x.default is x.empty and x.name not in self.arguments
                      and x.kind in (x.POSITIONAL_OR_KEYWORD, x.KEYWORD_ONLY)]
        if wrong := signatures.wrong_names(self.name, parameters, [], {**self.arguments, **dict.fromkeys(self.takes)}):
            raise TypeError(wrong)
        if self.known and (missing := [name for name in self.takes if name not in OF_STATES]):
            raise TypeError(f"{self.name} needs an argument {missing[0]!r}")
        #: The bytes of the results of a state, if they are known before they are computed.
        self.row_bytes = 0
        if self.known and OF_VELOCITIES | {"q"} >= {*self.takes} and not self.known.startswith("rollout"):
            none = {what: np.empty((0, len(headings(m, what)))) for what in self.takes}
            self.row_bytes = sum(8 * int(np.prod(np.shape(x)[1:])) for x in self._call(none).values())

    @property
    def _callee(self) -> Any:
        return getattr(axode, self.known) if self.known else self.function

    def _call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        part_of_a_state = {"inverse_dynamics": "tau", "forward_dynamics": "a"}
        return named_results(self._callee(self.m, **given, **self.arguments), part_of_a_state.get(self.name, self.name))

    def columns(self, there: Sequence[str]) -> tuple[dict[str, list[str]], list[str]]:
        """The column of each part of a state that the function takes, or its columns as `axode simulate` writes them;
        and the columns that are carried over. ValueError if one is missing."""
        taken = {what: [what] if what in there else headings(self.m, what) or [what] for what in self.takes}
        for what, names in taken.items():
            if missing := [name for name in names if name not in there]:
                others = f', nor columns "{names[0]}", ..., "{names[-1]}"' if missing == names != [what] else ""
                raise ValueError(f'there is no column "{what if missing == names else missing[0]}"{others}; '
                                 f'there are {", ".join(there) or "none"}')
        parts = {*OF_STATES, *(name for what in OF_STATES for name in headings(self.m, what))}
        kept = [name for name in there if name not in parts] if self.keep is None else self.keep
        kept = list(there if kept == "all" else kept)
        if unknown := [name for name in kept if name not in there]:
            raise ValueError(f'there is no column "{unknown[0]}" to keep; there are {", ".join(there)}')
        return taken, kept

    def __call__(self, table: Any) -> Any:
        return self.results(table)[0]

    def results(self, table: Any, where: str = "", first: int = 0) -> tuple[Any, int]:
        """The results of a table, and how many rows have none. A row that is refused is named by `where` and by its
        number, which is `first` for the first row."""
        taken, kept = self.columns(table.column_names)
        columns = {name: table.column(name) for name in kept}
        try:
            given, bad = self._states(table, taken)
            for name, x in self._filled(given, bad).items():
                if name in columns:
                    raise ValueError(f'the result "{name}" and a column that is kept have the same name; '
                                     "choose the columns by `keep`")
                columns[name] = as_column(name, x, len(bad), self.dtype)
        except RowError as error:
            row, why, *cause = error.args
            text = f"{where}row {first + row}: {why}"
            found = type(cause[0])(text, [first + row], cause[0].result) if cause else RowError(text)
            raise found from error.__cause__
        return pa.table(columns), int(bad.sum())

    def _states(self, table: Any, taken: Mapping[str, list[str]]) -> tuple[dict[str, Any], Any]:
        """The arguments of the function, and which rows have a null, NaN or infinity."""
        given, bad = {}, np.zeros(table.num_rows, dtype=bool)
        for what, names in taken.items():
            width = len(headings(self.m, what)) or None
            if names == [what]:
                x = numbers(table.column(what), what, width, f'model "{self.m.name}"')
            else:
                x = np.stack([numbers(table.column(name), name, 0) for name in names], axis=1)
            given[what] = x
            wrong = np.any([np.asarray(table.column(name).is_null()) for name in names], axis=0)
            if x.dtype == np.float64:
                wrong |= ~np.isfinite(x).all(axis=tuple(range(1, x.ndim)))
            if wrong.any() and self.faulty == "refuse":
                row = int(np.argmax(wrong))
                entries = np.ravel(np.array([table.column(name)[row].as_py() for name in names], dtype=object))
                value = next(y for y in entries if y is None or not np.isfinite(y))
                raise RowError(row, f"{what} has {'null' if value is None else value} in it; expected finite numbers")
            bad |= wrong
        return given, bad

    def _filled(self, given: dict[str, Any], bad: Any) -> dict[str, Any]:
        """The results, NaN for rows that are `bad` or that the function refuses, which become bad."""
        good = np.flatnonzero(~bad)
        try:
            some = self._call({name: x[good] for name, x in given.items()} if bad.any() else given)
        except StatesError as error:
            if self.faulty == "refuse":
                why = re.sub(r"^states? [^:]*: ", "", str(error))
                raise RowError(int(good[error.states[0]]), why, error) from error
            bad[good[error.states]] = True
            return self._filled(given, bad)
        except ValueError as error:
            if self.known and (at := re.match(r"state (\d+): ", str(error))):
                raise RowError(int(good[int(at[1])]), str(error)[at.end():]) from error
            raise
        if bad.any():
            for name, x in some.items():
                some[name] = np.full((len(bad), *np.shape(x)[1:]), np.nan)
                some[name][good] = x
        return some


class Part(NamedTuple):
    """Rows of a row group of a file, or, without a file, points of a sweep."""

    file: str
    first: int  # index in the file
    rows: int
    group: int = 0
    start: int = 0  # index in the row group

    def __str__(self) -> str:
        return f"{f'{self.file}, rows' if self.file else 'points'} {self.first} to {self.first + self.rows - 1}"


def files_in(states: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
             output: str | os.PathLike[str]) -> list[str]:
    """Parquet files by their names: one, a list, or all in a folder and below it in the order of their paths. The output
    may not lie among them: a continued job would read its output as states."""
    names = [states] if isinstance(states, (str, os.PathLike)) else list(states)
    if not names or "" in names:
        expected = "the name of a file or folder" if names else "at least one file"
        raise ValueError(f"states is empty; expected {expected}")
    files: list[str] = []
    for path in map(Path, names):
        if not path.exists():
            raise FileNotFoundError(f"{path}: there is no such file or folder")
        here, there = path.resolve(), Path(output).resolve()
        if here == there or here in there.parents or there in here.parents:
            raise ValueError(f"{output} and the states {path} contain each other; choose another folder")
        below = sorted(path.rglob("*.parquet")) if path.is_dir() else [path]
        found = [str(file) for file in below if not any(word[0] in "._" for word in file.relative_to(path).parts)]
        if not found:
            raise FileNotFoundError(f"{path}: there are no files *.parquet in this folder")
        files += found
    return files


@contextlib.contextmanager
def _unreadable_is_named(file: str) -> Iterator[None]:
    try:
        yield
    except (FileNotFoundError, PermissionError):
        raise
    except (pa.ArrowException, OSError, StopIteration) as error:
        why = " ".join(str(error).split()) or "it is cut short"
        raise ValueError(f"{file}: it cannot be read as Parquet: {why}") from error


def slices(file: str, rows_per_part: int) -> tuple[Any, list[Part]]:
    """Returns the schema of a file and the row ranges of its parts."""
    with _unreadable_is_named(file):
        opened = pq.ParquetFile(file)
    parts, first = [], 0
    for group in range(opened.num_row_groups):
        rows = opened.metadata.row_group(group).num_rows
        parts += [Part(file, first + start, min(rows_per_part, rows - start), group, start)
                  for start in range(0, rows, rows_per_part)]
        first += rows
    return opened.schema_arrow, parts


#: The row group that is being read: for its key, the file, the remaining batches and the number of their first row.
reading: dict[Any, tuple[Any, Iterator[Any], int]] = {}
_one_reads = threading.Lock()


def read(part: Part, columns: Sequence[str], rows_per_part: int) -> Any:
    """The rows of a part. A row group whose parts a process reads in their order is read once."""
    key = (part.file, os.stat(part.file).st_mtime_ns, part.group, *columns, rows_per_part)
    with _one_reads, _unreadable_is_named(part.file):
        opened, batches, row = reading.pop(key, (None, iter(()), 0))
        if opened is None or row > part.start:
            opened, row = pq.ParquetFile(part.file, buffer_size=1 << 22), 0
            batches = opened.iter_batches(rows_per_part, [part.group] if part.rows else [], columns)
        found = [opened.schema_arrow.empty_table()]
        while row < part.start + part.rows:
            batch = next(batches)  # does not cross the end of a part
            found += [pa.Table.from_batches([batch])] if row >= part.start else []
            row += batch.num_rows
        reading.clear()
        reading[key] = opened, batches, row
        return pa.concat_tables([table.select(columns) for table in found])
