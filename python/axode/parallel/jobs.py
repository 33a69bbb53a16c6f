"""Work in parts, in this process or on a Ray cluster. A part that is complete leaves a file, so that interrupted work
can be continued.

Parts are tasks of Ray and not rows of Ray Data, because errors of Ray Data do not say which part has ended its
worker.
"""

from __future__ import annotations

import contextlib
import fcntl
import importlib
import itertools
import json
import logging
import os
import socket
import sys
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple

from .job_identity import Unknown, digest
from .parquet_states import Part, reading  # first: it says what to install if pyarrow is missing
from ..support.progress import progress_bar
from ..support.written_files import replacing

import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.dataset as ds  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]

__all__: list[str] = []

MANIFEST = "_axode.json"
Progress = bool | Callable[[int, int], object]
#: The table of the results of a part, and the number of its rows that have none.
Function = Callable[[Part], tuple[Any, int]]
Numbered = tuple[int, Part, Path | None]


class Written(NamedTuple):
    """Summary of the files that `map_states` or `sweep` wrote: the number of `rows` and of `parts`, the number of parts
    that this call `computed` (an interrupted call before may have computed the others), and the number of `faulty`
    rows, which are NaN, among them.

    >>> axode.distributed.Written(rows=10, parts=1, computed=1, faulty=0).rows
    10
    """

    rows: int
    parts: int
    computed: int
    faulty: int


class Report(NamedTuple):
    """Report of a worker about a part. It has the table if there is no file."""

    number: int
    schema: Any
    faulty: int = 0
    computed: bool = False
    table: Any = None


def stored(paths: Sequence[Path]) -> Any:
    """The files of parts as one data set."""
    return ds.dataset([*map(str, paths)], format=paths[0].suffix.removeprefix("."))


def new_file(path: Path, suffix: str, schema: Any) -> Any:
    return pa.ipc.new_file(path, schema) if suffix == ".arrow" else pq.ParquetWriter(path, schema, use_dictionary=False)


def compute(function: Function, number: int, part: Part, path: Path | None) -> Report:
    """Writes the file of a part, unless it is there: a worker may have ended between writing it and saying so."""
    if path is not None and path.exists():
        return Report(number, stored([path]).schema)
    table, faulty = function(part)
    if path is None:
        return Report(number, table.schema, faulty, True, table)
    with replacing(path) as temporary, new_file(temporary, path.suffix, table.schema) as file:
        file.write_table(table)
    return Report(number, table.schema, faulty, True)


def _in_process(function: Function, parts: Sequence[Numbered], threads: int) -> Generator[Report, None, None]:
    """With one thread everything happens in this one."""
    if threads == 1:
        yield from (compute(function, *one) for one in parts)
        return
    with ThreadPoolExecutor(threads) as pool:
        try:
            running = [pool.submit(compute, function, *one) for one in parts]
            yield from (future.result() for future in as_completed(running))
        finally:
            pool.shutdown(cancel_futures=True)


def _on_cluster(ray: Any, function: Function, parts: Sequence[Numbered], retries: int) -> Generator[Report, None, None]:
    """Keeps two tasks for each core of the cluster: one that runs and one that waits."""
    shipped, remote = ray.put(function), ray.remote(max_retries=retries, num_cpus=1)(compute)
    waiting, running = deque(parts), dict[Any, Numbered]()
    try:
        while waiting or running:
            while waiting and len(running) < 2 * max(1, int(ray.cluster_resources().get("CPU", 1))):
                one = waiting.popleft()
                running[remote.remote(shipped, *one)] = one
            (done,), _ = ray.wait(list(running))
            _, part, _ = running.pop(done)
            try:
                yield ray.get(done)
            except ray.exceptions.RayTaskError as error:
                raise error.cause from None
            except ray.exceptions.RayError as error:
                lost = isinstance(error, ray.exceptions.WorkerCrashedError)
                why = f"its worker ended {retries + 1} times" if lost else str(error).strip().splitlines()[-1]
                raise RuntimeError(f"{part}: {why}") from error
    finally:
        with contextlib.suppress(Exception):  # the cluster itself may be gone
            for reference in running:
                ray.cancel(reference, force=True)
            # A worker that still lives could write to the files of the next job.
            ray.wait(list(running), num_returns=len(running), timeout=10)


def _cluster_named(cluster: str | None, stack: contextlib.ExitStack) -> Any:
    """Ray, connected to the cluster with that address, to a cluster on the cores of this machine, or to the cluster of
    this program; None means this process. A connection ends with the stack."""
    wanted, ray = cluster or os.environ.get("RAY_ADDRESS"), sys.modules.get("ray")
    if ray is not None and ray.is_initialized():
        if cluster is not None:
            raise ValueError(f"cluster is {cluster!r}, but this program is connected to a Ray cluster; leave it out")
        return ray
    if not wanted:
        return None
    try:
        ray = importlib.import_module("ray")
        host, _, port = wanted.removeprefix("ray://").rpartition(":")
        if host and port.isdigit():  # Ray itself waits some minutes if nobody listens
            socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()
        ray.init(address=cluster, log_to_driver=False, logging_level=logging.ERROR,
                 include_dashboard=False if cluster == "local" else None)
    except ImportError as error:
        raise ImportError(f"cluster is {wanted!r}, which needs Ray: pip install ray") from error
    except (OSError, ValueError) as error:
        raise ConnectionError(f"there is no Ray cluster at {wanted!r}: {error}") from error
    stack.callback(ray.shutdown)
    return ray


