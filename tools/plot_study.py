"""Draws what `axode study` has measured: times as bars, operations as ticks beside them.

    axode study arm7.toml humanoid.toml --csv study.csv
    build/venv/bin/python tools/plot_study.py study.csv study.svg

A column for each model, a row for each algorithm. Ticks are mul + add + div + sqrt + sin cos, to the scale at which
that of body-fixed twists in joint frames meets its bar. Needs matplotlib.
"""

import argparse
import csv
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "axode", "svg.fonttype": "none"})
from matplotlib import pyplot  # noqa: E402: the backend comes first

COLORS = {"body": "#4477aa", "spatial": "#ee7733", "hybrid": "#228833", "mixed": "#aa3377", "fast": "#999933"}
FRAMES = ["joint", "user", "com", "construction"]
OPERATIONS = ["mul", "add", "div", "sqrt", "sin_cos"]


def place(row):
    """Where the bar of a row stands: five for the joint frames, four for each of the others, with gaps between."""
    frames = FRAMES.index(row["frames"])
    return list(COLORS).index(row["representation"]) + (5.8 + 4.8 * (frames - 1) if frames else 0)


def draw_panel(axes, rows):
    operations = [sum(int(row[name]) for name in OPERATIONS) for row in rows]
    microseconds = [float(row["ns"]) / 1000 for row in rows]
    places = [place(row) for row in rows]
    scale = microseconds[0] / operations[0]
    axes.bar(places, microseconds, 0.85, color=[COLORS[row["representation"]] for row in rows])
    axes.hlines([scale * n for n in operations], [x - 0.5 for x in places], [x + 0.5 for x in places], color="black")
    axes.set_xticks([2, 7.3, 12.1, 16.9], ["joint", "user", "com", "constr."])
    axes.set_xlim(-0.8, 18.8)


def draw(rows, file):
    models = list(dict.fromkeys(row["model"] for row in rows))
    algorithms = list(dict.fromkeys(row["algorithm"] for row in rows))
    figure, all_axes = pyplot.subplots(len(algorithms), len(models), squeeze=False, layout="constrained",
                                       figsize=(1 + 2.5 * len(models), 0.8 + 1.6 * len(algorithms)))
    for algorithm, row_of_axes in zip(algorithms, all_axes, strict=True):
        row_of_axes[0].set_ylabel(algorithm.replace("_", " ") + "\nµs")
        for model, axes in zip(models, row_of_axes, strict=True):
            chosen = [row for row in rows if (row["model"], row["algorithm"]) == (model, algorithm)]
            if chosen:
                draw_panel(axes, chosen)
            else:
                axes.set_axis_off()
    for model, axes in zip(models, all_axes[0], strict=True):
        axes.set_title(model)
    handles = [pyplot.Rectangle((0, 0), 1, 1, color=color) for color in COLORS.values()]
    handles.append(pyplot.Line2D([], [], color="black"))
    figure.legend(handles, [*COLORS, "operations"], loc="outside lower center", ncols=len(handles), fontsize="small")
    figure.savefig(file, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", type=Path, help="what axode study --csv has written")
    parser.add_argument("svg", type=Path, help="the file to draw")
    arguments = parser.parse_args()
    with arguments.csv.open(newline="", encoding="utf-8") as file:
        draw(list(csv.DictReader(file)), arguments.svg)


if __name__ == "__main__":
    main()
