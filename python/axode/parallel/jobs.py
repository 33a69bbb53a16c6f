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
import threading
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, NamedTuple

from .job_identity import Unknown, digest
from .parquet_states import ROWS  # first: it says what to install if pyarrow is missing
from ..support.progress import progress_bar
from ..support.written_files import replacing

import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.dataset as ds  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]

__all__: list[str] = []

MANIFEST = "_axode.json"
Progress = bool | Callable[[int, int], object]
#: The number of a part, what the task computes it from, and its file.
Part = tuple[int, Any, Path | None]


class Report(NamedTuple):
    """Report of a worker about a part."""

    number: int
    schema: Any
    faulty: int = 0
    computed: bool = False
    table: Any = None
    error: Exception | None = None


def stored(paths: Sequence[Path]) -> Any:
    """The files of parts as one data set."""
    return ds.dataset([str(path) for path in paths], format="parquet" if paths[0].suffix == ".parquet" else "ipc")


def parquet_file(path: Path, schema: Any) -> Any:
    return pq.ParquetWriter(path, schema, use_dictionary=False)


def compute(task: Any, number: int, part: Any, path: Path | None, loaded: Any = None,
            stop: threading.Event | None = None) -> Report:
    """Writes the file of a part, unless it is there: a worker may have ended between writing it and saying so."""
    try:
        if path is not None and path.exists():
            return Report(number, stored([path]).schema)
        faulty, schema = 0, None
        with contextlib.ExitStack() as stack:
            sink: Any = stack.enter_context(replacing(path)) if path else pa.BufferOutputStream()
            for table, without in task.tables(part, task.load(part) if loaded is None else loaded):
                if stop is not None and stop.is_set():
                    raise InterruptedError
                if schema is None:
                    schema, new = table.schema, parquet_file if path and path.suffix == ".parquet" else pa.ipc.new_file
                    writer = stack.enter_context(new(sink, schema))
                writer.write_table(table.cast(schema))
                faulty += without
        return Report(number, schema, faulty, True, None if path else sink.getvalue())
    except Exception as error:
        return Report(number, None, error=error)


# -------------------------------------------------------------------------------------------------- all parts


def _in_process(task: Any, parts: deque[Part], threads: int) -> Generator[Report, None, None]:
    """Parts are loaded by this thread and computed by others; with one thread everything happens in this one."""
    if threads == 1:
        yield from (compute(task, *one) for one in parts)
        return
    stop = threading.Event()
    running: set[Future[Report]] = set()
    with ThreadPoolExecutor(threads) as pool:
        try:
            while parts or running:
                while parts and len(running) <= threads:
                    number, part, path = parts.popleft()
                    running.add(pool.submit(compute, task, number, part, path, task.load(part), stop))
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)


def _on_cluster(ray: Any, task: Any, parts: deque[Part], retries: int) -> Generator[Report, None, None]:
    """Keeps two tasks for each core of the cluster: one that runs and one that waits."""
    shipped, remote = ray.put(task), ray.remote(max_retries=retries, num_cpus=1)(compute)
    running: dict[Any, tuple[int, Any]] = {}
    try:
        while parts or running:
            most = 2 * max(1, int(ray.cluster_resources().get("CPU", 1)))
            while parts and len(running) < most:
                number, part, path = parts.popleft()
                running[remote.remote(shipped, number, part, path)] = number, part
            (done,), _ = ray.wait(list(running))
            number, part = running.pop(done)
            try:
                yield ray.get(done)
            except ray.exceptions.RayError as error:
                lost = isinstance(error, ray.exceptions.WorkerCrashedError)
                why = f"its worker ended {retries + 1} times" if lost else str(error).strip().splitlines()[-1]
                yield Report(number, None, error=RuntimeError(f"{task.said(part)}: {why}"))
    finally:
        for reference in running:
            with contextlib.suppress(Exception):  # the cluster itself may be gone
                ray.cancel(reference, force=True)


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
    except ImportError as error:
        raise ImportError(f"cluster is {wanted!r}, which needs Ray: pip install ray") from error
    try:
        host, _, port = wanted.removeprefix("ray://").rpartition(":")
        if host and port.isdigit():  # Ray itself waits some minutes if nobody listens
            socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()
        ray.init(address=cluster, log_to_driver=False, logging_level=logging.ERROR,
                 include_dashboard=False if cluster == "local" else None)
    except (OSError, ValueError) as error:
        raise ConnectionError(f"there is no Ray cluster at {wanted!r}: {error}") from error
    stack.callback(ray.shutdown)
    return ray


