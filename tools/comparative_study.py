"""Counts and times every algorithm in every representation, and writes the tables of the comparative study.

    tools/comparative_study.py build/release/axode                              # prints the tables
    tools/comparative_study.py build/release/axode docs/comparative-study.md

The numbers are those of `axode study` for chains of 7 and 36 hinges, and for the arm and the humanoid of
examples/robots. The second line also draws the plot beside the page. Times need a machine that does nothing else.
"""

import argparse
import csv
import datetime
import subprocess
import tempfile
from pathlib import Path

from page import Page, table

SOURCE = Path(__file__).resolve().parents[1]
MODELS = ["chain7", "chain36", "arm7", "humanoid"]
ALGORITHMS = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix", "momentum_form"]
PER_HINGE = ["inverse_dynamics", "forward_dynamics"]
REPRESENTATIONS = ["body", "spatial", "hybrid", "mixed"]
KINDS = ["mul", "add", "div", "sqrt", "sin_cos"]


def drawings(command, folder):
    """Files of the four models, and of chains of 8 and 9 hinges."""
    for n in [7, 8, 9, 36]:
        chain = subprocess.run([SOURCE / "tools/make_chain.py", str(n)], check=True, capture_output=True)
        (folder / f"chain{n}.toml").write_bytes(chain.stdout)
    robots = SOURCE / "examples/robots"
    humanoid = folder / "humanoid.toml"
    subprocess.run([command, "convert", robots / "humanoid.urdf", humanoid, "--base", "free"], check=True,
                   capture_output=True)
    paths = [folder / "chain7.toml", folder / "chain36.toml", robots / "arm7.toml", humanoid]
    return paths, [folder / "chain8.toml", folder / "chain9.toml"]


def study(command, paths, *options):
    """The rows of `axode study`, as {(model, algorithm, frames, representation): row}. Models are named as files."""
    rows = {}
    for path in paths:
        with tempfile.NamedTemporaryFile(suffix=".csv") as file:
            subprocess.run([command, "study", path, "--csv", file.name], check=True, capture_output=True)
            for row in csv.DictReader(Path(file.name).read_text(encoding="utf-8").splitlines()):
                rows[path.stem, row["algorithm"], row["frames"], row["representation"]] = row
    return rows


def operations(row):
    return sum(int(row[kind]) for kind in KINDS)


def cell(row):
    """Operations and microseconds."""
    us = float(row["ns"]) / 1000
    return f"{operations(row):,} · {us:.2f}" if us < 10 else f"{operations(row):,} · {us:.1f}"


def costs(rows, algorithm):
    """The table of an algorithm."""
    variants = dict.fromkeys(key[2:] for key in rows if key[1] == algorithm)
    lines, last = [], None
    for frames, representation in variants:
        cells = [cell(rows[model, algorithm, frames, representation]) for model in MODELS]
        lines.append([frames if frames != last else "", representation, *cells])
        last = frames
    return table(["frames", "representation", *MODELS], lines, "------")


def per_hinge(rows, algorithm):
    """Products and sums of one more hinge, in each choice of frames and representation."""
    def difference(frames, representation):
        nine, eight = (rows[f"chain{n}", algorithm, frames, representation] for n in (9, 8))
        return " + ".join(str(int(nine[kind]) - int(eight[kind])) for kind in ("mul", "add"))

    frames_of = dict.fromkeys(key[2] for key in rows if key[1] == algorithm)
    lines = [[frames, *(difference(frames, name) for name in REPRESENTATIONS)] for frames in frames_of]
    return table(["frames", *REPRESENTATIONS], lines, "-----")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", type=Path, help="the command axode, of a release build")
    parser.add_argument("page", type=Path, nargs="?", help="the page to refresh, docs/comparative-study.md")
    arguments = parser.parse_args()
    command = arguments.command.resolve()
    with tempfile.TemporaryDirectory() as folder:
        models, chains = drawings(command, Path(folder))
        rows = study(command, models)
        of_chains = study(command, chains)
        parts = {algorithm: costs(rows, algorithm) for algorithm in ALGORITHMS}
        parts |= {f"{algorithm} per hinge": per_hinge(of_chains, algorithm) for algorithm in PER_HINGE}
        parts["date"] = f"The tables and the plot were made on {datetime.date.today()}.\n"
        for name, text in parts.items():
            print(f"{name}\n{text}", flush=True)
            if arguments.page:
                Page(arguments.page).part(name, text)
        if arguments.page:
            subprocess.run([command, "study", *models, "--plot", arguments.page.with_suffix(".svg")], check=True,
                           capture_output=True)


if __name__ == "__main__":
    main()
