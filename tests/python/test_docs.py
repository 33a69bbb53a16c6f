"""What docs/python.md and the first page show is what happens, and nothing public is left out."""

import contextlib
import inspect
import io
import re
from pathlib import Path

import axode
import pytest

SOURCE = Path(__file__).resolve().parents[2]
PAGES = ["docs/python.md", "README.md"]
MODULES = [axode, axode.lie, axode.closed_form, axode.codegen, axode.convert, axode.drives, axode.identification,
           axode.calibration]


def blocks(page):
    """(line, language, text) of the blocks of code."""
    text = (SOURCE / page).read_text(encoding="utf-8")
    for found in re.finditer(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, found.start()) + 2, found[1], found[2]


@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_python_runs_and_prints_what_is_shown(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names, shown = {"__name__": "__main__"}, list(blocks(page))
    assert "python" in [language for _, language, _ in shown]
    for (line, language, code), (_, next_language, output) in zip(shown, [*shown[1:], (0, "none", "")]):
        if language != "python":
            continue
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile("\n" * (line - 1) + code, page, "exec"), names)
        assert printed.getvalue() == (output if next_language in ("", "text") else ""), f"{page}:{line}"


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__)
def test_the_tables_list_the_public_names_and_no_others(module):
    page = (SOURCE / "docs/python.md").read_text(encoding="utf-8").partition("## All functions")[2]
    listed = set()
    for heading, tables in re.findall(r"^### (.*?)\n(.*?)(?=^### |\Z)", page, re.MULTILINE | re.DOTALL):
        if (heading.split(":")[0] if heading.startswith("axode.") else "axode") == module.__name__:
            first_column = "\n".join(re.findall(r"^\| ([^|]*) \|", tables, re.MULTILINE))
            listed |= set(re.findall(r"`(\w+)(?:\(.*?\))?`", first_column))
    assert listed == {name for name in module.__all__ if not inspect.ismodule(getattr(module, name))}


def test_the_packages_to_install_are_among_those_that_make_deps_installs():
    named = re.search(r"^sudo apt install (.*)$", (SOURCE / "docs/python.md").read_text(encoding="utf-8"), re.MULTILINE)
    installed = (SOURCE / "tools/install_dependencies.sh").read_text(encoding="utf-8").replace('"', " ")
    assert set(named[1].split()) <= set(installed.split())


def test_every_quantity_has_one_name_and_one_row():
    page = (SOURCE / "docs/python.md").read_text(encoding="utf-8").partition("## All functions")[2]
    for section in page.split("\n### ")[1:]:
        first_column = "\n".join(re.findall(r"^\| ([^|]*) \|", section, re.MULTILINE))
        names = re.findall(r"`([\w.]+)(?:\(.*?\))?`", first_column)
        assert len(names) == len(set(names)), sorted(name for name in names if names.count(name) > 1)


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
