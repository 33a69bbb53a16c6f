"""Reads pages of the documentation and runs their code in the way in which a reader would."""

import contextlib
import io
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import axode

SOURCE = Path(__file__).resolve().parents[2]


class Block(NamedTuple):
    """A block of code. After its language it may have the name of the file that it shows, or a package that it
    requires."""

    line: int
    language: str
    words: list[str]
    text: str


def blocks(page):
    text = (SOURCE / page).read_text(encoding="utf-8")
    for found in re.finditer(r"^```(\w*)([^\n]*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield Block(text.count("\n", 0, found.start()) + 2, found[1], found[2].split(), found[3])


def printed_by_python(block, page, names):
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile("\n" * (block.line - 1) + block.text, page, "exec"), names)
    return printed.getvalue()


def printed_by_shell(block, environment):
    """Runs the lines that begin with $, and returns their output together with the output that the block shows."""
    lines = block.text.splitlines(keepends=True)
    script = "".join(line[2:] for line in lines if line.startswith("$ "))
    done = subprocess.run(["sh", "-c", script], env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout, "".join(line for line in lines if not line.startswith("$ "))


def run_page(page, environment):
    """Runs the blocks of one page in their order, in the working folder: files, lines for the shell, and one Python
    program."""
    for robot in axode.robots.iterdir():
        shutil.copy(robot, ".")
    names, all_blocks = {"__name__": "__main__"}, list(blocks(page))
    assert "python" in [block.language for block in all_blocks]
    for block, following in zip(all_blocks, [*all_blocks[1:], Block(0, "none", [], "")]):
        if block.language == "python":
            if block.words[:1] == ["requires"] and not hasattr(axode, block.words[1].removeprefix("axode.")):
                continue
            output = following.text if following.language in ("", "text") else ""
            assert printed_by_python(block, page, names) == output, f"{page}:{block.line}"
        elif block.language == "console":
            printed, shown = printed_by_shell(block, environment)
            assert printed == shown, f"{page}:{block.line}"
        elif block.words:
            Path(block.words[0]).write_text(block.text, encoding="utf-8")
