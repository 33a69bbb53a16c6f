"""The pages show the real output of their code, and leave out no public name."""

import csv
import inspect
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import axode
import numpy as np
import pytest
from pages import SOURCE, blocks, printed_by_shell, run_page

PAGES = ["README.md", "docs/index.md", "docs/python.md", "docs/specialised.md", "docs/mobility.md",
         "docs/contact.md", "docs/parallel-manipulators.md",
         *sorted(file.relative_to(SOURCE).as_posix() for file in SOURCE.glob("docs/tutorials/*.md"))]
MODULES = [axode, axode.lie, axode.closed_form, axode.codegen, axode.convert, axode.drives, axode.fmi, axode.identification,
           axode.calibration, axode.table]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The environment of a user who has installed the command and the library."""
    release, prefix = SOURCE / "build/release", tmp_path_factory.mktemp("installed")
    if not (release / "axode").exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    subprocess.run(["cmake", "--install", release, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
    packages = next(prefix.rglob("axode.pc")).parent
    return {**os.environ, "PATH": f"{prefix / 'bin'}:{os.environ['PATH']}", "PKG_CONFIG_PATH": str(packages)}


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_shows_is_what_happens(page, installed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_page(page, installed)


@pytest.fixture
def robots(tmp_path, monkeypatch):
    """The working folder, with the mechanisms that come with the project."""
    for robot in axode.robots.iterdir():
        shutil.copy(robot, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_in_the_text_of_the_readme_runs_as_typed(robots, installed):
    for block in blocks("README.md"):
        if block.language == "console":
            printed_by_shell(block, installed)  # which leaves a state
    text = re.sub(r"^```.*?^```$", "", (SOURCE / "README.md").read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    commands = re.findall(r"`(axode [^`]+)`", text)
    assert len(commands) > 10 and any("simulate" in command for command in commands)
    if not shutil.which("axode_study", path=installed["PATH"]):  # `make test` does not build it
        commands = [command for command in commands if not command.startswith("axode study ")]
    for command in commands:
        done = subprocess.run(["sh", "-c", command], env=installed, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}: {done.stderr}"
    assert_moves("run.csv")


def assert_moves(table):
    """Expects that some coordinates in a table of a motion change."""
    with open(table, encoding="utf-8") as stream:
        names = next(csv.reader(stream))
        rows = np.array([[float(x) for x in row] for row in csv.reader(stream)])
    q = rows[:, [name.startswith("q ") for name in names]]
    assert np.abs(q - q[0]).max() > 0.05


@pytest.mark.parametrize("drawing", sorted(path.name for path in axode.robots.glob("*.toml")))
def test_a_mechanism_that_stands_still_as_drawn_says_how_it_moves(drawing, robots, installed):
    m = axode.load(drawing)
    motion = axode.simulate(m, m.neutral(), np.zeros(m.nv), until=0.05)
    stands_still = np.abs(motion.q - motion.q[0]).max() < 1e-6
    head = Path(drawing).read_text(encoding="utf-8").partition("format =")[0]
    lines = re.findall(r"^#   ( *(?:echo|axode) .*)$", head, re.MULTILINE)
    assert lines or not stands_still
    if lines:
        subprocess.run(["sh", "-c", "\n".join(lines)], env=installed, check=True, capture_output=True)
        assert_moves("run.csv")


@pytest.mark.parametrize("file", sorted(path.name for path in axode.robots.iterdir()))
def test_the_gallery_has_a_picture_and_commands_that_move_every_mechanism(file, robots, installed):
    page = (SOURCE / "docs/gallery.md").read_text(encoding="utf-8")
    sections = [part for part in re.split(r"^##+ ", page, flags=re.MULTILINE) if f"(../examples/robots/{file})" in part]
    assert len(sections) == 1
    picture, commands = re.search(r"^!\[.*\]\((.*)\)$.*?^```\n(.*?)\n```$", sections[0], re.MULTILINE | re.DOTALL).groups()
    assert (SOURCE / "docs" / picture).exists()
    assert commands.splitlines()[-1].startswith(f"axode view {file} ")
    subprocess.run(["sh", "-ec", f"{commands} --output page.html"], env=installed, check=True, capture_output=True)
    assert_moves("run.csv")


def test_every_link_leads_somewhere():
    done = subprocess.run([sys.executable, SOURCE / "tools/check_links.py"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_the_tables_list_the_public_names_and_no_others(module):
    page = (SOURCE / "docs/python.md").read_text(encoding="utf-8").partition("## All functions")[2]
    listed = []
    for heading, tables in re.findall(r"^### (.*?)\n(.*?)(?=^### |\Z)", page, re.MULTILINE | re.DOTALL):
        for first, second in re.findall(r"^\| ([^|]*) \|(.*)$", tables, re.MULTILINE):
            owner = first.split("`")[1] if heading == "Other modules" and "`" in first else heading.split(":")[0]
            if owner == module.__name__:
                listed += re.findall(r"`(\w+)`", second)
    assert len(listed) == len(set(listed))
    public = {name for name in module.__all__ if not inspect.ismodule(getattr(module, name))}
    # The reference has a table of all functions of a state, which is made from axode.table.
    by_hand = public - {*axode.table.ROWS} if module is axode else public
    assert by_hand <= set(listed) <= public


def test_the_reference_has_every_module():
    page = (SOURCE / "docs/reference/python.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"automodule:: (\S+)$", page, re.MULTILINE)) == sorted(module.__name__ for module in MODULES)


def test_the_packages_to_install_are_among_those_that_make_deps_installs():
    named = re.search(r"^sudo apt install (.*)$", (SOURCE / "docs/python.md").read_text(encoding="utf-8"), re.MULTILINE)
    installed = (SOURCE / "tools/install_dependencies.sh").read_text(encoding="utf-8").replace('"', " ")
    assert set(named[1].split()) <= set(installed.split())


def test_nothing_is_installed_by_the_name_of_a_package_that_is_in_no_index():
    for pattern in ("README.md", "docs/**/*.md", "python/axode/**/*.py", "apps/**/*.cpp"):
        for file in SOURCE.glob(pattern):
            assert not re.search(r"pip install ['\"]?axode\b", file.read_text(encoding="utf-8")), file


def test_no_bar_in_code_ends_the_cell_of_a_table():
    for file in [SOURCE / "README.md", *SOURCE.glob("docs/**/*.md")]:
        for line in file.read_text(encoding="utf-8").splitlines():
            if line.startswith("|"):
                cells = re.split(r"(?<!\\)\|", line)
                assert all(cell.count("`") % 2 == 0 for cell in cells), f"{file}: {line}"


def test_every_name_that_the_page_for_newcomers_gives_exists():
    page = (SOURCE / "docs/coming-from.md").read_text(encoding="utf-8").partition("## Pinocchio")[2]
    headers = "".join(file.read_text(encoding="utf-8") for file in (SOURCE / "axode").rglob("*.hpp"))
    rows = [row for row in re.findall(r"^\|(.*)\|$", page, re.MULTILINE) if "`" in row and "MultibodyPlant" not in row]
    assert len(rows) > 50
    for row in rows:
        _, python, cpp, _ = row.split("|")
        for name in re.findall(r"`(.*?)`", python):
            owner, _, last = name.rpartition(".")
            assert hasattr({"": axode, "m": axode.Model, "lie": axode.lie}[owner], last), name
        for name in re.findall(r"`(.*?)`", cpp):
            assert re.search(rf"(?:[\w>&] |class ){name}[ ({{]", headers), name
