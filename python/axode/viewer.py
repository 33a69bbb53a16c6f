"""Mechanisms in a browser: `view`."""

from __future__ import annotations

import csv
import html
import io
import json
import operator
import os
import secrets
import socket
import sys
import threading
import warnings
import weakref
import webbrowser
import zipfile
from collections.abc import Callable, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _axode
from .support import signatures
from ._axode import Model, Trajectory
from .records import Load
from .support.written_files import replacing

__all__ = ["Viewer", "view"]

PAGE = Path(__file__).parent / "share/axode/viewer/page.html"
Contacts = tuple[list[str], list[NDArray[np.float64]]]
"""The names of the collision shapes, and for each time the points of contact, 17 numbers each, as in a page."""
Motion = tuple[Any, Any, Any, Any, Any, Trajectory | Contacts | None, list[Load] | None]
"""t, q, v, a and tau, the latter two perhaps None, the contacts, and the loads with a wrench for each time."""
Loads = Sequence[Load] | Callable[[float, NDArray[np.float64], NDArray[np.float64]], Sequence[Load]]


def _contacts_in(found: dict[str, Any], file: Path) -> Contacts | None:
    """The points of contact in the JSON of `axode simulate`."""
    if "contacts" not in found:
        return None
    branches = ("open", "stick", "slide")
    try:
        shapes = [str(name) for name in found["contact_shapes"]]
        number = {name: float(k) for k, name in enumerate(shapes)}
        rows = [[[number[x["a"]], number[x["b"]], *x["point"], *x["normal"], x["gap"], *x["force"], *x["moment"],
                  x["friction"], branches.index(x["status"])] for x in at_once] for at_once in found["contacts"]]
        return shapes, [np.array(at_once, dtype=np.float64).reshape(len(at_once), 17) for at_once in rows]
    except (KeyError, OverflowError, TypeError, ValueError) as error:
        raise ValueError(f"motion: the contacts in {file} lack a key or have a wrong value; "
                         "write the file with `axode simulate --output`") from error


