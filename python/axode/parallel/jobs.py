"""Work in parts, each of which leaves one file, or none: in this process or on a Ray cluster, begun anew where it was
ended.

Parts are tasks of Ray and not rows of Ray Data, whose errors do not say which part has ended its worker.
"""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import json
import logging
import os
import socket
import sys
import threading
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from .job_identity import Unknown, digest
from .parquet_states import ROWS  # first: it says what to install if pyarrow is missing
from ..support.progress import progress_bar
from ..support.written_files import replacing

import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.dataset as ds  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]

__all__: list[str] = []

MANIFEST = "_axode.json"
#: The variable in which Ray itself looks for the address of a cluster.
RAY_ADDRESS = "RAY_ADDRESS"


class Task(Protocol):
    """A task that is computed for each part. Every worker receives it once."""

    def said(self, part: Any) -> str:
        """The words for a part."""

    def load(self, part: Any) -> Any:
        """The input of a part; parts are loaded in their order."""

    def tables(self, part: Any, loaded: Any) -> Iterator[tuple[Any, int]]:
        """Results of a part in pieces, and how many rows of each have none. Errors say which row they are about."""


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


def compute(task: Task, number: int, part: Any, path: Path | None, loaded: Any = None,
            stop: threading.Event | None = None) -> Report:
    """Writes the file of a part, unless it is there: a worker may have ended between writing it and saying so."""
    faulty, tables, schema = 0, [], None
    try:
        if path is not None and path.exists():
            return Report(number, stored([path]).schema)
        with contextlib.ExitStack() as stack:
            temporary: Any = None if path is None else stack.enter_context(replacing(path))
            for table, without in task.tables(part, task.load(part) if loaded is None else loaded):
                if stop is not None and stop.is_set():
                    raise InterruptedError
                if path is None:
                    tables.append(table)
                elif schema is None:
                    new = parquet_file if path.suffix == ".parquet" else pa.ipc.new_file
                    writer = stack.enter_context(new(temporary, table.schema))
                schema = schema or table.schema
                if path is not None:
                    writer.write_table(table.cast(schema))
                faulty += without
        return Report(number, schema, faulty, True, pa.concat_tables(tables) if path is None else None)
    except Exception as error:
        return Report(number, None, error=error)


# ------------------------------------------------------------------------------------------------------- all parts


def _here(task: Task, parts: list[tuple[int, Any, Path | None]], threads: int) -> Generator[Report, None, None]:
    """Parts are loaded by this thread and computed by others; with one thread everything happens in this one."""
    if threads == 1:
        for number, part, path in parts:
            yield compute(task, number, part, path)
        return
    stop = threading.Event()
    running: set[Future[Report]] = set()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for number, part, path in parts:
                loaded = None
                with contextlib.suppress(Exception):  # it cannot be loaded, which `compute` finds out again and reports
                    loaded = task.load(part)
                running.add(pool.submit(compute, task, number, part, path, loaded, stop))
                while len(running) > threads:
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


def _over(ray: Any, task: Task, parts: list[tuple[int, Any, Path | None]],
          retries: int) -> Generator[Report, None, None]:
    """Keeps two tasks for each core of the cluster: one that runs and one that waits."""
    shipped = ray.put(task)
    remote = ray.remote(max_retries=retries, num_cpus=1)(compute)
    waiting = iter(parts)
    running: dict[Any, tuple[int, Any]] = {}
    try:
        while True:
            room = 2 * max(1, int(ray.cluster_resources().get("CPU", 1))) - len(running)
            for number, part, path in itertools.islice(waiting, room):
                running[remote.remote(shipped, number, part, path)] = number, part
            if not running:
                return
            (done,), _ = ray.wait(list(running), num_returns=1)
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


@contextlib.contextmanager
def cluster_named(cluster: str | None) -> Iterator[Any]:
    """Ray, connected to the cluster with that address, to a cluster on the cores of this machine, or to the cluster of this
    program; None means this process."""
    wanted = cluster or os.environ.get(RAY_ADDRESS)
    ray = sys.modules.get("ray")
    if ray is None and wanted:
        try:
            import ray  # type: ignore[import-not-found, import-untyped, unused-ignore, no-redef]
        except ImportError as error:
            raise ImportError(f"cluster is {wanted!r}, which needs Ray: pip install ray") from error
    connected = ray is not None and ray.is_initialized()
    if connected and cluster is not None:
        raise ValueError(f"cluster is {cluster!r}, but this program is connected to a Ray cluster; leave it out")
    if connected or not wanted:
        yield ray if connected else None
        return
    assert ray is not None
    try:
        host, _, port = wanted.removeprefix("ray://").rpartition(":")
        if host and port.isdigit():  # Ray itself waits some minutes if nobody listens
            socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()
        ray.init(address=cluster, log_to_driver=False, logging_level=logging.ERROR,
                 include_dashboard=False if cluster == "local" else None)
    except (OSError, ValueError) as error:
        raise ConnectionError(f"there is no Ray cluster at {wanted!r}: {error}") from error
    try:
        yield ray
    finally:
        ray.shutdown()


@contextlib.contextmanager
def _shown(wanted: bool | Callable[[int, int], object], rows: int) -> Iterator[Callable[[int], None]]:
    """A function that receives the number of further finished rows, and reports it to `progress` or shows it by tqdm."""
    done = 0
    bar = progress_bar(rows, unit="row", unit_scale=True) if wanted is True else None

    def add(more: int) -> None:
        nonlocal done
        done += more
        if bar is not None:
            bar.update(more)
        if callable(wanted):
            wanted(done, rows)

    with contextlib.closing(bar) if bar is not None else contextlib.nullcontext():
        yield add


