"""Expressions that mix representations or kinds of quantities do not compile: must_not_compile.py FILE COMPILER
[FLAG...].

A case stands in FILE between `#ifdef CASE  // expect: <part of the compiler's message>` and `#endif`; several parts, of
which one must appear, are separated by ` or `. Without its cases FILE must compile, so that nothing but the forbidden
expressions is to blame. With all its cases each must have an error of its own, at its lines or required from them.
"""

import os
import re
import subprocess
import sys
from pathlib import Path


def errors(messages):
    """The errors in the messages of a compiler, each with what it was required from before it and its notes after it."""
    found, has_error = [""], False
    for line in messages.splitlines(keepends=True):
        is_error = " error: " in line
        if has_error and (is_error or re.match(r"In file included from|\S+: In ", line)):
            found.append("")
            has_error = False
        found[-1] += line
        has_error |= is_error
    return found


def fault(name, case, expected, own):
    """What is wrong with the errors of a case, or nothing."""
    if not own:
        return f"{name} compiles with {case}, but must not"
    if not any(part in error for part in expected.split(" or ") for error in own):
        return f"{name} fails to compile with {case}, but without saying any of {expected.split(' or ')}:\n{''.join(own)}"
    return None


def main(file, *compiler):
    lines = Path(file).read_text(encoding="utf-8").splitlines()
    starts = [k for k, line in enumerate(lines, 1) if line.startswith("#ifdef")]
    cases = [(*match.groups(), k) for k in starts if (match := re.match(r"#ifdef (\w+)  // expect: (.+)", lines[k - 1]))]
    if not cases or len(cases) != len(starts):
        print(f"{file} has {len(starts)} cases, of which {len(cases)} say what to expect")
        return 1

    def compiled(*words):
        return subprocess.run([*compiler, "-fsyntax-only", "-fmax-errors=0", *words, file], capture_output=True, text=True,
                              env={**os.environ, "LC_ALL": "C"})

    run = compiled()
    if run.returncode != 0:
        print(f"{file} does not even compile without its cases:\n{run.stderr}")
        return 1
    found = errors(compiled(*(f"-D{case}" for case, *_ in cases)).stderr)
    faults = []
    for case, expected, start in cases:
        end = lines.index("#endif", start)
        own = [error for error in found
               if any(start < int(line) <= end for line in re.findall(rf"^{re.escape(file)}:(\d+):", error, re.MULTILINE))]
        faults.append(fault(file, case, expected, own))
    for message in filter(None, faults):
        print(message)
    return int(any(faults))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
