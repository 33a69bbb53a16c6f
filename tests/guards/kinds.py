"""Every kind of joint, of spring and of loop joint is in its table and in the docs: kinds.py SOURCE_DIR."""

import re
import sys
from pathlib import Path

# The file of each enumeration, and the other files that
# must name its enumerators, with the text around the name.
DRAWING = ("docs/drawing-format.md", "`{}`")
ENUMERATIONS = {
    "JointKind": (
        "axode/model/description.hpp",
        [("axode/model/kinds/joint_kinds.hpp", "{{JointKind::{},"), DRAWING],
    ),
    "Subgroup": (
        "axode/model/subgroup.hpp",
        [("axode/model/subgroup.hpp", "case Subgroup::{}:"), ("axode/model/kinds/joint_kinds.hpp", "Subgroup::{},")],
    ),
    "SpringKind": ("axode/model/springs.hpp", [("axode/model/springs.hpp", "{{SpringKind::{},"), DRAWING]),
    "LoopKind": ("axode/model/loops.hpp", [("axode/model/loops.hpp", "{{LoopKind::{},"), DRAWING]),
}


def enumerators(name, text):
    body = re.search(rf"enum class {name}\b[^{{]*{{(.*?)}};", text, re.DOTALL).group(1)
    return re.findall(r"\w+", re.sub(r"//.*", "", body))


def forgotten(read):
    """The kinds that are missing in a file; read(path) returns the text of a file."""
    return [
        f"{path} has no {words.format(kind)}, which {name} has in {home}"
        for name, (home, places) in ENUMERATIONS.items()
        for kind in enumerators(name, read(home))
        for path, words in places
        if words.format(kind) not in read(path)
    ]


if __name__ == "__main__":
    source = Path(sys.argv[1])

    def read(path):
        return (source / path).read_text(encoding="utf-8")

    found = forgotten(read)
    planted = forgotten(lambda path: re.sub(r"(enum class LoopKind {)", r"\1 slot, // a new one\n", read(path)))
    assert len(planted) == len(found) + 2, planted
    print("\n".join(found) or "every kind is in its table and in the docs")
    sys.exit(bool(found))