def run(task: Any, parts: Sequence[Any], paths: Sequence[Path | None], *, cluster: str | None, threads: int,
        retries: int, progress: Progress) -> Generator[Report, None, None]:
    """Runs all parts and yields their reports in the order in which they end. The first error ends the work, and so does
    Ctrl-C; the files that exist by then stay.

    Every worker receives the task once. A part has a number of `rows`. `task.said(part)` is its name, `task.load(part)`
    its input, which is loaded in the order of the parts, and `task.tables(part, loaded)` yields its results in pieces,
    each with its number of rows without a result. Errors of a task name the row.
    """
    written, missing = deque[Part](), deque[Part]()
    for number, (part, path) in enumerate(zip(parts, paths)):
        (written if path is not None and path.exists() else missing).append((number, part, path))
    rows, done, schema = sum(part.rows for part in parts), 0, None
    with contextlib.ExitStack() as stack:
        if progress is True:
            bar = stack.enter_context(progress_bar(rows, unit="row", unit_scale=True))
            progress = lambda done, rows: bar.update(done - bar.n)
        ray = _cluster_named(cluster, stack)
        new = _on_cluster(ray, task, missing, retries) if ray else _in_process(task, missing, threads)
        stack.enter_context(contextlib.closing(new))
        for report in itertools.chain(_in_process(task, written, 1), new):
            if report.error is not None:
                raise report.error
            schema = schema or report.schema
            if report.schema != schema:
                before, after = (", ".join(f"{field.name} ({field.type})" for field in of)
                                 for of in (schema, report.schema))
                raise ValueError(f"results differ from part to part: {before} and {after}")
            done += parts[report.number].rows
            if progress:
                progress(done, rows)
            yield report


# ------------------------------------------------------------------------------------------------------ files


class Output:
    """Destination of the parts of a job: files in a folder, or in a temporary folder beside the file into which they
    are joined.

    The file `_axode.json` in the folder says which job it is, and whether it is complete. One process works in the
    folder at a time. `job` is everything that its results depend on.
    """

    def __init__(self, target: str | os.PathLike[str], job: Mapping[str, Any], parts: int, overwrite: bool):
        self.target, self.overwrite = Path(target), overwrite
        self.is_file = self.target.suffix == ".parquet"
        self.folder = self.target.with_name(self.target.name + ".parts") if self.is_file else self.target
        self.identity = {name: digest(value) for name, value in job.items()}
        width, suffix = max(6, len(str(parts))), ".arrow" if self.is_file else ".parquet"
        self.paths = [self.folder / f"part-{number:0{width}}{suffix}" for number in range(parts)]
        if not self.target.parent.is_dir():
            raise FileNotFoundError(f"{self.target.parent}: there is no such folder")
        if self.target.is_dir() if self.is_file else self.target.is_file():
            raise FileExistsError(f"{self.target} is a {'folder' if self.is_file else 'file'}; "
                                  "a name that ends in .parquet is one of a file, others are of folders")
        self._refuse_result(self.is_file and self.target.exists() and not overwrite)

    def _refuse_result(self, exists: bool) -> None:
        if exists:
            raise FileExistsError(f"{self.target} exists; overwrite=True replaces it")

    def write(self, task: Any, parts: Sequence[Any], **how: Any) -> list[Report]:
        """Computes the parts that are missing, with the arguments of `run`, and joins all if one file is wanted."""
        self.folder.mkdir(exist_ok=True)
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._begin()
            try:
                reports = list(run(task, parts, self.paths, **how))
            finally:
                if not any(path.exists() for path in self.paths):  # there is nothing to go on with
                    self._clear(MANIFEST, ".")
                    self.folder.rmdir()
            self._finish()
            return reports
        except BlockingIOError:
            raise FileExistsError(f"{self.target}: another process is writing to it") from None
        finally:
            os.close(lock)

    def _begin(self) -> None:
        """FileExistsError unless the folder is empty or has some parts of this job, or may be overwritten."""
        manifest = self.folder / MANIFEST
        if not manifest.exists():
            if any(not file.name.startswith(f".{MANIFEST}") for file in self.folder.iterdir()):
                raise FileExistsError(f"{self.folder} is not empty and was not written by axode.distributed")
        elif self.overwrite:
            self._say({})  # of no job, so that nothing is taken for what it is not if this is ended here
            self._clear("part-", ".")
        else:
            before = json.loads(manifest.read_text(encoding="utf-8"))
            self._refuse_result(before.get("complete"))
            for name, value in self.identity.items():
                if isinstance(value, Unknown) or before.get(name) != value:
                    what = (f"a job that cannot be compared with this one: {name} {value}" if isinstance(value, Unknown)
                            else f"another job: {name} differs")
                    raise FileExistsError(f"{self.folder} holds parts of {what}; overwrite=True starts it again")
        self._say({**self.identity, "complete": False})

    def _finish(self) -> None:
        self._clear(".")
        if not self.is_file:
            return self._say({**self.identity, "complete": True})
        data = stored(self.paths)
        with replacing(self.target, self.folder) as temporary, parquet_file(temporary, data.schema) as writer:
            for batch in data.to_batches(batch_size=ROWS, batch_readahead=1, fragment_readahead=1):
                writer.write_batch(batch)
        self._clear("part-", MANIFEST)
        self.folder.rmdir()

    def _clear(self, *beginnings: str) -> None:
        for file in self.folder.iterdir():
            if file.name.startswith(beginnings):
                file.unlink()

    def _say(self, what: Mapping[str, Any]) -> None:
        with replacing(self.folder / MANIFEST) as temporary:
            temporary.write_text(json.dumps(what, indent=1, default=str), encoding="utf-8")
