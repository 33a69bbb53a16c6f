"""Counts and times every algorithm in every representation, and writes the tables of the comparative study.

    tools/comparative_study.py build/release/axode                              # prints the tables
    tools/comparative_study.py build/release/axode docs/comparative-study.md
    tools/comparative_study.py build/release/axode docs/comparative-study.md --counts
    tools/comparative_study.py build/release/axode docs/comparative-study.md --check
    tools/comparative_study.py build/release/axode docs/comparative-study.md --second-processor

The numbers are those of `axode study` for chains of hinges, and for the arm and the humanoid of examples/robots. The
second line also draws the plot beside the page. Times need a machine that does nothing else; the third line writes
only the tables without times. The fourth line writes nothing, and exits with 1 if the page has other counts. The fifth
line, on a machine of another kind, writes only the table that compares its times with those of the page. `make build`
builds the command with what the study needs.
"""

import argparse
import datetime
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from make_chain import drawing
from page import Page, processor, table

SOURCE = Path(__file__).resolve().parents[1]
MODELS = ["chain7", "chain36", "arm7", "humanoid"]
TIMED = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix"]
ALGORITHMS = [*TIMED, "momentum_form"]
SHAPES, SHAPED_KINDS, SHAPED_BODIES = ["chain", "tree", "star"], ["revolute", "prismatic", "spherical"], 31
PARALLEL = ["chain7", "chain36", "chain100", "humanoid"]
PER_HINGE = ["inverse_dynamics", "forward_dynamics"]
PER_BODY = ["inverse_dynamics", "forward_dynamics", "mass_matrix"]
REPRESENTATIONS = ["body", "spatial", "hybrid", "mixed"]
RUNS = 8  # of the study on a second processor, of which the least times count
KINDS = ["mul", "add", "div", "sqrt", "sin_cos"]


def drawings(command, folder):
    """The files of all models, by name."""
    paths = {"arm7": SOURCE / "examples/robots/arm7.toml"}
    for n in [7, 8, 9, 36, 100]:
        paths[f"chain{n}"] = folder / f"chain{n}.toml"
        paths[f"chain{n}"].write_text(drawing(n))
    paths["humanoid"] = folder / "humanoid.toml"
    subprocess.run([command, "convert", SOURCE / "examples/robots/humanoid.urdf", paths["humanoid"], "--base", "free"],
                   check=True, capture_output=True)
    return paths


def shapes(folder):
    """The files of chains, binary trees and stars of each kind of joint, by (shape, kind)."""
    paths = {}
    for shape in SHAPES:
        for kind in SHAPED_KINDS:
            paths[shape, kind] = folder / f"{shape}_{kind}.toml"
            paths[shape, kind].write_text(drawing(SHAPED_BODIES, kind, shape))
    return paths


def studied(command, paths, *options):
    """What `axode study` finds, by the name of the model."""
    run = subprocess.run([command, "study", *paths.values(), "--format", "json", *options], check=True,
                         capture_output=True)
    return dict(zip(paths, json.loads(run.stdout), strict=True))


def efforts(studies):
    """The rows of the tables of algorithms, as {(model, algorithm, frames, representation): row}."""
    return {(model, row["algorithm"], row["frames"], row["representation"]): row
            for model, study in studies.items() for row in study["efforts"]}


def operations(row):
    return sum(int(row[kind]) for kind in KINDS)


def cell(row):
    """Operations, and microseconds if they were measured."""
    if "ns" not in row:
        return f"{operations(row):,}"
    us = row["ns"] / 1000
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


def contraction(studies):
    """The table of forward dynamics by contraction of the tree, beside that by articulated bodies."""
    lines = []
    for model in PARALLEL:
        serial, *_, last = studies[model]["contraction"]
        lines.append([model, *(f"{number:,}" for number in (
            serial["operations"], serial["longest_path"], last["operations"], last["rounds"], last["longest_path"]))])
    header = ["model", "articulated bodies", "longest path", "contraction", "rounds", "longest path"]
    return table(header, lines, "-:::::")