def run(function: Function, parts: Sequence[Part], paths: Sequence[Path | None], *, cluster: str | None, threads: int,
        retries: int, progress: Progress) -> Generator[Report, None, None]:
    """Computes all parts and yields their reports in the order in which they end. The first error ends the work, and so
    does Ctrl-C; the files that exist by then stay. Every worker receives the function once."""
    if threads < 1:
        raise ValueError(f"threads is {threads}; it must be at least 1")
    written: list[Numbered] = []
    missing: list[Numbered] = []
    for number, (part, path) in enumerate(zip(parts, paths)):
        (written if path is not None and path.exists() else missing).append((number, part, path))
    rows, done, schema = sum(part.rows for part in parts), 0, None
    with contextlib.ExitStack() as stack:
        stack.callback(reading.clear)
        if progress is True:
            bar = stack.enter_context(progress_bar(rows, unit="row", unit_scale=True))
            progress = lambda done, rows: bar.update(done - bar.n)
        ray = _cluster_named(cluster, stack)
        new = _on_cluster(ray, function, missing, retries) if ray else _in_process(function, missing, threads)
        stack.enter_context(contextlib.closing(new))
        for report in itertools.chain(_in_process(function, written, 1), new):
            schema = schema or report.schema
            if report.schema != schema:
                before, after = (", ".join(f"{field.name} ({field.type})" for field in of)
                                 for of in (schema, report.schema))
                raise ValueError(f"results differ from part to part: {before} and {after}")
            done += parts[report.number].rows
            if progress:
                progress(done, rows)
            yield report


def write(function: Function, parts: Sequence[Part], output: str | os.PathLike[str], job: Mapping[str, Any],
          overwrite: bool, **how: Any) -> Written:
    """Computes the parts that are missing, with the arguments of `run`, into files in a folder, or in a temporary
    folder beside the file into which they are joined.

    The file `_axode.json` in the folder says which job it is, and whether it is complete. One process works in the
    folder at a time. `job` is everything that its results depend on.
    """
    target = Path(output)
    is_file = target.suffix == ".parquet"
    folder = target.with_name(target.name + ".parts") if is_file else target
    manifest, identity = folder / MANIFEST, {name: digest(value) for name, value in job.items()}
    name = f"part-{{:0{max(6, len(str(len(parts))))}}}{'.arrow' if is_file else '.parquet'}"
    paths = [folder / name.format(number) for number in range(len(parts))]
    refused = FileExistsError(f"{target} exists; overwrite=True replaces it")

    def clear(*beginnings: str) -> None:
        for file in folder.iterdir():
            if file.name.startswith(beginnings):
                file.unlink(missing_ok=True)

    def say(what: Mapping[str, Any]) -> None:
        with replacing(manifest) as temporary:
            temporary.write_text(json.dumps(what, indent=1), encoding="utf-8")

    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target.parent}: there is no such folder")
    if target.is_dir() if is_file else target.is_file():
        raise FileExistsError(f"{target} is a {'folder' if is_file else 'file'}; "
                              "a name that ends in .parquet is one of a file, others are of folders")
    if is_file and target.exists() and not overwrite:
        raise refused
    folder.mkdir(exist_ok=True)
    lock = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not manifest.exists():
            if any(not file.name.startswith(f".{MANIFEST}") for file in folder.iterdir()):
                raise FileExistsError(f"{folder} is not empty and was not written by axode.distributed")
        elif overwrite:
            say({})  # of no job, so that nothing is taken for what it is not if this is ended here
            clear("part-", ".")
        else:
            before = json.loads(manifest.read_text(encoding="utf-8"))
            if before.get("complete"):
                raise refused
            for name, value in identity.items():
                if isinstance(value, Unknown) or before.get(name) != value:
                    what = (f"a job that cannot be compared with this one: {name} {value}" if isinstance(value, Unknown)
                            else f"another job: {name} differs")
                    raise FileExistsError(f"{folder} holds parts of {what}; overwrite=True starts it again")
        say({**identity, "complete": False})
        try:
            reports = list(run(function, parts, paths, **how))
            if is_file:
                data = stored(paths)
                with replacing(target, folder) as temporary, new_file(temporary, target.suffix, data.schema) as writer:
                    for batch in data.to_batches(batch_size=1 << 16, batch_readahead=1, fragment_readahead=1):
                        writer.write_batch(batch)
                clear("part-")
            else:
                say({**identity, "complete": True})
        finally:
            clear(".")
            if not any(path.exists() for path in paths):  # there is nothing to go on with
                clear(MANIFEST)
                folder.rmdir()
        return Written(sum(part.rows for part in parts), len(parts), sum(report.computed for report in reports),
                       sum(report.faulty for report in reports))
    except BlockingIOError:
        raise FileExistsError(f"{target}: another process is writing to it") from None
    finally:
        os.close(lock)
