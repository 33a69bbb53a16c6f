"""Measures every function and the same functions of other libraries, each compiled with GCC and with Clang, and
compares the better times.

    build/venv/bin/python tools/benchmark.py build/bench build/bench-clang --plot docs/performance.svg \\
        --page docs/performance.md
    build/venv/bin/python tools/benchmark.py build/bench-installed --page docs/performance.md \\
        --output build/bench-installed/ratios.json

Runs <build>/bench/single_thread of every build folder given, writes build/bench/ratios.json, a list of
{"function", "model", "variant", "ours_ns", "ours_compiler", "peer", "peer_compiler", "peer_ns", "ratio"}, prints it as a
table, and draws what is beside Pinocchio. What is beside MuJoCo, which is not compiled here, has a table of its own.
Times are medians of repetitions, in nanoseconds for one state. --page writes the tables of a page: those of code for one
processor, or, from a build without AXODE_NATIVE, that of what one installs and the sentence of README.md about it.
"""

import argparse
import datetime
import json
import os
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import chart
from page import Page, processor

PEERS = ["pinocchio", "lcaba", "mujoco"]  # lcaba: Pinocchio's other way to solve mechanisms with loops
COMPILED_BY_ITS_MAKERS = {"mujoco": "wheel"}  # peers that have a table of their own
OWN_PEERS = {"generated": "fast"}  # variants of ours that are compared with another one of ours
FAST = {"inverse_dynamics": "fast", "forward_dynamics": "fast", "mass_matrix": "fast", "inverse_mass_matrix": "fast",
        "joint_jacobians": "fast", "body_jacobians": "hybrid", "poses": "fast", "twists": "hybrid",
        "accelerations": "hybrid",
        "inverse_dynamics_derivatives": "fast", "forward_dynamics_derivatives": "fast",
        "inverse_dynamics_second_derivatives": "fast"}
PANELS = {"dynamics": ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix"],
          "kinematics": ["poses", "twists", "accelerations", "joint_jacobians", "body_jacobians"],
          "derivatives": ["inverse_dynamics_derivatives", "forward_dynamics_derivatives",
                          "inverse_dynamics_second_derivatives"]}  # of the picture
DYNAMICS = [*PANELS["dynamics"], "joint_jacobians"]
# Tables of the page: the peer of each, and its functions. A cell has our time, the peer's and their ratio.
TABLES = {"dynamics": ("pinocchio", DYNAMICS),
          "motion": ("pinocchio", ["poses", "twists", "accelerations", "body_jacobians"]),
          "derivatives": ("pinocchio", PANELS["derivatives"]),
          "MuJoCo": ("mujoco", [*DYNAMICS, "poses", "body_jacobians"])}
INSTALLED = [*PANELS["dynamics"], "poses", *PANELS["derivatives"][:2]]
# The summary of the page has a row for each of these groups of functions, with the range of their ratios.
SUMMARY = {"inverse dynamics": ["inverse_dynamics"], "forward dynamics": ["forward_dynamics"],
           "mass matrix; its inverse": ["mass_matrix", "inverse_mass_matrix"],
           "poses": ["poses"], "Jacobians of all joints": ["joint_jacobians"],
           "first derivatives of inverse dynamics; of forward dynamics": PANELS["derivatives"][:2],
           "second derivatives of inverse dynamics": PANELS["derivatives"][2:],
           "forward dynamics with closed loops": ["constrained_forward_dynamics"]}
PRODUCTS = ["inverse_dynamics_hessian", "forward_dynamics_hessian", "inverse_dynamics_jvp", "inverse_dynamics_vjp",
            "forward_dynamics_jvp", "forward_dynamics_vjp"]
README = Path(__file__).parent.parent / "README.md"
SHOWN = ["arm7", "anymal_b", "simple_humanoid", "chain36"]  # in tables with a column for each mechanism


