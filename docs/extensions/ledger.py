"""The paper's equations as tables, from tests/paper/equations.tsv and the comments of the tests."""

import csv
import re
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective

SOURCE = Path(__file__).resolve().parents[2]
LEDGER = SOURCE / "tests/paper/equations.tsv"
STATES = {"holds": "", "erratum": " *corrected*"}


def line_of(file, text):
    """The number of the first line of a file whose code contains a text."""
    word = re.compile(rf"(?<!\w){re.escape(text)}(?!\w)")
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        if word.search(line) and not line.lstrip().startswith("//"):
            return number
    raise LookupError(f"{file.relative_to(SOURCE)} has no code {text!r}, which {LEDGER.name} names")


def tests():
    """Test -> (file, line, text of the comment above it)."""
    found = {}
    for file in sorted((SOURCE / "tests/paper").glob("section_*.cpp")) + sorted((SOURCE / "tests/paper").glob("appendix_*.cpp")):
        lines = file.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines, start=1):
            if test := re.match(r"TEST\(Paper, (\w+)\)", line):
                first = number - 1
                while lines[first - 1].startswith("// "):
                    first -= 1
                found[test[1]] = (file, number, " ".join(line[3:] for line in lines[first:number - 1]))
    return found


class Ledger(SphinxDirective):
    """A table for each section of the paper."""

    def run(self):
        with LEDGER.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream, delimiter="\t", quoting=csv.QUOTE_NONE))
        known = tests()
        self.env.note_dependency(str(LEDGER))
        sections = dict.fromkeys(row["section"] for row in rows)
        return [self.section(name, [row for row in rows if row["section"] == name], known) for name in sections]

    def section(self, name, rows, known):
        title = f"Appendix {name}" if name[0].isalpha() else f"Section {name}"
        table, numbers = ["| equation | what holds | code, test |", "|---|---|---|"], []
        for row in rows:
            file, line, comment = known[row["test"]]
            code, text = row["code"].split(":", 1)
            formula = re.sub(r"([\\*_|\[\]<`])", r"\\\1", comment or row["meaning"])
            table.append(f"| `{row['id']}`{STATES[row['status']]} | {formula} | [{code}](../axode/{code}), "
                         f"[{row['test']}](../{file.relative_to(SOURCE)}) |")
            numbers += [line_of(SOURCE / "axode" / code, text), line]
        section = nodes.section(ids=[nodes.make_id(title)], names=[title.lower()])
        section += nodes.title(title, title)
        section += nodes.container("", *self.parse_text_to_nodes("\n".join(table)), classes=["paper"])
        for link, number in zip(section.findall(addnodes.download_reference), numbers, strict=True):
            link["line"] = number
        return section


def setup(app):
    app.add_directive("ledger", Ledger)
    return {"parallel_read_safe": True}
