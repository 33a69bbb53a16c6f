"""Every kind of joint, of spring and of loop joint is in its table and in the docs, every method of integration is in
Python, in the help and in the docs, and the places where docs/architecture.md puts something new exist:
kinds.py SOURCE_DIR."""

import re
import sys
from pathlib import Path

# The file of each enumeration, and the other files that
# must name its enumerators, with the text around the name.
DRAWING = ("docs/drawing-format.md", "`{}`")
EVERY_KEY = ("tests/data/good/every_key.toml", '"{}"')
ENUMERATIONS = {
    "JointKind": (
        "axode/model/kinds/joint_kinds.hpp",
        [("axode/model/kinds/joint_kinds.hpp", "{{JointKind::{},"), DRAWING, EVERY_KEY],
    ),
    "Subgroup": (
        "axode/model/subgroup.hpp",
        [
            ("axode/model/subgroup.hpp", "case Subgroup::{}:"),
            ("axode/model/kinds/joint_kinds.hpp", "Subgroup::{},"),
            ("viewer/src/joint_kinds.ts", "\n  {}: {{"),
            ("viewer/test/reference.js", "\n  {}: {{"),
        ],
    ),
    "SpringKind": ("axode/model/springs.hpp", [("axode/model/springs.hpp", "{{SpringKind::{},"), DRAWING]),
    "LoopKind": ("axode/model/loops.hpp", [("axode/model/loops.hpp", "{{LoopKind::{},"), DRAWING, EVERY_KEY]),
}


# The files in which the words of docs/architecture.md are looked up.
SOURCES = (".hpp", ".cpp", ".py", ".ts", ".js", ".cmake", ".json")


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


# The texts that must name every method of integration: a
# file, the beginning and the end of the text in it, and a name.
METHODS = "axode/integration/methods.hpp"
NAMED_METHODS = [
    ("python/axode/simulation.py", "method: Literal[", "]", '"{}"'),
    ("python/axode/simulation.py", '    """Simulates a mechanism', '\n    """', '"{}"'),
    ("apps/commands/simulate.cpp", "simulate_footer", ')";', r"\b{}\b"),
    ("docs/integration.md", "", r"\Z", "`{}`"),
]


def forgotten_methods(read):
    """The methods of integration that a text does not name, and those that Python names and methods.hpp does not have."""
    methods = re.findall(r'\{"(\w+)", \{(?:true|false), detail::', read(METHODS))
    if len(methods) != int(re.search(r"Method>, (\d+)> methods", read(METHODS)).group(1)):
        yield f"{METHODS}: kinds.py reads only the rows {', '.join(methods)} of the table of methods"
    for path, begin, end, words in NAMED_METHODS:
        after = read(path).partition(begin)[2] if begin else read(path)
        text = re.split(end if end == r"\Z" else re.escape(end), after, maxsplit=1)[0]
        for method in methods:
            if not re.search(words.format(method), text):
                yield f"{path} has no {method}, which is a method in {METHODS}"
        if begin.endswith("Literal["):
            for method in set(re.findall(r'"(\w+)"', text)) - set(methods):
                yield f"{path} has the method {method}, which {METHODS} does not have"


def misplaced(page, source):
    """What the section "Where does a new ... go?" of a page names and the tree does not have: files, folders, and words that
    none of the files and folders of their row or list has."""
    section = page.partition("## Where does a new ... go?")[2].partition("\n## ")[0]
    table, *lists = section.split("\n### ")
    for row in re.findall(r"^\|.*\|$", table, re.MULTILINE)[2:] + lists:
        words = re.findall(r"`([^`]+)`", row)
        places = {word: [p for p in (source / word, source / "axode" / word) if p.exists()] for word in words if "/" in word}
        files = [source / "docs" / page for page in re.findall(r"\(([\w-]+\.md)\)", row)]
        for word, found in places.items():
            if not found:
                yield f"docs/architecture.md: no such place: {word}"
            for place in found:
                files += [file for file in place.rglob("*.*") if file.is_file()] if place.is_dir() else [place]
        text = "".join(file.read_text(encoding="utf-8") for file in files if file.suffix in SOURCES)
        for word in words:
            if word not in places and not all(re.search(rf"\b{part}\b", text) for part in re.findall(r"\w+", word)):
                yield f"docs/architecture.md: no {word} in the places of its row"


if __name__ == "__main__":
    source = Path(sys.argv[1])

    def read(path):
        return (source / path).read_text(encoding="utf-8")

    found = forgotten(read)
    planted = forgotten(lambda path: re.sub(r"(enum class LoopKind {)", r"\1 slot, // a new one\n", read(path)))
    assert len(planted) == len(found) + 3, planted
    methods = list(forgotten_methods(read))
    planted = list(forgotten_methods(lambda path: read(path).replace('{"euler", ', '{"heun", ')))
    assert len(planted) == len(methods) + len(NAMED_METHODS) + 1, planted
    page = read("docs/architecture.md")
    changed = page.replace("`reader_for`", "`reader_of`").replace("`io/load.cpp`", "`io/loads.cpp`")
    changed = changed.replace("`with_subgroup`", "`by_subgroup`")
    places = list(misplaced(page, source))
    planted = list(misplaced(changed, source))
    assert len(planted) == len(places) + 3, planted
    found += methods + places
    print("\n".join(found) or "every kind and method is in its table and in the docs, and the places of new things exist")
    sys.exit(bool(found))
