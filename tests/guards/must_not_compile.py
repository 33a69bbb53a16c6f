"""Expressions that mix representations or kinds of quantities do not compile: must_not_compile.py FILE COMPILER
[FLAG...].

A case stands in FILE between `#ifdef CASE  // expect: <part of the compiler's message>` and `#endif`; several parts, of
which one must appear, are separated by ` or `. Without its cases FILE must compile, so that nothing but the forbidden
expressions is to blame. The headers of FILE are compiled once, into a folder for temporary files.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def fault(case, expected, run):
    """What is wrong with an attempt to compile a case, or nothing."""
    if run.returncode == 0:
        return f"compiles with {case}, but must not"
    if not any(part in run.stderr for part in expected.split(" or ")):
        return f"fails to compile with {case}, but without saying any of {expected.split(' or ')}:\n{run.stderr}"
    return None


def main(file, *compiler):
    text = Path(file).read_text(encoding="utf-8")
    cases = re.findall(r"^#ifdef (\w+)  // expect: (.+)", text, re.MULTILINE)
    if not cases or len(cases) != text.count("#ifdef"):
        print(f"{file} has {text.count('#ifdef')} cases, of which {len(cases)} say what to expect")
        return 1

    def compiled(*words):
        return subprocess.run([*compiler, *words], capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})

    with tempfile.TemporaryDirectory() as folder:
        headers = Path(folder, "headers.hpp")
        headers.write_text("".join(re.findall(r"^#include .*\n", text, re.MULTILINE)))
        run = compiled("-x", "c++-header", str(headers), "-o", f"{headers}.gch")  # which Clang finds as well
        check = ["-include", str(headers), "-fsyntax-only", file]
        if run.returncode == 0:
            run = compiled(*check)
        if run.returncode != 0:
            print(f"{file} does not even compile without its cases:\n{run.stderr}")
            return 1
        faults = [fault(case, expected, compiled(f"-D{case}", *check)) for case, expected in cases]
    for found in filter(None, faults):
        print(f"{file} {found}")
    return int(any(faults))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