def ways(studies, algorithms):
    """The table of the ways to compute the same, with products and sums of one more hinge."""
    def rows(model):
        return [row for row in studies[model]["ways"] if row["algorithm"] in algorithms]

    lines, last = [], None
    models = ["chain7", "chain36", "humanoid"]
    for nine, eight, *of_models in zip(rows("chain9"), rows("chain8"), *map(rows, models), strict=True):
        more = " + ".join(str(nine[kind] - eight[kind]) for kind in ("mul", "add"))
        name = [nine["algorithm"] if nine["algorithm"] != last else ""] if len(algorithms) > 1 else []
        lines.append([*name, nine["way"], nine["representation"], more,
                      *(f"{operations(row):,}" for row in of_models)])
        last = nine["algorithm"]
    header = [*(["algorithm"] if len(algorithms) > 1 else []), "way", "representation", "one more hinge", *models]
    return table(header, lines, "-" * (len(header) - 4) + "::::")


def per_body(studies, algorithm):
    """Operations for each body, by the shape of the tree and the kind of its joints."""
    rows = efforts(studies)
    return table(["tree", "joints", *REPRESENTATIONS], [
        [shape if kind == SHAPED_KINDS[0] else "", kind,
         *(f"{operations(rows[(shape, kind), algorithm, 'joint', name]) / SHAPED_BODIES:.0f}" for name in REPRESENTATIONS)]
        for shape in SHAPES for kind in SHAPED_KINDS], "--::::")


def counted(command, folder):
    """The tables without times, by the names of their parts of the page."""
    studies = studied(command, drawings(command, folder), "--counts")
    rows = efforts(studies)
    parts = {"momentum_form": costs(rows, "momentum_form")}
    parts |= {f"{algorithm} per hinge": per_hinge(rows, algorithm) for algorithm in PER_HINGE}
    parts["screws once"] = ways(studies, ["inverse_dynamics"])
    parts["acceleration forms"] = ways(studies, ["accelerations"])
    parts["higher orders"] = ways(studies, ["jerks", "second_order_inverse_dynamics", "inverse_dynamics_derivatives"])
    parts["contraction"] = contraction(studies)
    of_shapes = studied(command, shapes(folder), "--counts")
    parts |= {f"{algorithm} per body": per_body(of_shapes, algorithm) for algorithm in PER_BODY}
    return parts


def rounding(command, folder):
    """The tables of rounding errors of the chain of 36 hinges."""
    chain = folder / "chain36.toml"
    chain.write_text(drawing(36))
    rows = studied(command, {"chain36": chain}, "--counts", "--rounding")["chain36"]["rounding"]
    names = ["body", "spatial", "inertial", "hybrid", "mixed"]

    def lines(algorithm):
        return [[f"{row['distance']:g}", f"{row['heaviness']:g}", f"{row['condition']:.0e}",
                 *(f"{row[algorithm][name]:.0e}" for name in names)] for row in rows]

    return {f"{algorithm} rounding": table(["m", "heavier", "condition", *names], lines(algorithm), ":" * 8)
            for algorithm in PER_HINGE}


def drift(command, folder):
    """The drift of joints in absolute coordinates without projection, of a top and of a chain of seven hinges."""
    paths = {"top": folder / "top.toml", "chain7": folder / "chain7.toml"}
    paths["top"].write_text(drawing(1, "spherical"))
    paths["chain7"].write_text(drawing(7))
    groups = ["SE3", "SO3xR3", "by_joint"]
    lines = [[model, joints.replace("_", " "), f"1/{1 / row['step']:.0f}",
              *(f"{row[group][joints]:.0e}" for group in groups)]
             for model, study in studied(command, paths, "--counts", "--drift").items()
             for joints in (["all_joints"] if model == "top" else ["joints_on_ground", "all_joints"])
             for row in study["drift"]]
    header = ["model", "joints", "step, s", "SE(3)", "SO(3) × R³", "by joint"]
    return {"drift": table(header, lines, "--" + ":" * 4)}


def timed(command, folder):
    """The tables with times."""
    paths = drawings(command, folder)
    rows = efforts(studied(command, {model: paths[model] for model in MODELS}))
    parts = {algorithm: costs(rows, algorithm) for algorithm in TIMED}
    parts["date"] = f"The tables and the plot were made on {datetime.date.today()}.\n"
    return parts


