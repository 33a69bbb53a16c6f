"""`python -m axode`: the command `axode` that the package brings. `axode map` is written in Python, here."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any, NoReturn

import axode

COMMAND = Path(__file__).parent / "bin/axode"
EXAMPLE = """\
Example:
  axode map inverse_dynamics humanoid.urdf states.parquet tau.parquet --base free
  axode map jacobian arm7.toml states/ jacobians/ --set frame=flange --set representation=hybrid

Its arguments are explained in docs/distributed.md and in help(axode.distributed.map_states). It needs pyarrow: pip install pyarrow."""


def argument(text: str) -> tuple[str, Any]:
    """Splits NAME=VALUE. The value is read as JSON or, if it is not JSON, as a word."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise argparse.ArgumentTypeError(f'"{text}" is not NAME=VALUE')
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def parser() -> argparse.ArgumentParser:
    command = argparse.ArgumentParser(
        prog="axode map", description="Compute a function of the states in Parquet files. The results are Parquet files "
        "with the same rows in the same order. An interrupted job continues where it stopped.", epilog=EXAMPLE, formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("function", metavar="FUNCTION", help="a function of a state, such as inverse_dynamics or poses")
    command.add_argument("model", metavar="MODEL", help="a drawing (.toml), a URDF or any other file that axode.load takes")
    command.add_argument("states", metavar="STATES", help="a Parquet file, or a folder of Parquet files; columns q, v, a, tau with lists, "
                         'or "q A1", "q A2", ... as in run.csv')
    command.add_argument("output", metavar="OUTPUT", help="a file if the name ends in .parquet, otherwise a folder")
    command.add_argument("--base", choices=["fixed", "free"],
                         help="joint of the base: fixed, or free; default: that of the file")
    command.add_argument("--strict", action="store_true", help="treat warnings as errors")
    command.add_argument("--set", metavar="NAME=VALUE", type=argument, action="append", default=[],
                         help="an argument of the function; may be given again")
    command.add_argument("--keep", metavar="NAMES",
                         help="columns to copy, separated by commas, or all, or none; "
                         "default: all that are not part of a state")
    command.add_argument("--float", action="store_true", help="write float instead of double")
    command.add_argument("--faulty", choices=["refuse", "nan"], default="refuse",
                         help="what to do if a state has no result; default: refuse")
    command.add_argument("--overwrite", action="store_true", help="replace existing results")
    command.add_argument("--cluster", metavar="ADDRESS",
                         help="address of a Ray cluster, or local; default: $RAY_ADDRESS or this process")
    command.add_argument("--threads", metavar="N", type=int,
                         help="threads of this process; default: one for each core")
    return command


def keep(names: str | None) -> Any:
    return names if names is None or names == "all" else [] if names == "none" else names.split(",")


def progress_on_a_terminal() -> bool:
    if not sys.stderr.isatty():
        return False
    try:
        import tqdm  # type: ignore[import-untyped, import-not-found, unused-ignore]  # noqa: F401
    except ImportError:
        return False
    return True


def map_states(given: argparse.Namespace) -> None:
    from axode import distributed

    m = axode.load(given.model, given.base, strict=given.strict)
    for warning in m.warnings:
        print(warning, file=sys.stderr)
    written = distributed.map_states(
        m, given.function, given.states, given.output, arguments=dict(given.set), keep=keep(given.keep),
        dtype="float32" if given.float else "float64", faulty=given.faulty, overwrite=given.overwrite,
        cluster=given.cluster, threads=given.threads, progress=progress_on_a_terminal())
    continued = f", {written.parts - written.computed} of {written.parts} parts existed" \
        if written.computed < written.parts else ""
    faulty = f", {written.faulty} of them NaN" if written.faulty else ""
    print(f"{given.output}: {given.function} of {written.rows} states{continued}{faulty}")


def run_command(words: list[str]) -> NoReturn:
    """Replaces this process by the C++ program."""
    os.environ.setdefault("AXODE_PYTHON", sys.executable)
    os.execv(COMMAND, ["axode", *words])


def main(words: list[str] | None = None) -> int:
    """Runs the command. Returns 0, or 1 if a file is wrong, 2 if the command line is wrong, 130 after Ctrl-C."""
    words = sys.argv[1:] if words is None else words
    if words[:1] != ["map"]:
        run_command(words)
    given = parser().parse_args(words[1:])
    try:
        map_states(given)
    except KeyboardInterrupt:
        print("axode map: interrupted; the same command continues from there", file=sys.stderr)
        return 130
    except axode.ModelError as error:
        for fault in error.faults:
            print(fault, file=sys.stderr)
        return 1
    except (ArithmeticError, ImportError, KeyError, OSError, RuntimeError, TypeError, ValueError) as error:
        sentence = error.args[0] if isinstance(error, KeyError) else error
        print(f"axode map: {str(sentence).replace('overwrite=True', '--overwrite')}", file=sys.stderr)
        return 2 if isinstance(error, (KeyError, TypeError)) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
