"""Pages of docs/ of which a command writes parts, each between `<!-- name -->` and `<!-- end -->`."""

import re
from pathlib import Path


class Page:
    """A Markdown file with parts to write."""

    def __init__(self, file):
        self.file = file

    def find(self, name):
        """The text of the page, and where a part of it begins and ends."""
        page = self.file.read_text(encoding="utf-8")
        found = list(re.finditer(f"{re.escape(f'<!-- {name} -->')}\n(.*?)<!-- end -->", page, flags=re.DOTALL))
        if len(found) != 1:
            raise SystemExit(f"{self.file}: expected one part between <!-- {name} --> and <!-- end -->, found "
                             f"{len(found)}; the command writes between these lines")
        return page, *found[0].span(1)

    def text(self, name):
        """The text of a part."""
        page, begin, end = self.find(name)
        return page[begin:end]

    def part(self, name, text):
        """Replaces the text of a part."""
        page, begin, end = self.find(name)
        self.file.write_text(page[:begin] + text + page[end:], encoding="utf-8")

    def table(self, name, header, rows):
        """Replaces a part by a table of which all columns but the first hold numbers, and prints it."""
        text = table(header, rows, "-" + ":" * (len(header) - 1))
        self.part(name, text)
        print(f"{name}\n{text}", flush=True)


def table(header, rows, columns):
    """The text of a table. `columns` has a sign for each column: - for words, : for numbers."""
    lines = [header, ["---" if column == "-" else "--:" for column in columns], *rows]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)


def processor():
    """The name of the processor of this machine."""
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return cpu[1] if cpu else "unknown"
