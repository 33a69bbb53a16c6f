"""The files of the repository refer to nothing outside of it: clean_tree.py SOURCE_DIR.

No file contains a path of somebody's machine, no file or folder has a catch-all name, programs for users never look
outside the repository, and no test in C++ depends on a clock.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

CATCH_ALL = {"utils", "util", "common", "helpers", "helper", "misc"}
MACHINE_PATH = re.compile(r"(?<![\w./}-])/(?:work|home|root|Users|tmp|mnt|opt)/\w")
OUTSIDE = re.compile(r"\.\./shared")
CLOCK = re.compile(r"<ctime>|\bclock\(|\w_clock\b")
BUILT = {"build", ".git", "__pycache__"}
FOR_USERS = ("axode/", "apps/", "python/", "examples/", "docs/", "README.md", "Makefile")


def tracked_files(source):
    """Files that git tracks, and new files that it does not ignore. Outside a git checkout, every file that was not
    built."""
    git = subprocess.run(["git", "-C", source, "ls-files", "--cached", "--others", "--exclude-standard", "-z"],
                         capture_output=True, text=True) if (source / ".git").exists() else None
    if git and git.returncode == 0:
        names = [name for name in git.stdout.split("\0") if name]
    else:
        names = [f.relative_to(source).as_posix() for f in source.rglob("*")
                 if f.is_file() and not BUILT.intersection(f.relative_to(source).parts)]
    return sorted(name for name in names if (source / name).is_file())


def faults(source):
    found = []
    for name in tracked_files(source):
        for part in Path(name).parts:
            if part.split(".")[0].lower() in CATCH_ALL:
                found.append(f"{name}: '{part}' says nothing about what is in it")
        text = (source / name).read_bytes().decode("utf-8", errors="replace")
        for number, line in enumerate(text.splitlines(), start=1):
            if MACHINE_PATH.search(line):
                found.append(f"{name}:{number}: path of a machine: {line.strip()[:100]}")
            if name.startswith(FOR_USERS) and OUTSIDE.search(line):
                found.append(f"{name}:{number}: looks outside the repository: {line.strip()[:100]}")
            if name.startswith("tests/") and name.endswith(("pp", ".cu")) and CLOCK.search(line):
                found.append(f"{name}:{number}: depends on a clock: {line.strip()[:100]}")
    return found


def check_that_planted_faults_are_found():
    with tempfile.TemporaryDirectory() as folder:
        docs = Path(folder, "docs")
        docs.mkdir()
        (docs / "helpers.md").write_text("from " + "/".join(["", "home", "somebody"]) + "\nsee ../" + "shared/x\n")
        tests = Path(folder, "tests")
        tests.mkdir()
        (tests / "speed.cpp").write_text("#include <" + "ctime>\n")
        planted = faults(Path(folder))
        assert [fault.split(":")[0:2][-1].strip() for fault in planted] == [
            "'helpers.md' says nothing about what is in it", "1", "2", "1"], planted


def main(source):
    check_that_planted_faults_are_found()
    found = faults(Path(source))
    print("\n".join(found) or "the tree is clean")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