def _loads_in(frames: Sequence[Any], numbers: Any, file: Path) -> list[Load]:
    """The loads in a file of `axode simulate`: a moment and a force for each frame, in inertial axes about its origin."""
    rows = np.asarray(numbers, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 6 * len(frames):
        raise ValueError(f"motion: the loads in {file} have the shape {rows.shape}; {len(frames)} loaded frames have "
                         f"{6 * len(frames)} columns")
    return [Load(frame=frame, representation="hybrid", wrench=rows[:, 6 * k:6 * k + 6]) for k, frame in enumerate(frames)]


def _loads_of(motion: Motion, loads: Loads) -> list[Load]:
    """The loads that were given to `simulate`. If a function computes them, there is a wrench for each time."""
    if not callable(loads):
        return list(loads)
    t, q, v = (np.asarray(x, dtype=np.float64) for x in motion[:3])
    sums: dict[tuple[str | int, Any], NDArray[np.float64]] = {}
    for k in range(len(t)):
        for load in loads(float(t[k]), q[k].copy(), v[k].copy()):
            of = load["frame"], load.get("representation", "body")
            sums.setdefault(of, np.zeros((len(t), 6)))[k] += np.asarray(load["wrench"], dtype=np.float64)
    return [Load(frame=frame, representation=representation, wrench=wrench)
            for (frame, representation), wrench in sums.items()]


def _text_in(file: Path) -> str:
    try:
        return file.read_bytes().decode("utf-8-sig")  # without a byte order mark
    except UnicodeDecodeError as error:
        raise ValueError(f"motion: {file} is not UTF-8; save it as UTF-8 text") from error


def _json_in(file: Path) -> Any:
    text = _text_in(file)
    try:
        return json.loads(text)
    except (RecursionError, ValueError) as error:
        raise ValueError(f"motion: {file} is not JSON: {error}") from error


def _table_in(file: Path) -> tuple[list[str], NDArray[np.float64]]:
    """The headings and the numbers of a CSV file."""
    reader = csv.reader(io.StringIO(_text_in(file), newline=""))
    try:
        (_, headings), *rows = [(reader.line_num, row) for row in reader if row] or [(1, [])]
    except csv.Error as error:
        raise ValueError(f"motion: {file}: line {reader.line_num}: {error}") from error
    if twice := [heading for heading in headings if headings.count(heading) > 1]:
        raise ValueError(f'motion: {file}: the column "{twice[0]}" is given more than once')
    numbers = np.empty((len(rows), len(headings)))
    for k, (line, row) in enumerate(rows):
        if len(row) != len(headings):
            raise ValueError(f"motion: {file}: line {line} has {len(row)} columns; "
                             f"the first line has {len(headings)}")
        for c, (heading, cell) in enumerate(zip(headings, row)):
            try:
                numbers[k, c] = float(cell.replace("_", "no number"))  # 1_0 is a number of Python alone
            except ValueError as error:
                raise ValueError(f'motion: {file}: line {line}: column "{heading}" has "{cell}", '
                                 "which is not a number") from error
    return headings, numbers


def _check_fit(m: Model, found: dict[str, Any], file: Path) -> None:
    """Refuses the motion of another mechanism, and arrays that have no row for each time."""
    for key, names in (("coordinates", m.coordinate_names), ("velocities", m.velocity_names)):
        if found.get(key, list(names)) != list(names):
            raise ValueError(f'motion: {file}: its {key} are {found[key]}; those of model "{m.name}" are {list(names)}')
    try:
        t, q, v = (np.shape(found[name]) for name in ("t", "q", "v"))
    except ValueError as error:
        raise ValueError(f"motion: {file} has rows of unequal length in t, q or v") from error
    if t == (0,):
        raise ValueError(f"motion: {file} has no states")
    if len(t) != 1 or q != (*t, m.nq) or v != (*t, m.nv):
        raise ValueError(f'motion: {file}: t, q and v have the shapes {t}, {q} and {v}; those of a motion of model "{m.name}" '
                         f"are (N,), (N, {m.nq}) and (N, {m.nv})")


def _motion_in(m: Model, file: Path) -> Motion:
    """Reads a motion from a file of `axode simulate --output`."""
    names = ("t", "q", "v", "a", "tau")
    if file.suffix == ".npz":
        try:
            with np.load(file, allow_pickle=False) as arrays:
                found = {name: arrays[name] for name in (*names, "loads", "load_frames") if name in arrays}
            if "load_frames" in found:
                found["load_frames"] = [operator.index(int(frame) if frame == int(frame) else frame)
                                        for frame in found["load_frames"]]
        except (zipfile.BadZipFile, EOFError, TypeError, ValueError) as error:
            raise ValueError(f"motion: {file} is not an .npz of arrays") from error
    elif file.suffix == ".json":
        found = _json_in(file)
    elif file.suffix == ".csv":
        headings, numbers = _table_in(file)
        place = {heading: k for k, heading in enumerate(headings)}
        columns = {"t": ["t"], "q": [f"q {name}" for name in m.coordinate_names],
                   **{what: [f"{what} {name}" for name in m.velocity_names] for what in ("v", "a", "tau")}}
        found = {what: numbers[:, [place[column] for column in wanted]]
                 for what, wanted in columns.items() if all(column in place for column in wanted)}
        if "t" in found:
            found["t"] = found["t"][:, 0]
        of_frames = {frame: [f"load {what}: {frame} {axis}" for what in ("moment", "force") for axis in "xyz"]
                     for frame in m.frame_names}
        found["load_frames"] = [frame for frame, wanted in of_frames.items() if all(column in place for column in wanted)]
        found["loads"] = numbers[:, [place[column] for frame in found["load_frames"] for column in of_frames[frame]]]
    else:
        raise ValueError(f"motion: {file} is none of .csv, .json, .npz")
    missing = [name for name in names[:3] if not isinstance(found, dict) or name not in found]
    if missing:
        raise ValueError(f"motion: {file} has no {' and no '.join(missing)} of model \"{m.name}\"")
    _check_fit(m, found, file)
    t, q, v, a, tau = (found.get(name) for name in names)
    loads = _loads_in(found["load_frames"], found["loads"], file) if found.get("load_frames") and "loads" in found else None
    return t, q, v, a, tau, _contacts_in(found, file), loads


def _motion_of(m: Model, motion: Trajectory | str | os.PathLike[str] | None) -> Motion | None:
    if motion is None:
        return None
    if isinstance(motion, Trajectory):
        return motion.t, motion.q, motion.v, motion.a, motion.tau, motion, None
    if not isinstance(motion, (str, os.PathLike)):
        raise TypeError(f"motion is of type {type(motion).__name__}; expected a Trajectory, which has times as well, such as "
                        "`simulate` gives, or the name of a file .csv, .json or .npz with t, q and v")
    return _motion_in(m, Path(motion))


def _is_in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config


class _Answer(BaseHTTPRequestHandler):
    """The answer to one request: the page, or the states that are pushed, as long as the browser listens."""

    server: _Server

    def handle(self) -> None:
        try:
            super().handle()
        except OSError:  # the browser has gone, or the viewer was closed
            pass

    def do_GET(self) -> None:
        if self.path == self.server.path:
            self._begin("text/html; charset=utf-8")
            self.wfile.write(self.server.page())
            self.wfile.flush()
            self.server.seen.set()
        elif self.path == self.server.path + "states":
            self._begin("text/event-stream")
            for state in self.server.states():
                self.wfile.write(f"data: {state}\n\n".encode() if state else b":\n\n")
        else:
            self.send_error(404)

    def _begin(self, kind: str) -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Access-Control-Allow-Origin", "*")  # the page of a notebook has no origin
        self.end_headers()

    def log_message(self, *_: Any) -> None:
        pass


class _Server(ThreadingHTTPServer):
    """Serves one page, and states to it, to programs of this machine that know a random path. It listens from the
    construction on, and answers after `start`.
    """

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Answer)
        self.path = f"/{secrets.token_urlsafe(16)}/"
        self.url = f"http://127.0.0.1:{self.server_port}{self.path}"
        self.text = ""
        self.seen = threading.Event()
        self.is_awaited = False
        self._answering: dict[threading.Thread, socket.socket] = {}
        self._told = threading.Condition()
        self._state, self._number, self._closed = "", 0, False
        self._thread: threading.Thread | None = None

    def page(self) -> bytes:
        return self.text.encode()

    def start(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self.serve_forever, args=(0.05,), daemon=True, name="axode viewer")
            self._thread.start()

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answers in a thread, for which `close` waits. Python would wait for a thread that is no daemon before it calls
        `close`."""
        self._answering = {thread: connection for thread, connection in self._answering.items() if thread.is_alive()}
        thread = threading.Thread(target=self.process_request_thread, args=(request, client_address), daemon=True)
        self._answering[thread] = request
        thread.start()

    def push(self, state: str) -> None:
        with self._told:
            self._state, self._number = state, self._number + 1
            self._told.notify_all()

    def states(self) -> Any:
        """Yields the newest state as soon as there is one, and "" from time to time, to find out whether a browser
        still listens."""
        number = 0
        while True:
            with self._told:
                is_new = self._told.wait_for(lambda: self._closed or self._number != number, timeout=10)
                if self._closed:
                    return
                number = self._number
                state = self._state if is_new else ""
            yield state

    def close(self) -> None:
        if self.is_awaited:
            self.seen.wait(10)
        with self._told:
            self._closed = True
            self._told.notify_all()
        if self._thread is not None:
            self.shutdown()
            self._thread.join()
        self.server_close()
        for thread, connection in self._answering.items():
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            thread.join()

    def handle_error(self, *_: Any) -> None:
        pass


class Viewer:
    """A mechanism on a page, from `view`. In a notebook it shows itself.

    `warnings` are those of the model and of meshes that are not shown; `meshes` are the files of those that are.

    >>> viewer = axode.Viewer(arm)
    >>> viewer.push(np.full(7, 0.1))  # wherever the page is open, the arm moves there
    >>> viewer.close()
    """

    def __init__(self, m: Model, q: ArrayLike | None = None,
                 motion: Trajectory | str | os.PathLike[str] | None = None, loads: Loads | None = None) -> None:
        if not PAGE.exists():
            raise RuntimeError("this build of axode has no viewer; build it with npm installed")
        self._m = m
        self._motion = _motion_of(m, motion)
        if loads is not None:
            if self._motion is None:
                raise ValueError(f'loads are shown in a motion of model "{m.name}"; give motion as well')
            self._motion = (*self._motion[:-1], _loads_of(self._motion, loads))
        self._q: Any = q if q is not None else _axode.first_configuration(m) if self._motion is None else np.asarray(self._motion[1])[0]
        self._server: _Server | None = None
        self._finalizer: Any = None
        self._is_closed = False
        self._page, self.warnings, self.meshes = self._written("")

    def _written(self, live: str) -> tuple[str, list[str], list[str]]:
        return _axode.viewer_page(self._m, PAGE.read_text(encoding="utf-8"), self._q, self._motion, live)

    def _listening(self) -> _Server:
        """The server, after a page has connected to it."""
        if self._is_closed:
            raise ValueError("the viewer is closed")
        if self._server is None:
            self._server = _Server()
            self._finalizer = weakref.finalize(self, self._server.close)
            self._server.text = self._written(self._server.url + "states")[0]
        return self._server

    def open(self) -> None:
        """Opens the page in a browser, from a server on this machine."""
        server = self._listening()
        server.start()
        if webbrowser.open(server.url):
            server.is_awaited = True
        else:
            warnings.warn(f"no browser could be opened; the page is at {server.url}", stacklevel=2)

    def push(self, q: ArrayLike) -> None:
        """Moves the mechanism to q (nq,), wherever its page is open: in a browser or in a notebook on this machine."""
        numbers = np.asarray(q, dtype=np.float64)
        if numbers.ndim != 1:
            raise ValueError(f"q: expected shape ({self._m.nq},), got {numbers.shape}")
        _axode.poses(self._m, numbers)  # refuses numbers that are not a configuration
        server = self._listening()
        server.push(json.dumps({"q": numbers.tolist()}))
        server.start()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page: one file of HTML that needs no other file and no network. An existing file is replaced as
        a whole or, if the page cannot be written, left as it was."""
        with replacing(Path(path)) as file:
            file.write_text(self._page, encoding="utf-8")

    def close(self) -> None:
        """Ends the connection to pages, which remain as they are. It waits at most 10 s for a page that was opened."""
        self._is_closed = True
        if self._finalizer is not None:
            self._finalizer()

    def _repr_html_(self) -> str:
        page = self._page if self._is_closed else self._listening().text
        return (f'<iframe srcdoc="{html.escape(page, quote=True)}" title="{html.escape(self._m.name, quote=True)}" '
                'style="width: 100%; height: 600px; border: 0"></iframe>')


