"""`axode.view`: pages, and the states that are sent to them, as a browser receives them."""

import csv
import http.client
import json
import os
import resource
import shutil
import subprocess
import sys
import threading
import time
import warnings
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import urlsplit

import axode
import axode.viewer
import numpy as np
import pytest

pytestmark = pytest.mark.skipif(not axode.viewer.PAGE.exists(), reason="this build has no viewer: there was no npm")

SOURCE = Path(__file__).resolve().parents[2]
MODULES = SOURCE / "build/release/viewer/node_modules"
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
ARM = axode.load(axode.robots / "arm7.toml")
PENDULUM = axode.load(axode.robots / "double_pendulum.toml")
HOSTILE = '</script><script>alert(1)</script>" onload="alert(2)" & <b>\u2028'


class Elements(HTMLParser):
    """Parses a page: its elements with their attributes, and the text of the scene."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.scene = [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.elements and self.elements[-1][1].get("id") == "scene":
            self.scene += data


def scene_in(text):
    return json.loads(Elements(text).scene)


@pytest.fixture
def no_thread_is_left():
    before = set(threading.enumerate())
    yield
    assert set(threading.enumerate()) == before


def drawn():
    """The same mechanism from a file, a text, a dict, bodies and a Builder."""
    bodies = [{"name": "rod", "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]}, "mass": 1.0, "com": [0, 0, -0.5],
               "inertia": [1 / 12, 1 / 12, 1e-3], "shape": [{"kind": "box", "size": [0.1, 0.1, 1]}]}]
    built = axode.Model.from_bodies(bodies, name="pendulum")
    yield "from_bodies", built
    yield "from_dict", axode.Model.from_dict(built.to_dict())
    yield "read_drawing", axode.read_drawing(axode.drawing(built))
    yield "read_urdf", axode.read_urdf(axode.urdf(built))
    yield "Builder", axode.Builder("pendulum").body(**bodies[0]).build()
    yield "reduced", ARM.reduced(["A6"], ARM.neutral())
    yield "append", ARM.append("flange", built)


@pytest.mark.parametrize("name, m", list(drawn()), ids=lambda x: x if isinstance(x, str) else "")
def test_mechanisms_of_every_source_are_shown(name, m, tmp_path):
    axode.view(m, output=tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    scene = scene_in(text)
    assert scene["name"] == m.name and scene["nq"] == m.nq
    assert [body["name"] for body in scene["bodies"]] == ["ground", *m.body_names]
    assert scene["q"] == m.neutral().tolist() and scene["motion"] is None and "live" not in scene
    assert len(scene["shapes"]) >= m.n_bodies


def test_a_page_is_replaced_as_a_whole_or_left_as_it_was(tmp_path):
    page, link = tmp_path / "page.html", tmp_path / "link.html"
    page.write_text("precious")
    page.chmod(0o604)
    link.symlink_to("page.html")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            axode.view(PENDULUM, output=link)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert page.read_text() == "precious" and sorted(tmp_path.iterdir()) == [link, page]
    axode.view(PENDULUM, output=link)
    assert link.is_symlink() and scene_in(page.read_text(encoding="utf-8"))["name"] == PENDULUM.name
    assert page.stat().st_mode & 0o777 == 0o604 and sorted(tmp_path.iterdir()) == [link, page]
    axode.Viewer(PENDULUM).save("/dev/null")


def test_names_stay_text(tmp_path):
    m = axode.Builder(HOSTILE).body(HOSTILE, joint={"name": HOSTILE, "kind": "revolute", "axis": "x", "point": [0, 0, 0]}, mass=1.0,
                                    com=[0, 0, 0], inertia=[1, 1, 1]).build()
    plain = axode.Builder("plain").body("plain", joint={"name": "joint", "kind": "revolute", "axis": "x", "point": [0, 0, 0]}, mass=1.0,
                                        com=[0, 0, 0], inertia=[1, 1, 1]).build()
    viewer = axode.Viewer(m)
    pages = []
    for number, each in enumerate([viewer, axode.Viewer(plain)]):
        each.save(tmp_path / f"{number}.html")
        pages.append((tmp_path / f"{number}.html").read_text(encoding="utf-8"))
    assert Elements(pages[0]).elements == Elements(pages[1]).elements
    assert scene_in(pages[0])["name"] == scene_in(pages[0])["bodies"][1]["name"] == HOSTILE
    frames = Elements(viewer._repr_html_()).elements
    assert [tag for tag, _ in frames] == ["iframe"] and set(frames[0][1]) == {"srcdoc", "title", "style"}
    assert frames[0][1]["title"] == HOSTILE and scene_in(frames[0][1]["srcdoc"])["name"] == HOSTILE
    viewer.close()


def test_motions_and_files_of_motions_are_the_same(tmp_path):
    motion = axode.simulate(PENDULUM, [2, 0.5], [0.1, 0.2], until=0.5, times=np.linspace(0, 0.5, 11))
    arrays = {"t": motion.t, "q": motion.q, "v": motion.v, "a": motion.a, "tau": motion.tau}
    np.savez(tmp_path / "run.npz", **arrays)
    (tmp_path / "run.json").write_text(json.dumps({name: array.tolist() for name, array in arrays.items()}))
    with (tmp_path / "run.csv").open("w", newline="") as file:
        writer = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC)
        names = PENDULUM.velocity_names
        writer.writerow(["t", *(f"{what} {name}" for what in ("q", "v", "a", "tau") for name in names), "energy"])
        for k in range(11):
            writer.writerow([motion.t[k], *motion.q[k], *motion.v[k], *motion.a[k], *motion.tau[k], 0.0])
    axode.view(PENDULUM, motion=motion, output=tmp_path / "page.html")
    scene = scene_in((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert scene["q"] == motion.q[0].tolist()
    for name in ("t", "q", "v", "tau"):
        np.testing.assert_array_equal(scene["motion"][name], arrays[name])
    np.testing.assert_allclose([row[-1] for row in scene["motion"]["series"][0]["values"]], motion.energy, atol=1e-12)
    np.testing.assert_allclose(scene["motion"]["momenta"],
                               [axode.body_momenta(PENDULUM, *state, "spatial") for state in zip(motion.q, motion.v)],
                               atol=1e-12)
    for ending in ("npz", "json", "csv"):
        axode.view(PENDULUM, motion=tmp_path / f"run.{ending}", output=tmp_path / "other.html")
        assert scene_in((tmp_path / "other.html").read_text(encoding="utf-8")) == scene
    axode.view(PENDULUM, [1, 1], str(tmp_path / "run.csv"), output=str(tmp_path / "other.html"))
    assert scene_in((tmp_path / "other.html").read_text(encoding="utf-8"))["q"] == [1, 1]


def test_loads_of_a_motion_are_shown_however_they_are_given(tmp_path):
    page = tmp_path / "page.html"
    weight = axode.Load(frame="flange", representation="hybrid", wrench=[0, 0, 0, 0, 0, -20])
    times = np.linspace(0, 0.2, 5)
    motion = axode.simulate(ARM, np.full(7, 0.3), np.zeros(7), until=0.2, times=times, loads=[weight])

    def shown(given, loads=None):
        axode.view(ARM, motion=given, loads=loads, output=page)
        return scene_in(page.read_text(encoding="utf-8"))["motion"]

    scene = shown(motion, [weight])
    assert [(frame["name"], frame["body"]) for frame in scene["load_frames"]] == [("flange", 7)]
    flange = ARM.frame_names.index("flange")
    for k, q in enumerate(motion.q):
        place = axode.poses(ARM, q)[flange, :3, 3]
        np.testing.assert_allclose(scene["loads"][k][0], [*np.cross(place, [0, 0, -20]), 0, 0, -20], atol=1e-12)
    assert shown(motion, lambda t, q, v: [weight]) == scene
    assert shown(motion)["loads"] is None
    assert shown(motion)["wrenches"] != scene["wrenches"]
    growing = shown(motion, lambda t, q, v: [{**weight, "wrench": [0, 0, 0, 0, 0, -20 * t]}] if t > 0.1 else [])
    np.testing.assert_allclose([row[0][5] for row in growing["loads"]], np.where(times > 0.1, -20 * times, 0), atol=1e-12)

    row = np.tile([0.0, 0, 0, 0, 0, -20], (5, 1))
    arrays = {"t": motion.t, "q": motion.q, "v": motion.v, "a": motion.a, "tau": motion.tau, "loads": row}
    np.savez(tmp_path / "run.npz", load_frames=[float(flange)], **arrays)
    (tmp_path / "run.json").write_text(json.dumps({name: array.tolist() for name, array in arrays.items()} | {"load_frames": ["flange"]}))
    with (tmp_path / "run.csv").open("w", newline="") as file:
        writer = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC)
        writer.writerow(["t", *(f"q {name}" for name in ARM.coordinate_names),
                         *(f"{what} {name}" for what in ("v", "a", "tau") for name in ARM.velocity_names),
                         *(f"load {what}: flange {axis}" for what in ("moment", "force") for axis in "xyz")])
        for k in range(5):
            writer.writerow([motion.t[k], *motion.q[k], *motion.v[k], *motion.a[k], *motion.tau[k], *row[k]])
    for ending in ("npz", "json", "csv"):
        assert shown(tmp_path / f"run.{ending}") == scene
    (tmp_path / "run.json").write_text(json.dumps({name: array.tolist() for name, array in arrays.items()} | {"load_frames": ["flange"] * 2}))
    with pytest.raises(ValueError, match="2 loaded frames have 12 columns"):
        shown(tmp_path / "run.json")
    with pytest.raises(ValueError, match="give motion as well"):
        axode.view(ARM, loads=[weight], output=page)
    with pytest.raises(KeyError, match='no frame "flang"; did you mean "flange"'):
        shown(motion, [{**weight, "frame": "flang"}])


def test_states_and_motions_that_do_not_fit_are_refused(tmp_path, no_thread_is_left):
    page = tmp_path / "page.html"
    motion = axode.simulate(PENDULUM, [2, 0.5], [0.1, 0.2], until=0.1)
    (tmp_path / "a.json").write_text("[1]")
    (tmp_path / "a.csv").write_text("t,q pin\n0,1\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "none.csv").write_text("t,q pin,q elbow,v pin,v elbow\n")
    (tmp_path / "cut.csv").write_text("t,q pin,q elbow,v pin,v elbow\n0,1,1,1,1\n0,1\n")
    (tmp_path / "word.csv").write_text("t,q pin,q elbow,v pin,v elbow\n0,1,x,1,1\n")
    (tmp_path / "twice.csv").write_text("t,q pin,q elbow,v pin,v elbow,q pin\n0,1,1,1,1,1\n")
    (tmp_path / "thousands.csv").write_text("t,q pin,q elbow,v pin,v elbow\n0,1_000,1,1,1\n")
    (tmp_path / "latin.csv").write_bytes("t,q pin,ö\n".encode("latin-1"))
    (tmp_path / "cut.json").write_text('{"t": [0')
    (tmp_path / "deep.json").write_text("[" * 100_000)
    state = {"t": [0.0], "q": [[1.0, 1.0]], "v": [[0.0, 0.0]]}
    (tmp_path / "other.json").write_text(json.dumps(state | {"coordinates": ["elbow", "pin"]}))
    (tmp_path / "ragged.json").write_text(json.dumps(state | {"q": [[1.0, 1.0], [1.0]]}))
    for name, value in [("t", None), ("q", 1.0), ("q", []), ("v", [[1.0]])]:
        (tmp_path / f"{name} {value}.json").write_text(json.dumps(state | {name: value}))
    np.savez(tmp_path / "whole.npz", t=motion.t, q=motion.q)
    np.save(tmp_path / "one.npy", motion.t)
    (tmp_path / "cut.npz").write_bytes((tmp_path / "whole.npz").read_bytes()[:-30])
    (tmp_path / "one.npy").rename(tmp_path / "one.npz")
    for arguments, words in [((ARM, np.zeros(6)), "q"), ((ARM, [np.nan] * 7), "q"), ((ARM, np.zeros((2, 7))), "q"),
                             ((ARM, ARM.neutral(), motion), r"motion.q"), ((ARM, None, "run.txt"), "none of .csv, .json, .npz"),
                             ((PENDULUM, None, tmp_path / "a.json"), "has no t and no q and no v"),
                             ((PENDULUM, None, tmp_path / "a.csv"), "has no q and no v of model"),
                             ((PENDULUM, None, tmp_path / "empty.csv"), "has no t"),
                             ((PENDULUM, None, tmp_path / "none.csv"), "has no states"),
                             ((PENDULUM, None, tmp_path / "cut.csv"), "cut.csv: line 3 has 2 columns; the first line has 5"),
                             ((PENDULUM, None, tmp_path / "word.csv"), 'line 2: column "q elbow" has "x", which is not a number'),
                             ((PENDULUM, None, tmp_path / "twice.csv"), 'twice.csv: the column "q pin" is given more than once'),
                             ((PENDULUM, None, tmp_path / "thousands.csv"), 'line 2: column "q pin" has "1_000"'),
                             ((PENDULUM, None, tmp_path / "latin.csv"), "latin.csv is not UTF-8"),
                             ((PENDULUM, None, tmp_path / "cut.json"), "cut.json is not JSON"),
                             ((PENDULUM, None, tmp_path / "deep.json"), "deep.json is not JSON"),
                             ((PENDULUM, None, tmp_path / "other.json"), r"its coordinates are \['elbow', 'pin'\]; those of"),
                             ((PENDULUM, None, tmp_path / "ragged.json"), "rows of unequal length"),
                             *[((PENDULUM, None, tmp_path / f"{name}.json"), r"t, q and v have the shapes .*; those of a motion")
                               for name in ("t None", "q 1.0", "q []", "v [[1.0]]")],
                             ((PENDULUM, None, tmp_path / "whole.npz"), "has no v"),
                             ((PENDULUM, None, tmp_path / "cut.npz"), "is not an .npz"),
                             ((PENDULUM, None, tmp_path / "one.npz"), "is not an .npz")]:
        with pytest.raises(ValueError, match=words):
            axode.view(*arguments, output=page)
    for what, kind in [(np.zeros((5, 7)), "ndarray"), ([[0.0] * 7], "list"), (3, "int")]:
        with pytest.raises(TypeError, match=f"^motion is of type {kind}; expected a Trajectory"):
            axode.view(ARM, motion=what, output=page)
    assert not page.exists()
    viewer = axode.Viewer(ARM)
    for q in (np.zeros(6), [np.inf] * 7, np.zeros((1, 7)), "here"):
        with pytest.raises(ValueError):
            viewer.push(q)
    viewer.close()
    with pytest.raises(ValueError, match="closed"):
        viewer.push(np.zeros(7))


def test_meshes_are_shown_or_told_of(tmp_path):
    (tmp_path / "a.stl").write_text("solid\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n")
    (tmp_path / "r.urdf").write_text('<robot name="r"><link name="base">' + "".join(
        f'<visual><geometry><mesh filename="{name}.stl"/></geometry></visual>' for name in "ab") + "</link></robot>")
    viewer = axode.Viewer(axode.load(tmp_path / "r.urdf"))
    assert viewer.meshes == [str(tmp_path / "a.stl")]
    assert len(viewer.warnings) == 1 and 'mesh "b.stl" is not shown' in viewer.warnings[0]


class Listener:
    """A client that receives the states of a viewer, as a page does."""

    def __init__(self, live):
        where = urlsplit(live)
        self.connection = http.client.HTTPConnection(where.hostname, where.port, timeout=120)
        self.connection.request("GET", where.path)
        self.answer = None

    def next(self):
        self.answer = self.answer or self.connection.getresponse()
        assert self.answer.status == 200 and self.answer.headers["Content-Type"] == "text/event-stream"
        while line := self.answer.readline():
            if line.startswith(b"data: "):
                return json.loads(line[6:])["q"]
        return None


def live_in(viewer):
    return scene_in(dict(Elements(viewer._repr_html_()).elements[0][1])["srcdoc"])["live"]


def test_states_are_pushed_to_who_knows_the_address(no_thread_is_left):
    viewer = axode.Viewer(ARM)
    live = live_in(viewer)
    early = Listener(live)  # before anything is pushed
    states = ARM.random(n=3)
    viewer.push(states[0])
    assert early.next() == states[0].tolist()
    late = Listener(live)
    assert late.next() == states[0].tolist()
    for state in states[1:]:
        viewer.push(state)
        assert early.next() == late.next() == state.tolist()
    where = urlsplit(live)
    for path in ("/", "/states", where.path[:-1], "/../" + where.path, where.path + "/"):
        connection = http.client.HTTPConnection(where.hostname, where.port, timeout=120)
        connection.request("GET", path)
        assert connection.getresponse().status == 404
        connection.close()
    silent = http.client.HTTPConnection(where.hostname, where.port, timeout=120)
    silent.connect()  # and asks for nothing, as browsers do ahead of time
    time.sleep(0.1)
    closing = threading.Thread(target=lambda: (viewer.close(), viewer.close()), daemon=True)
    closing.start()
    closing.join(timeout=120)
    assert not closing.is_alive(), "the viewer waits for a browser that says nothing"
    assert early.next() is None
    with pytest.raises(OSError):
        http.client.HTTPConnection(where.hostname, where.port, timeout=2).connect()
    for connection in (early.connection, late.connection, silent):
        connection.close()


def test_nothing_listens_until_a_page_is_shown(no_thread_is_left):
    viewer = axode.Viewer(ARM)
    assert viewer._server is None
    live_in(viewer)
    assert viewer._server._thread is None
    viewer.push(np.zeros(7))
    assert viewer._server._thread.is_alive()
    del viewer  # which closes it


BROWSER = """#!{python}
import sys, urllib.request
open("{seen}", "wb").write(urllib.request.urlopen(sys.argv[1]).read())
"""


def test_a_script_opens_a_browser_and_ends_when_the_page_is_there(tmp_path):
    browser = tmp_path / "browser"
    browser.write_text(BROWSER.format(python=sys.executable, seen=tmp_path / "seen.html"))
    browser.chmod(0o700)
    script = "import axode\naxode.view(axode.load(axode.robots / 'arm7.toml'))\n"
    done = subprocess.run([sys.executable, "-c", script], env={**os.environ, "BROWSER": str(browser)}, timeout=120,
                          capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    scene = scene_in((tmp_path / "seen.html").read_text(encoding="utf-8"))
    assert scene["name"] == "arm7" and scene["live"].startswith("http://127.0.0.1:")


def test_where_there_is_no_browser_the_address_is_told(monkeypatch, no_thread_is_left):
    monkeypatch.setattr(axode.viewer.webbrowser, "open", lambda url: False)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        viewer = axode.view(ARM)
    assert "no browser could be opened; the page is at http://127.0.0.1:" in str(said[0].message)
    viewer.close()


class Browser:
    """A headless Chromium that returns the poses of the bodies on a page."""

    def __init__(self):
        self.node = subprocess.Popen(["node", Path(__file__).with_name("page_poses.mjs"), MODULES, CHROMIUM],
                                     stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def poses(self, address=""):
        self.node.stdin.write(address + "\n")
        self.node.stdin.flush()
        line = self.node.stdout.readline()
        return {name: np.reshape(C, (4, 4)).T for name, C in json.loads(line).items()}

    def expect(self, m, q, address=""):
        """Expects that the page shows the poses at q, at once or after a short time."""
        expected = dict(zip(["ground", *m.body_names], axode.poses(m, q)))
        size = max(1.0, np.abs(axode.poses(m, q)).max())
        deadline = time.monotonic() + 60
        while True:
            found = self.poses(address)
            off = max(np.abs(found[name] - expected[name]).max() for name in expected)
            if off < 1e-9 * size or time.monotonic() > deadline:
                break
            address = ""
            time.sleep(0.05)
        assert found.keys() == expected.keys() and off < 1e-9 * size, off


@pytest.fixture
def browser():
    if not (CHROMIUM and MODULES.exists() and shutil.which("node")):
        pytest.skip("there is no Chromium, no node, or no build/release/viewer")
    browser = Browser()
    yield browser
    browser.node.stdin.close()
    browser.node.stdout.close()
    assert browser.node.wait(30) == 0


def test_pages_show_what_is_pushed(browser, tmp_path, monkeypatch):
    """Pages show the states that are sent to them, with joints of every kind: in a notebook, and from a script that
    opened a browser. All of it uses one browser, which takes long to start."""
    for file, held in [("machine.toml", None), ("humanoid.urdf", "free")]:
        m = axode.load(axode.robots / file, held)
        q = m.random(seed=1, n=3)
        viewer = axode.Viewer(m, q[0])
        notebook = tmp_path / f"{m.name}.html"
        notebook.write_text(f"<!doctype html><meta charset=utf-8>{viewer._repr_html_()}", encoding="utf-8")
        browser.expect(m, q[0], notebook.as_uri())
        for state in q[1:]:
            viewer.push(state)
            browser.expect(m, state)
        viewer.close()
        browser.expect(m, q[2])
    opened = []
    monkeypatch.setattr(axode.viewer.webbrowser, "open", lambda url: opened.append(url) or True)
    viewer = axode.view(ARM, np.full(7, 0.1))
    browser.expect(ARM, np.full(7, 0.1), opened[0])
    viewer.push(np.full(7, -0.2))
    browser.expect(ARM, np.full(7, -0.2))
    viewer.close()
