"""Every kind of joint, of spring and of loop joint is in its table and in the docs, and the places where docs/architecture.md
puts something new exist: kinds.py SOURCE_DIR."""

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


def misplaced(page, source):
    """What the table "Where does a new ... go?" of a page names and the tree does not have: files, folders, and words that
    none of the files and folders of their row has."""
    for row in re.findall(r"^\|.*\|$", page[page.index("## Where does a new ... go?") :], re.MULTILINE)[2:]:
        words = re.findall(r"`([^`]+)`", row)
        places = {word: [p for p in (source / word, source / "axode" / word) if p.exists()] for word in words if "/" in word}
        files = [source / "docs" / page for page in re.findall(r"\(([\w-]+\.md)\)", row)]
        for word, found in places.items():
            if not found:
                yield f"docs/architecture.md: no such place: {word}"
            for place in found:
                files += [file for file in place.rglob("*.*") if file.is_file()] if place.is_dir() else [place]
        text = "".join(file.read_text(encoding="utf-8") for file in files if file.suffix in (".hpp", ".cpp", ".py", ".ts"))
        for word in words:
            if word not in places and not all(re.search(rf"\b{part}\b", text) for part in re.findall(r"\w+", word)):
                yield f"docs/architecture.md: no {word} in the places of its row"


if __name__ == "__main__":
    source = Path(sys.argv[1])

    def read(path):
        return (source / path).read_text(encoding="utf-8")

    found = forgotten(read)
    planted = forgotten(lambda path: re.sub(r"(enum class LoopKind {)", r"\1 slot, // a new one\n", read(path)))
    assert len(planted) == len(found) + 2, planted
    page = read("docs/architecture.md")
    changed = page.replace("`reader_for`", "`reader_of`").replace("`io/load.cpp`", "`io/loads.cpp`")
    places = list(misplaced(page, source))
    planted = list(misplaced(changed, source))
    assert len(planted) == len(places) + 2, planted
    found += places
    print("\n".join(found) or "every kind is in its table and in the docs, and every place of the architecture exists")
    sys.exit(bool(found))