def view(m: Model, q: ArrayLike | None = None, motion: Trajectory | str | os.PathLike[str] | None = None, *,
         loads: Loads | None = None, output: str | os.PathLike[str] | None = None) -> Viewer:
    """Shows a mechanism, at q (nq,), or in its initial state with loops closed, and a motion of it: in a notebook there, otherwise in a browser.

    motion: from `simulate`, or the .csv, .json or .npz that `axode simulate --output` has written.
    loads: the loads of the motion, as `simulate` took them, which a Trajectory does not have. They are drawn, and act in
        the wrenches of joints. Files that `axode simulate --output` has written have their own.
    output: a file of HTML to write instead of showing it; it needs no other file and no network.

    `Viewer.push(q)` moves it on the page, `Viewer.save(path)` writes the page, `Viewer.close()` ends the connection.
    Meshes are searched beside the file that names them and in the packages of ROS; `Viewer.warnings` lists those that
    are missing. Bodies without a visible shape are drawn from their joints and inertia.

    ValueError for a state or a motion that does not fit the model, TypeError for an object that is not a motion.
    RuntimeError if the package was built without npm.

    >>> import pathlib, tempfile
    >>> fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=0.5)
    >>> page = pathlib.Path(tempfile.mkdtemp()) / "fall.html"
    >>> axode.view(arm, motion=fall, output=page).warnings
    []
    >>> page.read_text().startswith("<!doctype html>")
    True
    """
    viewer = Viewer(m, q, motion, loads)
    if output is not None:
        viewer.save(output)
    elif not _is_in_notebook():
        viewer.open()
    return viewer


signatures.explain_calls(__name__)
