"""Expressions that mix representations or kinds of quantities do not compile: must_not_compile.py FILE CASE COMPILER
[FLAG...].

A case stands in FILE between `#ifdef CASE  // expect: <part of the compiler's message>` and `#endif`; several parts, of
which one must appear, are separated by ` or `. With the CASE `no_case` the file must compile, so that nothing but
the forbidden expressions is to blame.
"""

import os
import re
import subprocess
import sys
from pathlib import Path


def main(file, case, *compiler):
    run = subprocess.run([*compiler, f"-D{case}", "-fsyntax-only", file], capture_output=True, text=True,
                         env={**os.environ, "LC_ALL": "C"})
    if case == "no_case":
        if run.returncode != 0:
            print(f"{file} does not even compile without its cases:\n{run.stderr}")
        return run.returncode
    expected = re.search(rf"#ifdef {case}  // expect: (.+)", Path(file).read_text(encoding="utf-8"))[1].split(" or ")
    if run.returncode == 0:
        print(f"{file} compiles with {case}, but must not")
        return 1
    if not any(part in run.stderr for part in expected):
        print(f"{file} fails to compile with {case}, but without saying any of {expected}:\n{run.stderr}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
