"""Files of axode/ include only files of their own floor (a folder such as lie/) or of a lower floor:
include_floors.py SOURCE_DIR."""

import re
import sys
import tempfile
from pathlib import Path

FLOORS = ["lie", "scalar", "model", "table", "recursion", "fast", "kinematics", "dynamics", "derivatives", "constraints",
          "contact", "drives", "integration", "catalog", "io", "view", "fmi", "batch", "codegen"]
# Files and folders of axode/ that gather several floors.
OWN_CEILING = {"axode.hpp": "batch", "dense.hpp": "dynamics", "eigen.hpp": "dynamics", "workspace": "derivatives"}
INCLUDE = re.compile(r'^\s*#\s*include\s*["<](axode/[^">]+)[">]', re.MULTILINE)


def floor_of(path):
    """Number of the floor of `axode/<floor>/...` or of the light header `axode/<floor>.hpp`."""
    first = Path(path).parts[1]
    name = OWN_CEILING.get(first, first.removesuffix(".hpp"))
    return FLOORS.index(name) if name in FLOORS else None


def violations(source):
    found = []
    for file in sorted((source / "axode").rglob("*")):
        if not file.name.endswith((".hpp", ".cpp", ".cpp.in")):
            continue
        name = file.relative_to(source).as_posix()
        own = floor_of(name)
        if own is None:
            found.append(f"{name} belongs to no floor ({', '.join(FLOORS)})")
            continue
        for included in INCLUDE.findall(file.read_text(encoding="utf-8")):
            theirs = floor_of(included)
            if theirs is None:
                found.append(f"{name} includes {included}, which belongs to no floor")
            elif theirs > own:
                found.append(f"{name} (floor {FLOORS[own]}) includes {included} (floor {FLOORS[theirs]})")
    return found


def check_that_a_planted_violation_is_found():
    with tempfile.TemporaryDirectory() as folder:
        lie = Path(folder, "axode", "lie")
        lie.mkdir(parents=True)
        (lie / "se3.hpp").write_text('#include "axode/lie/so3.hpp"\n#include "axode/model/model.hpp"\n')
        planted = violations(Path(folder))
        assert planted == ["axode/lie/se3.hpp (floor lie) includes axode/model/model.hpp (floor model)"], planted


def main(source):
    check_that_a_planted_violation_is_found()
    found = violations(Path(source))
    print("\n".join(found) or "every include follows the floors")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
