"""Prints every message of the library, the command and the Python package: list_messages.py [SOURCE_DIR].

A line is FILE:LINE:, a tab, the type of the exception (or `text`), a tab and the message, in which {} replaces a value.
A text with fewer than three words, and one that contains code, is left out.
"""

import ast
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

FOLDERS = ("axode", "apps", "python")
TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|\#[^\n]*(?:\\\n[^\n]*)*|R"(?P<mark>\w*)\(.*?\)(?P=mark)"|"(?P<text>(?:[^"\\\n]|\\.)*)"|'(?:[^'\\\n]|\\.)+'|[;{}]|\w+|\S""",
    re.DOTALL,
)
WORD = re.compile(r"(?<![\w.\\])[A-Za-z]?[a-z]+(?![\w(=])")


def is_message(text):
    return len(WORD.findall(text)) >= 3 and " " in text and " -> " not in text


class Message(NamedTuple):
    file: str
    line: int
    use: str
    text: str

    def __str__(self):
        return f"{self.file}:{self.line}:\t{self.use}\t{self.text}"


def of_cpp(file, source):
    """The messages of a C++ source. An expression between the `+` signs of one message becomes {}; a comma ends a
    message."""
    code_is_written = file.startswith("axode/codegen/")
    source = re.sub(r"\bfmt::format\(|\b(?:std::)?string\(|\bto_string\(", lambda m: " " * len(m[0]), source)
    pieces, line, use, previous, depth, end = [], 0, "text", "", 0, False

    def finished():
        message = "".join(pieces).replace("{}{}", "{}")
        if is_message(message) and (use != "text" or not code_is_written):
            yield Message(file, line, use, message)

    for token in TOKEN.finditer(source):
        if token[0].startswith(("//", "/*", "#")):
            continue
        if (text := token["text"]) is not None:
            if end:
                yield from finished()
                pieces = []
            end, level = False, depth
            line = line if pieces else source.count("\n", 0, token.start()) + 1
            if previous == "+":
                pieces.append("{}")
            elif previous in "?:" and pieces:
                pieces.append(" / ")
            pieces.append(re.sub(r"\\(.)", lambda c: {"n": " "}.get(c[1], c[1]), text))
        elif token[0] in (";", "{", "}"):
            yield from finished()
            pieces, use, depth, end = [], "text", 0, False
        elif previous == "throw" or (use in ("std", "nb") and previous == ":" and token[0] != ":"):
            use = token[0]
        elif token[0] in "()":
            depth += 1 if token[0] == "(" else -1
        elif token[0] in ",.-":
            end = end or (bool(pieces) and (depth <= level if token[0] == "," else previous == ")"))
        elif token[0] == "+" and previous == '"':
            pieces.append("{}")
        previous = '"' if text is not None else token[0]


def text_of(node):
    """The text of an expression, with {} for values; None if it is not a text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = text_of(node.left), text_of(node.right)
        return None if left is None and right is None else (left or "{}") + (right or "{}")
    return None


def of_python(file, source):
    """The messages of a Python source: its texts apart from docstrings."""

    def visit(node, use):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # a docstring
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            use = ast.unparse(node.exc.func)
        if (text := text_of(node)) is not None:
            if is_message(text):
                yield Message(file, node.lineno, use, " ".join(text.split()))
            return
        for child in ast.iter_child_nodes(node):
            yield from visit(child, use)

    return visit(ast.parse(source), "text")


def messages(source):
    """All messages of a source tree, in the order of its files."""
    listed = subprocess.run(["git", "ls-files", *FOLDERS], cwd=source, check=True, capture_output=True, text=True)
    readers = {".cpp": of_cpp, ".hpp": of_cpp, ".py": of_python}
    return [
        message
        for file in listed.stdout.split()
        if (read := readers.get(Path(file).suffix))
        for message in read(file, (source / file).read_text(encoding="utf-8"))
    ]


if __name__ == "__main__":
    for message in messages(Path(sys.argv[1] if len(sys.argv) > 1 else ".")):
        print(message)
