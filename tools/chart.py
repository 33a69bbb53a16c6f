"""Draws charts of tables with `axode plot` of the release build."""

import csv
import subprocess
import tempfile
from pathlib import Path

AXODE = Path(__file__).resolve().parents[1] / "build" / "release" / "axode"


def draw(picture, tables, *options):
    """Tables are {title: (names of columns, rows)}, with None for empty cells; the options are those of `axode plot`."""
    if not AXODE.exists():
        raise SystemExit(f"{AXODE} is not there: build it with `make build`")
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / f"{title}.csv" for title in tables]
        for file, (names, rows) in zip(files, tables.values(), strict=True):
            with file.open("w", newline="", encoding="utf-8") as stream:
                csv.writer(stream).writerows([names, *rows])
        subprocess.run([AXODE, "plot", *files, "--output", picture, *options], check=True, stdout=subprocess.DEVNULL)


def curves(x_axis, y_axis, points):
    """The table of {name: (x, y)}, each with points of its own."""
    names, rows = list(points), []
    for k, (x, y) in enumerate(points.values()):
        for x_i, y_i in zip(x, y, strict=True):
            cells = [None] * len(names)
            cells[k] = float(y_i)
            rows.append([float(x_i), *cells])
    return [x_axis, *(f"{y_axis}: {name}" for name in names)], rows