def other_counts(command, folder, page):
    """The names of the parts of the page that have other counts than the command."""
    others = [name for name, text in counted(command, folder).items() if Page(page).text(name) != text]
    rows = efforts(studied(command, {"arm7": SOURCE / "examples/robots/arm7.toml"}, "--counts"))
    column = MODELS.index("arm7") + 2
    for algorithm in ALGORITHMS:
        cells = [line.split("|")[1 + column].split("·")[0] for line in Page(page).text(algorithm).splitlines()[2:]]
        counts = [operations(row) for key, row in rows.items() if key[1] == algorithm]
        if [int(cell.replace(",", "")) for cell in cells] != counts:
            others.append(algorithm)
    return others


def times_of_page(page, algorithm):
    """The microseconds in the table of an algorithm, as {(model, frames, representation): time}."""
    found, last = {}, ""
    for line in Page(page).text(algorithm).splitlines()[2:]:
        frames, representation, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        last = frames or last
        for model, text in zip(MODELS, cells, strict=True):
            found[model, last, representation] = float(text.split("·")[1])
    return found


def second_processor(command, folder, page):
    """The table of times in joint frames, as parts of the body-fixed time: on the page, and on this machine."""
    paths = drawings(command, folder)
    models = ["chain7", "chain36", "humanoid"]
    runs = [efforts(studied(command, {model: paths[model] for model in models})) for _ in range(RUNS)]

    def least(model, algorithm, name):
        return min(rows[model, algorithm, "joint", name]["ns"] / 1000 for rows in runs)

    lines = []
    for algorithm in TIMED:
        first = times_of_page(page, algorithm)
        for name in [*REPRESENTATIONS, "fast"]:
            lines.append([algorithm.replace("_", " ") if name == "body" else "", name] + [
                f"{first[model, 'joint', name] / first[model, 'joint', 'body']:.2f} · "
                f"{least(model, algorithm, name) / least(model, algorithm, 'body'):.2f}" if name != "body" else
                f"{first[model, 'joint', name]:.2f} · {least(model, algorithm, name):.2f} µs" for model in models])
    return table(["algorithm", "representation", *models], lines, "--:::") + (
        f"\nThe second numbers are of an {processor()}, {datetime.date.today()}.\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", type=Path, help="the command axode, of a release build")
    parser.add_argument("page", type=Path, nargs="?", help="the page to refresh, docs/comparative-study.md")
    parser.add_argument("--counts", action="store_true", help="only the tables without times")
    parser.add_argument("--check", action="store_true", help="write nothing; exit with 1 if the page has other counts")
    parser.add_argument("--second-processor", action="store_true",
                        help="only the table that compares the times of this machine with those of the page")
    arguments = parser.parse_args()
    command = arguments.command.resolve()
    if arguments.second_processor:
        if not arguments.page:
            parser.error("--second-processor needs the page with the times of the first processor")
        with tempfile.TemporaryDirectory() as folder:
            text = second_processor(command, Path(folder), arguments.page)
        Page(arguments.page).part("second processor", text)
        return
    if arguments.check:
        if not arguments.page:
            parser.error("--check needs the page")
        with tempfile.TemporaryDirectory() as folder:
            others = other_counts(command, Path(folder), arguments.page)
        sys.exit(f"{arguments.page} has other counts in {', '.join(others)}" if others else 0)
    with tempfile.TemporaryDirectory() as folder:
        parts = counted(command, Path(folder)) | rounding(command, Path(folder)) | drift(command, Path(folder))
        if not arguments.counts:
            parts |= timed(command, Path(folder))
        for name, text in parts.items():
            print(f"{name}\n{text}", flush=True)
            if arguments.page:
                Page(arguments.page).part(name, text)
        if arguments.page and not arguments.counts:
            paths = drawings(command, Path(folder))
            subprocess.run([command, "study", *(paths[model] for model in MODELS), "--plot",
                            arguments.page.with_suffix(".svg")], check=True, capture_output=True)


if __name__ == "__main__":
    main()