def run(task: Task, parts: Sequence[Any], paths: Sequence[Path | None], *, cluster: str | None, threads: int,
        retries: int, progress: bool | Callable[[int, int], object]) -> Generator[Report, None, None]:
    """Reports of all parts, in the order in which they end. The first error ends the work; so does Ctrl-C. What is
    written by then stays."""
    there = {number for number, path in enumerate(paths) if path is not None and path.exists()}
    missing = [(number, parts[number], path) for number, path in enumerate(paths) if number not in there]
    schema = None
    with _shown(progress, sum(part.rows for part in parts)) as add:
        for number in sorted(there):
            add(parts[number].rows)
            schema = schema or stored([paths[number]]).schema  # type: ignore[list-item]
            yield Report(number, schema)
        with cluster_named(cluster) as ray, contextlib.closing(
                _here(task, missing, threads) if ray is None else _over(ray, task, missing, retries)) as reports:
            for report in reports:
                if report.error is not None:
                    raise report.error
                schema = schema or report.schema
                if report.schema != schema:
                    before, after = (", ".join(f"{field.name} ({field.type})" for field in of)
                                     for of in (schema, report.schema))
                    raise ValueError(f"results differ from part to part: {before} and {after}")
                add(parts[report.number].rows)
                yield report


# ------------------------------------------------------------------------------------------------------- files


class Output:
    """Destination of the parts of a job: files in a folder, or in a temporary folder beside the file into which they are joined.

    A folder says in `_axode.json` what it holds, and whether that is all. One process works in it at a time. `job` is
    everything that its results depend on.
    """

    def __init__(self, target: str | os.PathLike[str], job: Mapping[str, Any], parts: int, overwrite: bool):
        self.target, self.overwrite = Path(target), overwrite
        self.is_file = self.target.suffix == ".parquet"
        self.folder = self.target.with_name(self.target.name + ".parts") if self.is_file else self.target
        self.identity: dict[str, str | None] = dict.fromkeys(job)
        self.unknown: dict[str, str] = {}
        for name, value in job.items():
            try:
                self.identity[name] = digest(value)
            except Unknown as error:
                self.unknown[name] = str(error)
        width, suffix = max(6, len(str(parts))), ".arrow" if self.is_file else ".parquet"
        self.paths = [self.folder / f"part-{number:0{width}}{suffix}" for number in range(parts)]
        if not self.target.parent.is_dir():
            raise FileNotFoundError(f"{self.target.parent}: there is no such folder")
        if self.is_file and self.target.exists() and not overwrite:
            raise FileExistsError(f"{self.target} exists; overwrite=True replaces it")
        if self.is_file and self.target.is_dir() or not self.is_file and self.target.is_file():
            raise FileExistsError(f"{self.target} is a {'folder' if self.is_file else 'file'}; a name that ends in .parquet "
                                  "is one of a file, others are of folders")

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """The folder is there and this process alone works in it."""
        self.folder.mkdir(exist_ok=True)
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._begin()
            yield
        except BlockingIOError:
            raise FileExistsError(f"{self.target}: another process is writing to it") from None
        finally:
            os.close(lock)

    def _begin(self) -> None:
        manifest = self.folder / MANIFEST
        if not manifest.exists() and any(not file.name.startswith(f".{MANIFEST}") for file in self.folder.iterdir()):
            raise FileExistsError(f"{self.folder} is not empty and was not written by axode.distributed")
        if manifest.exists() and not self.overwrite:
            self._check_same(json.loads(manifest.read_text(encoding="utf-8")))
        elif manifest.exists():
            self._say({})  # of no job, so that nothing is taken for what it is not if this is ended here
            self._clear("part-", ".")
        self._say({**self.identity, "complete": False})

    def _check_same(self, before: dict[str, Any]) -> None:
        """FileExistsError unless the parts that are there are known to be those of this job, and some are missing."""
        if before.get("complete"):
            raise FileExistsError(f"{self.target} exists and is complete; overwrite=True replaces it")
        for name, value in self.identity.items():
            if name not in self.unknown and before.get(name) != value:
                raise FileExistsError(f"{self.folder} holds parts of another job: {name} differs; overwrite=True starts it again")
        for name, why in self.unknown.items():
            raise FileExistsError(f"{self.folder} holds parts of a job that cannot be compared with this one: "
                                  f"{name} {why}; overwrite=True starts it again")

    def _clear(self, *beginnings: str) -> None:
        for file in self.folder.iterdir():
            if file.name.startswith(beginnings):
                file.unlink()

    def _say(self, what: dict[str, Any]) -> None:
        with replacing(self.folder / MANIFEST) as temporary:
            temporary.write_text(json.dumps(what, indent=1), encoding="utf-8")

    def write(self, reports: Iterator[Report]) -> list[Report]:
        """Takes the reports of all parts, and makes one file of the parts if one is wanted."""
        found = []
        try:
            found = list(reports)
        finally:
            if not found and not any(path.exists() for path in self.paths):  # there is nothing to go on with
                self._clear(MANIFEST, ".")
                self.folder.rmdir()
        self._clear(".")
        if not self.is_file:
            self._say({**self.identity, "complete": True})
            return found
        parts = stored(self.paths)
        with replacing(self.target, self.folder) as temporary, parquet_file(temporary, parts.schema) as writer:
            for batch in parts.to_batches(batch_size=ROWS, batch_readahead=1, fragment_readahead=1):
                writer.write_batch(batch)
        self._clear("part-", MANIFEST)
        self.folder.rmdir()
        return found
