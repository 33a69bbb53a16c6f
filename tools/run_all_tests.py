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
PYTHON = SOURCE / "build/venv/bin/python"


class Stage(NamedTuple):
    preset: str
    ctest: list = []  # which tests
    environment: dict = {}


STAGES = [
    Stage("release"),
    Stage("clang", ctest=["--label-exclude", "peers|package"]),
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


def test_python():
    """Outcomes of the Python package's tests; skipped where `make venv` could not make an environment."""
    if not PYTHON.exists():
        return {"package": "skipped"}
    if not run("make", "python"):
        return {"package": "failed"}
    junit = SOURCE / "build/python/tests.xml"
    junit.unlink(missing_ok=True)
    passed = run(str(PYTHON), "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", "--junit-xml", str(junit),
                 "tests/python")
    results = {}
    for case in ElementTree.parse(junit).getroot().iter("testcase") if junit.exists() else []:
        wrong = case.find("failure") is not None or case.find("error") is not None
        results[f"{case.get('classname')}.{case.get('name')}"] = (
            "failed" if wrong else "skipped" if case.find("skipped") is not None else "passed")
    if not passed and "failed" not in results.values():
        results["pytest"] = "failed"
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", default=str(os.cpu_count()))
    runs = {stage.preset: lambda stage=stage: test(stage, arguments.jobs) for stage in STAGES}
    runs["python"] = test_python  # after release, whose objects the compiler cache gives it
    parser.add_argument("--only", choices=runs, help="run one configuration, or the tests of the Python package")
    arguments = parser.parse_args()

    results = {}
    for name, test_all in runs.items():
        if arguments.only in (None, name):
            start = time.monotonic()
            results.update({(name, case): outcome for case, outcome in test_all().items()})
            print(f"{name}: {time.monotonic() - start:.0f} s\n", flush=True)

    for outcome in ("skipped", "failed"):
        for (configuration, case), found in results.items():
            if found == outcome:
                print(f"{outcome}: {configuration}: {case}")
    count = {outcome: list(results.values()).count(outcome) for outcome in ("passed", "failed", "skipped")}
    skipped = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{skipped}")
    return 1 if count["failed"] or not count["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())
