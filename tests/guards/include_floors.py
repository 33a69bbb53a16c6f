"""Files of axode/ include only files of their own floor (a folder such as lie/) or of a floor before it, and
docs/architecture.md lists every folder of axode/ in the order of the floors: include_floors.py SOURCE_DIR."""

import re
import sys
import tempfile
from pathlib import Path

FLOORS = ["lie", "scalar", "model", "table", "recursion", "fast", "kinematics", "dynamics", "derivatives", "workspace",
          "constraints", "contact", "drives", "integration", "catalog", "io", "view", "fmi", "batch", "codegen"]
# Headers of axode/ that gather several floors.
OWN_CEILING = {"axode.hpp": "batch", "dense.hpp": "dynamics", "eigen.hpp": "dynamics"}
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


def differences(folders, page):
    """Sentences that say where the floors of docs/architecture.md and the folders of axode/ are not those of FLOORS."""
    listed = re.findall(r"^axode/(\w+)/ ", page, re.MULTILINE)
    if listed != FLOORS:
        yield f"docs/architecture.md lists the floors {', '.join(listed)}; FLOORS are {', '.join(FLOORS)}"
    if sorted(folders) != sorted(FLOORS):
        yield f"the folders of axode/ are {', '.join(sorted(folders))}; FLOORS are {', '.join(sorted(FLOORS))}"


def check_that_a_planted_violation_is_found():
    with tempfile.TemporaryDirectory() as folder:
        lie = Path(folder, "axode", "lie")
        lie.mkdir(parents=True)
        (lie / "se3.hpp").write_text('#include "axode/lie/so3.hpp"\n#include "axode/model/model.hpp"\n')
        planted = violations(Path(folder))
        assert planted == ["axode/lie/se3.hpp (floor lie) includes axode/model/model.hpp (floor model)"], planted


def main(source):
    check_that_a_planted_violation_is_found()
    source = Path(source)
    page = (source / "docs/architecture.md").read_text(encoding="utf-8")
    folders = [folder.name for folder in (source / "axode").iterdir() if folder.is_dir()]
    planted = list(differences([*folders, "attic"], page.replace("axode/io/ ", "axode/attic/ ")))
    assert len(planted) == 2, planted
    found = [*violations(source), *differences(folders, page)]
    print("\n".join(found) or "every include follows the floors, and docs/architecture.md lists them")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
