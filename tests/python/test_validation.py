"""The page of evidence and the command that makes it."""

from pathlib import Path

import numpy as np
import pytest

SOURCE = Path(__file__).resolve().parents[2]
SLOW = {"A02", "tippe_top"}  # take 5 s and 2 s; `make nightly` computes them


@pytest.fixture
def validation(monkeypatch):
    pytest.importorskip("scipy")
    monkeypatch.syspath_prepend(SOURCE / "tools")
    import validation

    return validation


@pytest.mark.parametrize("section", ["iftomm", "test set", "spatial", "flight", "closed forms", "contact"])
def test_rows_are_within_their_bounds_and_on_the_page(validation, section):
    page = (SOURCE / "docs/validation.md").read_text(encoding="utf-8")
    text = page.partition(f"<!-- {section} -->\n")[2].partition("<!-- end -->")[0]
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    assert [row[0] for row in rows[2:] if row[0] not in validation.SECTIONS[section]] == []
    listed = {tuple(row[column] for column in (0, 1, 3, 5, 6)) for row in rows[2:] if row[0] not in SLOW}
    computed = set()
    for name, case in validation.SECTIONS[section].items():
        for comparison, seconds in validation.compare(name, case) if name not in SLOW else ():
            assert comparison.error <= comparison.bound, (name, comparison.quantity)
            row = validation.row(name, comparison, seconds)
            computed.add(tuple(row[column] for column in (0, 1, 3, 5, 6)))
            assert " ".join(comparison.source.split()) in " ".join(text.split())
    assert computed == listed


@pytest.mark.parametrize("error", [2e-3, np.nan])
def test_a_number_that_exceeds_its_bound_fails_the_command(validation, monkeypatch, tmp_path, capsys, error):
    def wrong():
        case = validation.closed_forms
        yield case.Comparison("length, m", [1, 2 + error], [1, 2], 1e-3, case.Scheme(rtol=1e-6), "A drawing.")

    page = tmp_path / "page.md"
    page.write_text("before\n<!-- lengths -->\nold\n<!-- end -->\nafter\n")
    monkeypatch.setattr(validation, "SECTIONS", {"lengths": {"wrong": wrong}})
    monkeypatch.setattr(validation, "CASES", ["wrong"])
    monkeypatch.setattr("sys.argv", ["validation.py", str(page)])
    assert validation.main() == 1
    assert "wrong: length, m: " in capsys.readouterr().out
    lines = page.read_text().splitlines()
    assert lines[:2] == ["before", "<!-- lengths -->"] and lines[-2:] == ["<!-- end -->", "after"]
    assert "* wrong: A drawing." in lines and "old" not in lines


def test_a_page_without_a_table_is_named(validation, monkeypatch, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("no table\n")
    with pytest.raises(SystemExit, match="between <!-- flight --> and <!-- end -->, found 0"):
        validation.Page(page).part("flight", "")
