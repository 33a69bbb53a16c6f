"""Tools that measure, and that draw measured numbers."""

import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools"
ROBOTS = TOOLS.parent / "examples/robots"


def test_mechanisms_are_drawn_the_same_every_time(tmp_path):
    pytest.importorskip("matplotlib")
    files = [tmp_path / "one.svg", tmp_path / "other.svg"]
    for file in files:
        subprocess.run([sys.executable, TOOLS / "draw_mechanisms.py", file], check=True)
    drawn, again = (file.read_text() for file in files)
    assert drawn == again and len(drawn) < 200e3
    texts = [text.text for text in xml.etree.ElementTree.fromstring(drawn).iter("{http://www.w3.org/2000/svg}text")]
    closed = {file.name for file in ROBOTS.glob("*.toml") if "[[loop]]" in file.read_text(encoding="utf-8")}
    assert len(closed) > 10 and closed | {"closes a loop"} <= set(texts)


def test_tables_are_drawn_with_a_curve_for_each_name_where_it_has_points(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(TOOLS)
    import chart

    if not chart.AXODE.exists():
        pytest.skip("the command is not built")
    table = chart.curves("steps", "error, rad", {"rk4": ([10, 100], [1e-2, 1e-6]), "dopri5": ([20], [1e-5])})
    assert table == (["steps", "error, rad: rk4", "error, rad: dopri5"],
                     [[10, 1e-2, None], [100, 1e-6, None], [20, None, 1e-5]])
    chart.draw(tmp_path / "errors.svg", {"by steps": table, "once more": table}, "--log", "xy")
    drawn = xml.etree.ElementTree.parse(tmp_path / "errors.svg")
    texts = ["".join(text.itertext()).strip() for text in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert {"by steps", "once more", "error, rad", "steps", "rk4", "dopri5", "1e-6"} <= set(texts)


def test_a_study_of_motions_refreshes_its_table_and_nothing_else(tmp_path):
    page = tmp_path / "page.md"
    command = [sys.executable, TOOLS / "motion_study.py", page, "--only", "free_top"]
    page.write_text("before\n\n<!-- free top -->\n| old |\n<!-- end -->\n\nafter\n")
    subprocess.run(command, check=True)
    lines = page.read_text().split("\n")
    assert lines[:3] == ["before", "", "<!-- free top -->"] and lines[-4:] == ["<!-- end -->", "", "after", ""]
    cells = {tuple(line.split(" | ")[:2]): line.strip(" |").split(" | ")[4:] for line in lines[5:-4]}
    exact = [float(row[2]) for (method, _), row in cells.items() if "midpoint" in method or "momenta" in method]
    assert len(exact) == 6 and max(exact) < 1e-14
    errors = [float(cells["| `rk4`", step][0]) for step in ("0.1 s", "0.05 s", "0.025 s")]
    assert 14 < errors[0] / errors[1] < 24 and 14 < errors[1] / errors[2] < 24


def test_a_study_of_motions_says_which_table_a_page_lacks(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("no table\n")
    command = [sys.executable, TOOLS / "motion_study.py", page, "--only", "free_top"]
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode == 1 and "between <!-- free top --> and <!-- end -->, found 0" in found.stderr


def test_a_site_has_no_link_that_leads_nowhere_and_loads_nothing_from_elsewhere(tmp_path):
    page = '<p id="here"><a href="{}">x</a><img src="{}"></p>'
    (tmp_path / "deep").mkdir()
    (tmp_path / "x.svg").write_text("<svg/>")
    (tmp_path / "good.html").write_text(page.format("deep/other.html#here", "x.svg"))
    (tmp_path / "deep/other.html").write_text(page.format("https://toml.io", "../x.svg"))
    command = [sys.executable, TOOLS / "check_links.py", tmp_path]
    assert "all links of 2 pages" in subprocess.run(command, capture_output=True, text=True, check=True).stdout
    (tmp_path / "bad.html").write_text(page.format("good.html#there", "//cdn.org/x.js") + page.format("gone.html", "no.svg"))
    (tmp_path / "bad.css").write_text("@import 'https://cdn.org/font.css';")
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode == 1 and found.stdout.splitlines() == [
        "bad.html: loads from elsewhere: //cdn.org/x.js", "bad.html: no such element: good.html#there",
        "bad.html: no such file: gone.html", "bad.html: no such file: no.svg",
        "bad.css: loads from elsewhere: https://cdn.org/font.css"]
