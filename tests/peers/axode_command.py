"""The command `axode eval`, and the robots on which it is compared with other libraries."""

import json
import os
import subprocess
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2]
COMMAND = Path(os.environ.get("AXODE_COMMAND") or SOURCE / "build/release/axode")
ROBOTS = Path(os.environ.get("AXODE_ROBOTS") or SOURCE / "../shared/robots")
REPRESENTATIONS = ["body", "spatial", "hybrid", "mixed"]
FREE_BASE = "free_base"


def robots():
    """Every URDF, for pytest.mark.parametrize; where there is none, one skipped parameter that says why."""
    files = sorted(ROBOTS.glob("*.urdf"))
    missing = (f"there is no command {COMMAND}; set AXODE_COMMAND" if not COMMAND.exists() else
               f"there are no URDF files in {ROBOTS}; set AXODE_ROBOTS" if not files else None)
    if missing:
        return [pytest.param(None, id="none", marks=pytest.mark.skip(reason=missing))]
    return [pytest.param(file, id=file.stem) for file in files]


def run_eval(model, state, want, base, representation):
    return subprocess.run([COMMAND, "eval", model, "--state", "-", "--want", want, "--base", base,
                           "--representation", representation, "--format", "json"],
                          input=json.dumps(state), capture_output=True, text=True)


def evaluate(model, state, want, base, representation):
    """The answer of `axode eval` to a state, as its JSON says it."""
    run = run_eval(model, state, ",".join(want), base, representation)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def refusal(model, state, want, base):
    """The sentence with which `axode eval` refuses to answer."""
    run = run_eval(model, state, want, base, "body")
    assert run.returncode == 1 and run.stdout == "", "an answer, not a refusal"
    return run.stderr


def by_joint(answer, vector):
    """A vector of nv numbers as lists of numbers by joint; every joint but a free base has one velocity."""
    values, found = iter(vector), {}
    for joint in answer["joints"]:
        found[joint] = [next(values) for _ in range(6 if joint == FREE_BASE else 1)]
    assert next(values, None) is None
    return found
