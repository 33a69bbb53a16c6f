"""Checks that the test of each equation of the paper runs the code beside it in tests/paper/equations.tsv.

Every test runs alone in a build that counts the calls of each function (the preset coverage). A row FILE:TEXT
holds if the test calls a function that is defined in FILE, or in the source of the same name, and whose full
name, with the types of its arguments, contains the last word of TEXT. Part of `make nightly`; alone:
  cmake --preset coverage && cmake --build --preset coverage --target test_paper
  python3 tools/ledger_coverage.py
"""

import argparse
import csv
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
PROGRAM = SOURCE / "build/coverage/tests/test_paper"
COUNT = re.compile(r"^  (\S+):\n    Hash: .+\n    Counters: \d+\n    Function count: (\d+)", re.M)


def output_of(*command, **options):
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, **options).stdout


def called_functions(test, folder):
    """The mangled names of the functions that a test calls, and its profile; nothing if it fails."""
    raw, profile = folder / f"{test}.profraw", folder / f"{test}.profdata"
    done = subprocess.run([PROGRAM, f"--gtest_filter=Paper.{test}", "--gtest_brief=1"], cwd=SOURCE,
                          env={**os.environ, "LLVM_PROFILE_FILE": str(raw)}, stdout=subprocess.DEVNULL)
    if done.returncode:
        return set(), None
    output_of("llvm-profdata-14", "merge", "-sparse", raw, "-o", profile)
    raw.unlink()
    counts = COUNT.findall(output_of("llvm-profdata-14", "show", "--all-functions", profile))
    return {name.rpartition(":")[2] for name, count in counts if int(count)}, profile


def definitions(profiles, folder):
    """Mangled name -> file in axode/ that defines the function."""
    merged, found, file = folder / "all.profdata", {}, ""
    output_of("llvm-profdata-14", "merge", "-sparse", *profiles, "-o", merged)
    for line in output_of("llvm-cov-14", "export", "-format=lcov", f"-instr-profile={merged}", PROGRAM,
                          SOURCE / "axode").splitlines():
        if line.startswith("SF:"):
            file = str(Path(line[3:]).relative_to(SOURCE / "axode"))
        elif line.startswith("FN:"):
            found[line.partition(",")[2].rpartition(":")[2]] = file
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    jobs = parser.parse_args().jobs
    with open(SOURCE / "tests/paper/equations.tsv", newline="") as ledger:
        rows = list(csv.DictReader(ledger, delimiter="\t", quoting=csv.QUOTE_NONE))
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(jobs) as pool:
        folder = Path(name)
        calls = list(pool.map(lambda row: called_functions(row["test"], folder), rows))
        file_of = definitions([profile for _, profile in calls if profile], folder)
    full_name = dict(zip(file_of, output_of("llvm-cxxfilt-14", input="\n".join(file_of)).splitlines()))
    missing = 0
    for row, (called, _) in zip(rows, calls):
        file, _, text = row["code"].partition(":")
        word = re.escape(text.split()[-1]).replace("<", "<axode::")
        files = {file, str(Path(file).with_suffix(".cpp"))}
        names = [full_name[f] for f in called & file_of.keys() if file_of[f] in files]
        if not any(re.search(rf"\b{word}\b", name) for name in names):
            missing += 1
            print(f"Paper.{row['test']} fails or does not call {row['code']}")
    print(f"{len(rows) - missing} tests of the ledger run the code that they name, {missing} do not")
    return 1 if missing or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
