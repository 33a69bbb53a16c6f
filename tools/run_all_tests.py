"""Builds and tests every configuration that must hold, and counts: what `make test` runs.

The last line reads `N passed, N failed` (and `, N skipped` where some were). Exits with 1 after any failure.
"""

import argparse
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

SOURCE = Path(__file__).resolve().parents[1]


class Stage(NamedTuple):
    preset: str
    ctest: list = []  # which tests
    environment: dict = {}


STAGES = [
    Stage("release"),
    Stage("clang", ctest=["--label-exclude", "laws|peers|package"]),
    Stage("asan", ctest=["--label-exclude", "peers|guards"], environment={"AXODE_RANDOM_TREES": "50"}),
]


def run(*command, environment=None):
    print("+", *command, flush=True)
    return subprocess.run(command, cwd=SOURCE, env={**os.environ, **(environment or {})}).returncode == 0


def outcomes(junit):
    """Name -> passed, failed or skipped. What ctest could not run is skipped only where the test itself said so."""
    found = {}
    for case in ElementTree.parse(junit).getroot().iter("testcase"):
        reason = case.find("skipped")
        if case.get("status") == "run":
            found[case.get("name")] = "passed"
        elif case.get("status") == "disabled" or reason is not None and reason.get("message", "").startswith("SKIP_"):
            found[case.get("name")] = "skipped"
        else:
            found[case.get("name")] = "failed"
    return found


def test(stage, jobs):
    """Outcomes of one stage; a stage that does not build, or finds no test, is one failure."""
    junit = SOURCE / "build" / stage.preset / "tests.xml"
    junit.unlink(missing_ok=True)
    built = run("cmake", "--preset", stage.preset) and run("cmake", "--build", "--preset", stage.preset,
                                                           "--parallel", jobs)
    if not built:
        return {"build": "failed"}
    passed = run("ctest", "--preset", stage.preset, "--parallel", jobs, "--no-tests=error", "--output-junit",
                 str(junit), *stage.ctest, environment=stage.environment)
    results = outcomes(junit) if junit.exists() else {}
    if not passed and "failed" not in results.values():
        results["ctest"] = "failed"
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", default=str(os.cpu_count()))
    parser.add_argument("--only", choices=[stage.preset for stage in STAGES], help="run one configuration")
    arguments = parser.parse_args()

    results = {}
    for stage in STAGES:
        if arguments.only in (None, stage.preset):
            start = time.monotonic()
            results.update({(stage.preset, name): outcome for name, outcome in test(stage, arguments.jobs).items()})
            print(f"{stage.preset}: {time.monotonic() - start:.0f} s\n", flush=True)

    for outcome in ("skipped", "failed"):
        for (preset, name), found in results.items():
            if found == outcome:
                print(f"{outcome}: {preset}: {name}")
    count = {outcome: list(results.values()).count(outcome) for outcome in ("passed", "failed", "skipped")}
    skipped = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{skipped}")
    return 1 if count["failed"] or not count["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())
