"""A file does not compile, for the stated reason: must_not_compile.py FILE COMPILER [FLAG...].

The first line of FILE is `// expect: <part of the compiler's message>`; several parts, of which one must
appear, are separated by ` or `. With -DAXODE_CONTROL the same file must compile, so that nothing but the
forbidden expression is to blame.
"""

import os
import subprocess
import sys
from pathlib import Path


def compile_only(compiler, file):
    run = subprocess.run([*compiler, "-fsyntax-only", file], capture_output=True, text=True,
                         env={**os.environ, "LC_ALL": "C"})
    return run.returncode == 0, run.stderr


def main(file, *compiler):
    first_line = Path(file).read_text(encoding="utf-8").splitlines()[0]
    if not first_line.startswith("// expect: "):
        print(f"{file}: the first line must be `// expect: <part of the compiler's message>`")
        return 1
    expected = first_line.removeprefix("// expect: ").split(" or ")

    compiles, message = compile_only([*compiler, "-DAXODE_CONTROL"], file)
    if not compiles:
        print(f"{file} does not even compile with AXODE_CONTROL:\n{message}")
        return 1
    compiles, message = compile_only(compiler, file)
    if compiles:
        print(f"{file} compiles, but must not")
        return 1
    if not any(part in message for part in expected):
        print(f"{file} fails to compile, but without saying any of {expected}:\n{message}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
