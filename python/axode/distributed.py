"""Many states in Parquet files, sweeps and Monte Carlo: in one process on all its cores, or on a Ray cluster by the
same call.

This needs pyarrow (`pip install pyarrow`), a cluster needs Ray (`pip install ray`).
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from .parallel import jobs, parquet_states
from .support import signatures
from ._axode import Model
from .errors import StatesError
from .parallel.jobs import Progress, Written
from .parallel.parquet_states import Part, TableFunction

import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]

__all__ = ["TableFunction", "Written", "grid", "map_states", "sweep"]

#: Parts of a sweep, about.
PARTS = 256
#: The largest number of states in a part, and of bytes of their results.
ROWS, BYTES = 1 << 16, 1 << 26


def map_states(m: Model, function: str | Callable[..., Any],
               states: str | os.PathLike[str] | Sequence[str | os.PathLike[str]], output: str | os.PathLike[str], *,
               arguments: Mapping[str, Any] | None = None, keep: Sequence[str] | Literal["all"] | None = None,
               dtype: Literal["float64", "float32"] = "float64", faulty: Literal["refuse", "nan"] = "refuse",
               overwrite: bool = False, cluster: str | None = None, threads: int | None = None, retries: int = 3,
               rows_per_part: int | None = None, progress: Progress = False) -> Written:
    """Computes a function of the states in Parquet files and writes Parquet files with the same rows in the same order.

    function: name of a function of this package that takes N states, such as "inverse_dynamics"; or a function of
        yours, (m, q, v, ...), whose parameters without a default are names of columns, and which returns (N, ...) or
        a dict of such arrays.
    states: a file, a list of files or a folder of files. A column `q` holds lists of nq numbers, and `v`, `a` and
        `tau` hold lists of nv numbers of any real type; or each coordinate has a column, `q A1`, `q A2`, ...
    output: a file if the name ends in .parquet, otherwise a folder of files. The result is a column of numbers, lists
        or tensors: `tau` of inverse_dynamics, `a` of forward_dynamics, and otherwise named like the function.
    arguments: further arguments of the function, such as {"frame": "flange"}, which are the same for all states.
    keep: the columns to carry over, or "all"; if left out, all columns that are not part of a state.
    dtype: type of the results in the files; they are computed in float64.
    faulty: whether a row that is not finite or has no result is an error, which names the file and the row, or has NaN.
    overwrite: whether existing output is removed and everything is computed again. Otherwise an interrupted job is
        continued: only the missing parts are computed. A job is the same if the model, the states, the arguments, and
        the function with the values to which it is bound are the same, see docs/distributed.md.
    cluster: "local" starts Ray on the cores of this machine, and an address connects to a cluster; both end with the
        call. If it is left out, the cluster to which this program is connected is used, or that of $RAY_ADDRESS, and
        otherwise this process. The workers of a cluster must see the files under the same names.
    threads: number of threads of this process; if left out, all cores, or one for a function of yours.
    retries: how often Ray computes a part again if its worker was lost.
    rows_per_part: states in a part; if left out, 65,536, or fewer if their results exceed 64 MiB. Each core works on
        one part at a time, so that memory is bounded.
    progress: whether a bar is shown, which needs tqdm; or a function (rows done, rows).

    ValueError for wrong contents of the files, KeyError for an unknown function, TypeError for wrong arguments of the
    function, FileExistsError if the output exists already.

    >>> import pyarrow as pa, pyarrow.parquet as pq, tempfile
    >>> folder = tempfile.mkdtemp()
    >>> q = pa.FixedSizeListArray.from_arrays(arm.random(n=1000, seed=1).ravel(), 7)
    >>> pq.write_table(pa.table({"q": q, "v": q, "a": q}), folder + "/states.parquet")
    >>> axode.distributed.map_states(arm, "inverse_dynamics", folder + "/states.parquet", folder + "/tau.parquet").rows
    1000
    """
    table_function = TableFunction(m, function, arguments, keep=keep, dtype=dtype, faulty=faulty)
    most = _at_least_one("rows_per_part", rows_per_part, min(ROWS, BYTES // (table_function.row_bytes or 1)))
    files = parquet_states.files_in(states, output)
    wanted: list[str] = []
    parts: list[Part] = []
    for file in files:
        schema, found = parquet_states.slices(file, most)
        try:
            taken, kept = table_function.columns(schema.names)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from error
        columns = [name for name in schema.names if name in {*itertools.chain(*taken.values(), kept)}]
        wanted = wanted or columns
        if {*columns} != {*wanted}:
            raise ValueError(f"{file}: it has the columns {', '.join(columns)}; {files[0]} has {', '.join(wanted)}")
        parts += found

    def results(part: Part) -> tuple[Any, int]:
        table = parquet_states.read(part, wanted, most)
        try:
            return table_function.results(table, f"{part.file}: ", part.first)
        except (parquet_states.RowError, StatesError):
            raise
        except Exception as error:
            if table_function.known:
                raise ValueError(f"{part.file}: {error}") from error
            raise RuntimeError(f"{table_function.name} of {part}: {type(error).__name__}: {error}") from error

    job = {"function": table_function.function, "model": m,
           "states": [(file, os.path.getsize(file), os.stat(file).st_mtime_ns) for file in files],
           "arguments": [table_function.arguments, keep, dtype, faulty], "rows_per_part": most}
    if threads is None:
        threads = (os.cpu_count() or 1) if table_function.known else 1
    return jobs.write(results, parts or [Part(files[0], 0, 0)], output, job, overwrite, cluster=cluster,
                      threads=threads, retries=retries, progress=progress)


def grid(**axes: Iterable[Any]) -> dict[str, list[Any]]:
    """All combinations of the values along each axis, as points of `sweep`; the last axis changes first.

    >>> axode.distributed.grid(mass=[1, 2], speed=[0.1, 0.2, 0.3])
    {'mass': [1, 1, 1, 2, 2, 2], 'speed': [0.1, 0.2, 0.3, 0.1, 0.2, 0.3]}
    """
    points = list(itertools.product(*axes.values()))
    return {name: [point[k] for point in points] for k, name in enumerate(axes)}


@overload
def sweep(m: Any, function: Callable[..., Any], points: Mapping[str, Sequence[Any]], output: None = None, *,
          overwrite: bool = False, cluster: str | None = None, threads: int = 1, retries: int = 3,
          points_per_part: int | None = None, progress: Progress = False) -> dict[str, NDArray[Any]]: ...


@overload
def sweep(m: Any, function: Callable[..., Any], points: Mapping[str, Sequence[Any]], output: str | os.PathLike[str], *,
          overwrite: bool = False, cluster: str | None = None, threads: int = 1, retries: int = 3,
          points_per_part: int | None = None, progress: Progress = False) -> Written: ...


def sweep(m: Any, function: Callable[..., Any], points: Mapping[str, Sequence[Any]],
          output: str | os.PathLike[str] | None = None, *, overwrite: bool = False, cluster: str | None = None,
          threads: int = 1, retries: int = 3, points_per_part: int | None = None,
          progress: Progress = False) -> dict[str, NDArray[Any]] | Written:
    """Computes a function of a model at many points, of a grid or of seeds for Monte Carlo, and writes a row for each
    point.

    function: receives m, a model or any other object, and the numbers of a point under their names. It returns a
        number, called `result`, or a dict of numbers, words and arrays with the same keys for every point. Numbers
        become float64. Draw random numbers from a seed only, `np.random.default_rng(seed)`; then results do not
        depend on the worker that computes a point.
    points: a dict with the same number of values for each name, such as `grid(...)` or {"seed": range(1000)}.
    output: a Parquet file or folder as in `map_states`, which is continued in the same way. If left out, the columns
        are returned as arrays.
    threads: of this process. Use more than 1 if the function is long in axode or numpy, which let other threads run,
        and a cluster, for example "local", if it is long in Python.
    points_per_part: points that a worker computes before it writes them; if left out, there are 256 parts.
    overwrite, cluster, retries, progress: as in `map_states`.

    RuntimeError, with the point, if the function fails.

    >>> def holding_torque(m, seed):
    ...     drawn = m.parameters * np.random.default_rng(seed).normal(1, 0.01, m.parameters.shape)
    ...     return float(axode.gravity_torques(m.with_parameters(drawn), np.full(7, 0.5))[1])
    >>> torques = axode.distributed.sweep(arm, holding_torque, {"seed": range(20)})
    >>> torques["seed"][:3], torques["result"].shape
    (array([0, 1, 2]), (20,))
    """
    if not isinstance(points, Mapping):
        raise TypeError(f"points is {points!r:.60}; expected a dict of equally many values under each name")
    values = {name: list(of) for name, of in points.items()}
    lengths = {name: len(of) for name, of in values.items()}
    if len({*lengths.values()}) != 1:
        raise ValueError(f"points: expected equally many values under each name, got {lengths}")
    if (N := max(lengths.values())) == 0:
        raise ValueError("points is empty; expected at least one value under each name")
    most = _at_least_one("points_per_part", points_per_part, -(-N // PARTS))
    given = pa.table({name: _column(name, of) for name, of in values.items()})

    def results(part: Part) -> tuple[Any, int]:
        table, rows = given.slice(part.first, part.rows), []
        for k in range(part.first, part.first + part.rows):
            point = {name: of[k] for name, of in values.items()}
            where = "at " + ", ".join(f"{name} = {value!r:.40}" for name, value in point.items())
            try:
                row = function(m, **point)
            except Exception as error:
                raise RuntimeError(f"{where}: {type(error).__name__}: {error}") from error
            rows.append({str(name): x for name, x in row.items()} if isinstance(row, Mapping) else {"result": row})
            if list(rows[-1]) != list(rows[0]):
                raise ValueError(f"{where} the function returns {', '.join(rows[-1]) or 'nothing'}; before it was "
                                 f"{', '.join(rows[0]) or 'nothing'}")
        for name in rows[0]:
            if name in values:
                raise ValueError(f'the function returns "{name}", which is a name of the points as well')
            table = table.append_column(name, _column(name, [row[name] for row in rows], float))
        return table, 0

    parts = [Part("", first, min(most, N - first)) for first in range(0, N, most)]
    how: dict[str, Any] = {"cluster": cluster, "threads": threads, "retries": retries, "progress": progress}
    if output is not None:
        job = {"function": function, "model": m, "points": values, "points_per_part": most}
        return jobs.write(results, parts, output, job, overwrite, **how)
    reports = sorted(jobs.run(results, parts, [None] * len(parts), **how))
    whole = pa.concat_tables([report.table for report in reports])
    return {name: column.to_numpy() if column.type == pa.int64() else parquet_states.numbers(column, name)
            for name, column in zip(whole.column_names, whole.columns)}


def _at_least_one(name: str, given: int | None, default: int) -> int:
    if given is not None and given < 1:
        raise ValueError(f"{name} is {given}; it must be at least 1")
    return max(default, 1) if given is None else given


def _column(name: str, values: list[Any], kind: type | None = None) -> Any:
    """A column of words, of arrays of the same shape, or of numbers, which become the given kind."""
    if isinstance(values[0], (str, bool, np.bool_)):
        return pa.array(values)
    try:
        array = np.array(values)
    except ValueError as error:
        raise ValueError(f'"{name}" must have the same shape at all points') from error
    if array.dtype.kind not in "fiu":
        wrong = next((x for x in values if np.asarray(x).dtype.kind not in "fiu"), values[0])
        raise ValueError(f'"{name}" is {wrong!r:.60}; expected numbers, words or arrays of numbers')
    return parquet_states.as_column(name, array.astype(kind) if kind and array.ndim == 1 else array, len(values))


signatures.explain_calls(__name__)