def cached(build, name):
    for line in (build / "CMakeCache.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith(f"{name}:"):
            return line.split("=", 1)[1]
    raise SystemExit(f"{build}/CMakeCache.txt has no {name}")


def compiler_of(build):
    return Path(cached(build, "CMAKE_CXX_COMPILER")).name


def run(build, arguments):
    """(function, model, variant) -> median nanoseconds for one state."""
    program = build / "bench" / "single_thread"
    if not program.exists():
        raise SystemExit(f"{program} is not there: build it with `make bench`")
    output = build / "single_thread.json"
    command = [program, f"--benchmark_out={output}", "--benchmark_out_format=json",
               f"--benchmark_min_time={arguments.min_time}", f"--benchmark_repetitions={arguments.repetitions}",
               "--benchmark_enable_random_interleaving=true", "--benchmark_report_aggregates_only=true",
               f"--benchmark_filter={arguments.filter}"]
    print(f"{program} ...", file=sys.stderr, flush=True)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    times = {}
    for entry in json.loads(output.read_text(encoding="utf-8"))["benchmarks"]:
        if entry.get("aggregate_name", "median") == "median":
            times[tuple(entry["run_name"].split("/")[:3])] = entry["real_time"] / entry.get("states", 1)
    return times


def compare(times):
    """The times of our variants divided by those of each peer, with the better compiler of each."""
    best = defaultdict(lambda: (float("inf"), None))
    for compiler, measured in times.items():
        for key, nanoseconds in measured.items():
            best[key] = min(best[key], (nanoseconds, compiler))
    rows = []
    for (function, model, variant), (ours, compiler) in best.items():
        if variant in PEERS:
            continue
        peers = [peer for peer in PEERS if (function, model, peer) in best]
        for peer in [OWN_PEERS[variant]] if variant in OWN_PEERS else peers or [None]:
            theirs, peer_compiler = best.get((function, model, peer), (None, None))
            peer_compiler = COMPILED_BY_ITS_MAKERS.get(peer, peer_compiler)
            rows.append({"function": function, "model": model, "variant": variant, "ours_ns": round(ours, 1),
                         "ours_compiler": compiler, "peer": peer if theirs else None, "peer_compiler": peer_compiler,
                         "peer_ns": theirs and round(theirs, 1), "ratio": theirs and round(ours / theirs, 3)})
    functions = list(FAST)

    def natural(text):
        return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", text)]

    def place(row):
        known = row["function"] in functions
        return (functions.index(row["function"]) if known else len(functions), row["function"],
                row["model"].startswith(("chain", "tree")), natural(row["model"]), row["variant"])

    return sorted(rows, key=place)


def print_table(rows):
    print("| function | model | variant | ours ns | compiler | peer | peer ns | compiler | ratio |")
    print("|---|---|---|--:|---|---|--:|---|--:|")
    for row in rows:
        cells = [row["function"], row["model"], row["variant"], f"{row['ours_ns']:.0f}", row["ours_compiler"], row["peer"] or "",
                 f"{row['peer_ns']:.0f}" if row["peer_ns"] else "", row["peer_compiler"] or "", row["ratio"] or ""]
        print("| " + " | ".join(str(cell) for cell in cells) + " |")


def print_beside(peer, rows):
    """Our fast variants: a row for each model, a column for each function."""
    cells = {(row["model"], row["function"]): cell(row) for row in rows
             if row["peer"] == peer and FAST.get(row["function"]) == row["variant"]}
    if not cells:
        return
    functions = [function for function in FAST if any(function == key[1] for key in cells)]
    print("\n| ours / " + peer + " | " + " | ".join(function.replace("_", " ") for function in functions) + " |")
    print("|---" * (1 + len(functions)) + "|")
    for model in dict.fromkeys(model for model, _ in cells):
        print(f"| {model} | " + " | ".join(cells.get((model, function), "") for function in functions) + " |")


def cell(row):
    return f"{row['ours_ns']:.0f} / {row['peer_ns']:.0f} = {row['ratio']:.2f}" if row else ""


def where_and_when(builds, repetitions):
    """A sentence for the page: date, machine and compilers of a run."""
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    wide = "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "SSE2"
    compilers = [subprocess.run([cached(build, "CMAKE_CXX_COMPILER"), "--version"], check=True, capture_output=True,
                                text=True).stdout.splitlines()[0] for build in builds]
    return (f"Measured on {datetime.date.today()} on {os.cpu_count()} cores ({processor()}, {wide}) with "
            f"{' and '.join(compilers)}: medians of {repetitions} interleaved repetitions over 64 states, in ns.\n")


def ratio_range(best, function, *peers):
    ratios = [row["ratio"] for key, row in best.items() if key[0] == function and key[2] in peers]
    return f"{min(ratios):.2f} to {max(ratios):.2f}" if ratios else "not compared"


def write_page(page, rows, builds, repetitions):
    best = {(row["function"], row["model"], row["peer"]): row for row in rows
            if FAST.get(row["function"], row["variant"]) == row["variant"]}
    models = list(dict.fromkeys(row["model"] for row in rows))

    def beside(name, peer, functions):
        shown = [model for model in models if any((function, model, peer) in best for function in functions)]
        page.table(name, ["", *(function.replace("_", " ") for function in functions)],
                   [[model, *(cell(best.get((function, model, peer))) for function in functions)] for model in shown])

    if cached(builds[0], "AXODE_NATIVE") != "ON":
        page.part("installed date", where_and_when(builds, repetitions))
        beside("installed", "pinocchio", INSTALLED)
        ranges = [ratio_range(best, function, "pinocchio") for function in INSTALLED[:2]]
        Page(README).part("speed", f"As installed, inverse dynamics take {ranges[0]} of the time of Pinocchio 4.1, and forward "
                                   f"dynamics {ranges[1]}\n([performance](docs/performance.md)).\n")
        return

    def spread(functions, *peers):
        ranges = [ratio_range(best, function, *peers) for function in functions]
        return ranges[0] if len(set(ranges)) == 1 else "; ".join(ranges)

    page.part("date", where_and_when(builds, repetitions))
    page.table("summary", ["", "time over that of Pinocchio 4.1", "time over that of MuJoCo 4.0"],
               [[name, spread(functions, "pinocchio", "lcaba"), spread(functions, "mujoco")]
                for name, functions in SUMMARY.items()])
    for name, (peer, functions) in TABLES.items():
        beside(name, peer, functions)
    times = {(row["function"], row["model"], row["variant"]): row["ours_ns"] for row in rows}
    page.table("products", ["", *SHOWN], [[f"`{function}`", *(f"{times[function, model, 'fast']:.0f}" for model in SHOWN)]
                                          for function in PRODUCTS])

    def batch(function, model):
        one, two = (times[function, model, f"batch_double_{threads}_threads"] for threads in (1, 2))
        return f"{one:.0f} ({best[function, model, 'pinocchio']['peer_ns'] / one:.1f}), {one / two:.2f}"

    page.table("many states", ["", *(function.replace("_", " ") for function in PANELS["dynamics"])],
               [[model, *(batch(function, model) for function in PANELS["dynamics"])] for model in SHOWN])
    loops = [model for model in models if ("constrained_forward_dynamics", model, "lcaba") in best]
    page.table("loops", ["", "`constraintDynamics`", "`lcaba`"],
               [[model, *(cell(best["constrained_forward_dynamics", model, peer]) for peer in ("pinocchio", "lcaba"))]
                for model in loops])
    generated = {(row["function"], row["model"]): row for row in rows if row["variant"] == "generated"}
    functions = list(dict.fromkeys(function for function, _ in generated))
    page.table("generated", ["", *(function.replace("_", " ") for function in functions)],
               [[model, *(cell(generated.get((function, model))) for function in functions)]
                for model in dict.fromkeys(model for _, model in generated)])


def draw_beside_pinocchio(rows, picture):
    shown = [row for row in rows if row["peer"] == "pinocchio" and FAST.get(row["function"]) == row["variant"]]
    ratio = {(row["model"], row["function"]): row["ratio"] for row in shown}
    names = [f"{panel}: {function.replace('_', ' ')}" for panel, functions in PANELS.items() for function in functions]
    functions = [function for functions in PANELS.values() for function in functions]
    table = [[model, *(ratio.get((model, function)) for function in functions)]
             for model in dict.fromkeys(row["model"] for row in shown)]
    chart.draw(picture, {"Our time over Pinocchio's, each at its better compiler": (["", *names], table)}, "--bars")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", nargs="+", type=Path, help="folders built with the presets bench and bench-clang")
    parser.add_argument("--min-time", default="0.05", help="seconds of each repetition")
    parser.add_argument("--repetitions", default="5")
    parser.add_argument("--filter", default=".", help="regular expression on <function>/<model>/<variant>")
    parser.add_argument("--output", type=Path, default=Path("build/bench/ratios.json"))
    parser.add_argument("--plot", type=Path, help="a picture to draw, .svg or .png")
    parser.add_argument("--page", type=Path, help="a page whose tables are written, docs/performance.md")
    arguments = parser.parse_args()
    rows = compare({compiler_of(build): run(build, arguments) for build in arguments.builds})
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print_table([row for row in rows if row["peer"] not in COMPILED_BY_ITS_MAKERS])
    for peer in COMPILED_BY_ITS_MAKERS:
        print_beside(peer, rows)
    if arguments.page:
        write_page(Page(arguments.page), rows, arguments.builds, arguments.repetitions)
    if arguments.plot:
        draw_beside_pinocchio(rows, arguments.plot)


if __name__ == "__main__":
    main()
