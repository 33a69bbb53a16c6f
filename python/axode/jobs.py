"""Work in parts, each of which leaves one file, or none: in this process or on a Ray cluster, begun anew where it was ended."""

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
from .parquet_states import ROWS  # first: it says what to install where pyarrow is missing
from .progress import progress_bar
from .written_files import replacing

import pyarrow as pa  # type: ignore[import-not-found, import-untyped, unused-ignore]
import pyarrow.parquet as pq  # type: ignore[import-not-found, import-untyped, unused-ignore]

__all__: list[str] = []

MANIFEST = "_axode.json"
#: Where Ray itself looks for the address of a cluster.
RAY_ADDRESS = "RAY_ADDRESS"


class Task(Protocol):
    """What is done with the parts. It goes to every worker once."""

    def said(self, part: Any) -> str:
        """Which part it is."""

    def load(self, part: Any) -> Any:
        """What a part is computed from; parts are loaded in their order."""

    def tables(self, part: Any, loaded: Any) -> Iterator[tuple[Any, int]]:
        """Results of a part in pieces, and how many rows of each have none. Errors say which row they are about."""


class Report(NamedTuple):
    """What a worker says of a part."""

    number: int
    schema: Any
    faulty: int = 0
    computed: bool = False
    table: Any = None
    error: Exception | None = None


class Interrupted(Exception):
    """Somebody wants the work to end."""


# ------------------------------------------------------------------------------------------------------- one part


def writer_to(path: Path, suffix: str, schema: Any) -> Any:
    """Of Parquet, or of Arrow's own format for parts of a file that is yet to be written."""
    if suffix == ".parquet":
        return pq.ParquetWriter(path, schema, use_dictionary=False)
    return pa.ipc.new_file(path, schema)


def schema_of(path: Path) -> Any:
    if path.suffix == ".parquet":
        return pq.read_schema(path)
    with pa.memory_map(str(path)) as stream:
        return pa.ipc.open_file(stream).schema


def compute(task: Task, number: int, part: Any, path: Path | None, loaded: Any = None,
            stop: threading.Event | None = None) -> Report:
    """Writes the file of a part, unless it is there: a worker may have ended between writing it and saying so."""
    try:
        if path is not None and path.exists():
            return Report(number, schema_of(path))
        pieces = _until(stop, task.tables(part, task.load(part) if loaded is None else loaded))
        if path is None:
            tables, faulty = zip(*pieces)
            table = pa.concat_tables(tables)
            return Report(number, table.schema, sum(faulty), True, table)
        with replacing(path) as temporary:
            table, faulty_rows = next(pieces)
            with writer_to(temporary, path.suffix, table.schema) as writer:
                writer.write_table(table)
                for more, faulty in pieces:
                    writer.write_table(more.cast(table.schema))
                    faulty_rows += faulty
        return Report(number, table.schema, faulty_rows, True)
    except Exception as error:
        return Report(number, None, error=error)


def _until(stop: threading.Event | None, pieces: Iterator[Any]) -> Iterator[Any]:
    for piece in pieces:
        yield piece
        if stop is not None and stop.is_set():
            raise Interrupted


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
                running.add(pool.submit(compute, task, number, part, path, _loaded(task, part), stop))
                if len(running) > threads:
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


def _loaded(task: Task, part: Any) -> Any:
    """None where it cannot be loaded, which `compute` finds out again and reports."""
    try:
        return task.load(part)
    except Exception:
        return None


def _over(ray: Any, task: Task, parts: list[tuple[int, Any, Path | None]], retries: int) -> Generator[Report, None, None]:
    """As many tasks as the cluster has cores, and as many again that wait."""
    shipped = ray.put(task)
    all_parts = {number: part for number, part, _ in parts}
    remote = ray.remote(max_retries=retries, num_cpus=1)(compute)
    waiting = iter(parts)
    running: dict[Any, int] = {}
    try:
        while True:
            room = 2 * max(1, int(ray.cluster_resources().get("CPU", 1))) - len(running)
            for number, part, path in itertools.islice(waiting, room):
                running[remote.remote(shipped, number, part, path)] = number
            if not running:
                return
            done, _ = ray.wait(list(running), num_returns=1)
            number = running.pop(done[0])
            try:
                report: Report = ray.get(done[0])
            except ray.exceptions.RayError as error:
                lost = isinstance(error, ray.exceptions.WorkerCrashedError)
                why = f"its worker ended {retries + 1} times" if lost else str(error).strip().splitlines()[-1]
                report = Report(number, None, error=RuntimeError(f"{task.said(all_parts[number])}: {why}"))
            yield report
    finally:
        for reference in running:
            with contextlib.suppress(Exception):  # the cluster itself may be gone
                ray.cancel(reference, force=True)


