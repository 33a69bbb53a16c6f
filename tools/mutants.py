"""Checks that the tests notice mistakes.

Every row of tests/mutants.tsv is one mistake: a file, a text that occurs once in it (\\n is a new line), its
replacement, the test that must fail (a program and a filter of GoogleTest, or a test of pytest) unless a
static_assert fails, and the sources to compile, each perhaps in one representation only (:Hybrid); without
any, the file itself. Part of `make nightly`; alone, for the rows that contain one of the words:
  cmake --preset coverage && cmake --build --preset coverage && python3 tools/mutants.py [WORD...]
Neither the tree nor the build is changed: Clang reads the changed file through an overlay of the file system,
and the objects go into a temporary program. Code in single precision is left as it is.
"""

import argparse
import csv
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import NamedTuple

SOURCE = Path(__file__).resolve().parents[1]
BUILD = SOURCE / "build/coverage"
PYTHON = SOURCE / "build/venv/bin/python"
ENVIRONMENT = {**os.environ, "AXODE_RANDOM_TREES": "20", "LLVM_PROFILE_FILE": "/dev/null"}
SECONDS = 900  # after which a test counts as failed: a mistake may keep a loop from ending


class Mutant(NamedTuple):
    """A row of the table."""

    file: str
    text: str
    replacement: str
    test: str
    sources: str

    @property
    def is_python(self):
        return self.file.startswith("python/")


def read_table():
    with open(SOURCE / "tests/mutants.tsv", newline="") as table:
        rows = list(csv.reader(table, delimiter="\t", quoting=csv.QUOTE_NONE))[1:]
    return [Mutant(*(cell.replace(r"\n", "\n") for cell in row), *[""] * (5 - len(row))) for row in rows]


@cache
def commands():
    """(sources, object, command) of every object in double precision."""
    found = []
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        words = words[next(i for i, word in enumerate(words) if "clang++" in word):]
        target, unit = words[words.index("-o") + 1], Path(entry["file"])
        if "_float.dir" in target or "cmake_pch" in unit.name:
            continue
        is_unity = "Unity" in unit.parts
        paths = re.findall(r'#include "(.+\.cpp)"', unit.read_text()) if is_unity else [unit]
        found.append(({str(Path(path).relative_to(SOURCE)) for path in paths}, target, words))
    return found


def compile_changed(words, overlay, target):
    """Compiles without the precompiled header, which holds the files as they are. Returns the files that were read, as text."""
    words, kept = iter(words), []
    for word in words:
        if word == "-Xclang":
            word = next(words)
            if word == "-include-pch":
                next(words), next(words)
            else:
                kept += ["-Xclang", word]
        elif word in ("-o", "-MT", "-MF"):
            next(words)
        elif word not in ("-MD", "-Werror"):
            kept.append(word)
    command = [*kept, "-w", "-ivfsoverlay", str(overlay), "-MD", "-MF", target + ".d", "-o", target]
    subprocess.run(command, cwd=BUILD, check=True, stderr=subprocess.PIPE, text=True)
    return Path(target + ".d").read_text()


def build_program(mutant, changed, folder, program):
    """Links a program with the changed objects in the place of its own."""
    overlay = folder / "overlay.json"
    roots = [{"type": "file", "name": str(SOURCE / mutant.file), "external-contents": str(changed)}]
    overlay.write_text(json.dumps({"version": 0, "roots": roots}))
    wanted = [source.partition(":")[::2] for source in mutant.sources.split() or [mutant.file]]
    left, objects = {source for source, _ in wanted}, {}
    for sources, target, words in commands():
        is_wanted = any(source in sources and (not only or f"_{only}_" in target) for source, only in wanted)
        if is_wanted and (not target.startswith("tests/") or f"/{program}.dir/" in target):
            objects[target] = str(folder / f"{len(objects)}.o")
            files = compile_changed(words, overlay, objects[target])
            if str(changed) not in files and mutant.file not in files:
                raise ValueError(f"{', '.join(sorted(sources))} does not read it")
            left -= sources
    if left:
        raise ValueError(f"nothing is compiled of {', '.join(sorted(left))}")
    link = subprocess.run(["ninja", "-C", str(BUILD), "-t", "commands", "-s", f"tests/{program}"], check=True,
                          text=True, stdout=subprocess.PIPE).stdout.strip().splitlines()[-1]
    words = shlex.split(link.removeprefix(": && ").removesuffix(" && :"))
    words[words.index("-o") + 1] = str(folder / program)
    first = next(i for i, word in enumerate(words) if word.endswith(".o"))
    # The changed objects come first: a linker takes an inline function from the first object that has it.
    words[first:] = [*objects.values(), *(word for word in words[first:] if word not in objects)]
    subprocess.run(words, cwd=BUILD, check=True)
    return folder / program


