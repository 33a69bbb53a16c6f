"""Measures every function and the same functions of other libraries, each compiled with GCC and with Clang, and
compares the better times.

    build/venv/bin/python tools/benchmark.py build/bench build/bench-clang --plot docs/performance.svg

Runs <build>/bench/single_thread of every build folder given, writes build/bench/ratios.json, a list of
{"function", "model", "variant", "ours_ns", "ours_compiler", "peer", "peer_compiler", "peer_ns", "ratio"}, prints it as a
table, and draws what is beside Pinocchio. What is beside MuJoCo, which is not compiled here, has a table of its own.
Times are medians of repetitions, in nanoseconds for one state.
"""

import argparse
import json
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import chart

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


def compiler_of(build):
    for line in (build / "CMakeCache.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("CMAKE_CXX_COMPILER:"):
            return Path(line.split("=", 1)[1]).name
    raise SystemExit(f"{build} has no compiler in its CMakeCache.txt")


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
    cells = {(row["model"], row["function"]): f"{row['ours_ns']:.0f} / {row['peer_ns']:.0f} = {row['ratio']:.2f}"
             for row in rows if row["peer"] == peer and FAST.get(row["function"]) == row["variant"]}
    if not cells:
        return
    functions = [function for function in FAST if any(function == key[1] for key in cells)]
    print("\n| ours / " + peer + " | " + " | ".join(function.replace("_", " ") for function in functions) + " |")
    print("|---" * (1 + len(functions)) + "|")
    for model in dict.fromkeys(model for model, _ in cells):
        print(f"| {model} | " + " | ".join(cells.get((model, function), "") for function in functions) + " |")


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
    arguments = parser.parse_args()
    rows = compare({compiler_of(build): run(build, arguments) for build in arguments.builds})
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print_table([row for row in rows if row["peer"] not in COMPILED_BY_ITS_MAKERS])
    for peer in COMPILED_BY_ITS_MAKERS:
        print_beside(peer, rows)
    if arguments.plot:
        draw_beside_pinocchio(rows, arguments.plot)


if __name__ == "__main__":
    main()