@contextlib.contextmanager
def cluster_named(cluster: str | None) -> Iterator[Any]:
    """Ray, where there is a cluster: the one that this program is connected to, that of the address, or one of the cores of
    this machine. None stands for this process."""
    if cluster is None and not os.environ.get(RAY_ADDRESS):
        yield _connected()
        return
    try:
        import ray  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError as error:
        raise ImportError(f"cluster is {cluster or os.environ[RAY_ADDRESS]!r}, which needs Ray: "
                          "pip install ray") from error
    if ray.is_initialized():
        if cluster is not None:
            raise ValueError(f"cluster is {cluster!r}, but this program is connected to a Ray cluster; leave it out")
        yield ray
        return
    try:
        _reach(cluster or os.environ[RAY_ADDRESS])
        ray.init(address=cluster, log_to_driver=False, logging_level=logging.ERROR,
                 include_dashboard=False if cluster == "local" else None)
    except (OSError, ValueError) as error:
        raise ConnectionError(f"there is no Ray cluster at {cluster or os.environ[RAY_ADDRESS]!r}: {error}") from error
    try:
        yield ray
    finally:
        ray.shutdown()


def _reach(address: str) -> None:
    """OSError where nobody listens, for which Ray itself waits some minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()


def _connected() -> Any:
    """Ray, if this program has imported it and is connected."""
    ray = sys.modules.get("ray")
    return ray if ray is not None and ray.is_initialized() else None


class Progress:
    """Rows that are done, told to a function or shown by tqdm."""

    def __init__(self, wanted: bool | Callable[[int, int], object], rows: int):
        self.done, self.rows = 0, rows
        self.tell = wanted if callable(wanted) else None
        self.bar = progress_bar(rows, unit="row", unit_scale=True) if wanted is True else None

    def add(self, rows: int) -> None:
        self.done += rows
        if self.bar is not None:
            self.bar.update(rows)
        if self.tell is not None:
            self.tell(self.done, self.rows)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()


def run(task: Task, parts: Sequence[Any], paths: Sequence[Path | None], *, cluster: str | None, threads: int, retries: int,
        progress: bool | Callable[[int, int], object]) -> Generator[Report, None, None]:
    """Reports of all parts, in the order in which they end. The first error ends the work; so does Ctrl-C. What is written
    by then stays."""
    shown = Progress(progress, sum(part.rows for part in parts))
    schema = None
    try:
        missing = []
        for number, (part, path) in enumerate(zip(parts, paths)):
            if path is not None and path.exists():
                shown.add(part.rows)
                schema = schema_of(path) if schema is None else schema
                yield Report(number, schema)
            else:
                missing.append((number, part, path))
        with cluster_named(cluster) as ray:
            reports = _here(task, missing, threads) if ray is None else _over(ray, task, missing, retries)
            with contextlib.closing(reports):
                for report in reports:
                    if report.error is not None:
                        raise report.error
                    schema = report.schema if schema is None else schema
                    if report.schema != schema:
                        raise ValueError(f"results differ from part to part: {_columns(schema)} and {_columns(report.schema)}")
                    shown.add(parts[report.number].rows)
                    yield report
    finally:
        shown.close()


def _columns(schema: Any) -> str:
    return ", ".join(f"{field.name} ({field.type})" for field in schema)


# ------------------------------------------------------------------------------------------------------- files


class Output:
    """Where the parts of a job go: files of a folder, or of one beside the file that is made of them in the end.

    A folder says in `_axode.json` what it holds, and whether that is all. One process works in it at a time. `job` is everything
    that its results depend on.
    """

    def __init__(self, target: str | os.PathLike[str], job: Mapping[str, Any], parts: int, overwrite: bool):
        self.target = Path(target)
        self.is_file = self.target.suffix == ".parquet"
        self.folder = self.target.with_name(self.target.name + ".parts") if self.is_file else self.target
        self.identity: dict[str, str | None] = {}
        self.unknown: dict[str, str] = {}
        for name, value in job.items():
            try:
                self.identity[name] = digest(value)
            except Unknown as error:
                self.identity[name] = None
                self.unknown[name] = str(error)
        width = max(6, len(str(parts)))
        suffix = ".arrow" if self.is_file else ".parquet"
        self.paths = [self.folder / f"part-{number:0{width}}{suffix}" for number in range(parts)]
        if not self.target.parent.is_dir():
            raise FileNotFoundError(f"{self.target.parent}: there is no such folder")
        if self.is_file and self.target.exists() and not overwrite:
            raise FileExistsError(f"{self.target} is there already; overwrite=True replaces it")
        if self.is_file and self.target.is_dir() or not self.is_file and self.target.is_file():
            raise FileExistsError(f"{self.target} is a {'folder' if self.is_file else 'file'}; a name that ends in .parquet is "
                                  "one of a file, others are of folders")
        self.overwrite = overwrite

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """The folder is there and this process alone works in it."""
        self.folder.mkdir(exist_ok=True)
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise FileExistsError(f"{self.target}: another process is at work on it") from None
            self._begin()
            try:
                yield
            finally:
                if self.folder.exists():
                    self._leave()
        finally:
            os.close(lock)

    def _begin(self) -> None:
        manifest = self.folder / MANIFEST
        if not manifest.exists():
            if any(not file.name.startswith(f".{MANIFEST}") for file in self.folder.iterdir()):
                raise FileExistsError(f"{self.folder} is not empty, and what it holds is not of axode.distributed")
        else:
            if not self.overwrite:
                self._check_same(json.loads(manifest.read_text(encoding="utf-8")))
            else:
                self._say({})  # of no job, so that nothing is taken for what it is not if this is ended here
                self._clear("part-", ".")
        self._say({**self.identity, "complete": False})

    def _check_same(self, before: dict[str, Any]) -> None:
        """FileExistsError unless the parts that are there are known to be those of this job, and some are missing."""
        if before.get("complete"):
            raise FileExistsError(f"{self.target} is there already, and complete; overwrite=True replaces it")
        for name, value in self.identity.items():
            if name not in self.unknown and before.get(name) != value:
                raise FileExistsError(f"{self.folder} holds parts of another job: {name} is not the same; "
                                      "overwrite=True begins anew")
        for name, why in self.unknown.items():
            raise FileExistsError(f"{self.folder} holds parts of a job of which nobody can tell whether it is this one: {name} "
                                  f"{why}; overwrite=True begins anew")

    def _leave(self) -> None:
        """A folder without any part is none to go on with."""
        if not any(file.name.startswith("part-") for file in self.folder.iterdir()):
            self._clear(MANIFEST)
            self.folder.rmdir()

    def _clear(self, *beginnings: str) -> None:
        for file in self.folder.iterdir():
            if file.name.startswith(beginnings):
                file.unlink()

    def _say(self, what: dict[str, Any]) -> None:
        with replacing(self.folder / MANIFEST) as temporary:
            temporary.write_text(json.dumps(what, indent=1), encoding="utf-8")

    def write(self, reports: Iterator[Report]) -> list[Report]:
        """Takes the reports of all parts; what becomes one file grows in the order of its rows meanwhile."""
        found = list(self._joined(reports)) if self.is_file else list(reports)
        if self.is_file:
            self._clear("part-", ".", MANIFEST)
            self.folder.rmdir()
        else:
            self._clear(".")
            self._say({**self.identity, "complete": True})
        return found

    def _joined(self, reports: Iterator[Report]) -> Iterator[Report]:
        done: set[int] = set()
        with replacing(self.target, self.folder) as temporary, contextlib.ExitStack() as stack:
            writer, following = None, 0
            for report in reports:
                done.add(report.number)
                if writer is None:
                    writer = stack.enter_context(writer_to(temporary, ".parquet", report.schema))
                while following in done:
                    with pa.memory_map(str(self.paths[following])) as stream:
                        writer.write_table(pa.ipc.open_file(stream).read_all(), ROWS)
                    following += 1
                yield report