def run(*command, **environment):
    return subprocess.run(command, cwd=SOURCE, env={**ENVIRONMENT, **environment}, text=True, errors="replace",
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=SECONDS)


def run_test(test, program=None, package=""):
    if test.startswith("tests/"):
        return run(PYTHON, "-m", "pytest", "-qxp", "no:cacheprovider", test, PYTHONPATH=str(package))
    name, cases = test.split(":", 1)
    return run(program or BUILD / "tests" / name, f"--gtest_filter={cases}", "--gtest_brief=1")


@cache
def passes_unchanged(test):
    """Whether the test has a case, and passes, without any change."""
    done = run_test(test)
    return done.returncode == 0 and bool(re.search(r"\[  PASSED  \] [1-9]|[1-9]\d* passed", done.stdout))


def run_changed(mutant, text, folder):
    """Runs the test on the changed library."""
    if mutant.is_python:
        package = next((SOURCE / "build/venv/lib").glob("python3*/site-packages/axode"))
        shutil.copytree(package, folder / "axode", copy_function=os.symlink)
        changed = folder / Path(mutant.file).relative_to("python")
        changed.unlink()
    else:
        changed = folder / Path(mutant.file).name
    changed.write_text(text.replace(mutant.text, mutant.replacement))
    if mutant.is_python:
        return run_test(mutant.test, package=folder)
    return run_test(mutant.test, build_program(mutant, changed, folder, mutant.test.partition(":")[0]))


def misplaced(mutant):
    """Why the mistake cannot be made, or nothing if it can."""
    file = SOURCE / mutant.file
    times = file.read_text().count(mutant.text) if file.exists() else 0
    if times != 1:
        return f"the text occurs {times} times"
    return "" if mutant.sources or file.suffix != ".hpp" else "a header is compiled with sources, which the row does not name"


def reason_of_escape(mutant):
    """Why the test does not notice the mistake, or nothing if it does."""
    if reason := misplaced(mutant):
        return reason
    text = (SOURCE / mutant.file).read_text()
    if not passes_unchanged(mutant.test):
        return "the test does not pass, or has no case, without the change"
    with tempfile.TemporaryDirectory() as folder:
        try:
            return "" if run_changed(mutant, text, Path(folder)).returncode else "the test passes"
        except subprocess.TimeoutExpired:
            return ""
        except subprocess.CalledProcessError as error:
            messages = error.stderr or ""
            return "" if "static_assert failed" in messages else f"it cannot be built: {error}\n{messages}"
        except ValueError as error:
            return f"it cannot be built: {error}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", metavar="WORD")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--check", action="store_true", help="check only that every text is there, and build nothing")
    arguments = parser.parse_args()
    judge = misplaced if arguments.check else reason_of_escape
    mutants = [mutant for mutant in read_table()
               if not arguments.words or any(word in " ".join(mutant) for word in arguments.words)]
    missed = 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for mutant, reason in zip(mutants, pool.map(judge, mutants)):
            missed += bool(reason)
            if arguments.check and not reason:
                continue
            verdict = f"MISSED ({reason})" if reason else "caught"
            print(f"{verdict}: {mutant.file}: {mutant.text} -> {mutant.replacement}", flush=True)
    print(f"{len(mutants) - missed} mutants {'can be made' if arguments.check else 'caught'}, {missed} missed")
    return 1 if missed or not mutants else 0


if __name__ == "__main__":
    sys.exit(main())
