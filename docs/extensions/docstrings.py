"""Prepares docstrings for Sphinx: they are plain text with examples, and belong to functions of a compiled module."""

import re

from sphinx.util import inspect

ARGUMENT = re.compile(r"\w+(, \w+| and \w+)*( \(.*?\))*: ")  # what begins the words about arguments, which hang
LONG = {"numpy.typing.ArrayLike": "ArrayLike", "numpy.typing.NDArray[numpy.float64]": "NDArray", "collections.abc.": "",
        "axode._axode.": "", "typing.": ""}


def literal(line):
    """A line of plain text in which only `code` has a special meaning."""
    parts = line.split("`")
    return "".join(f"``{part}``" if k % 2 and k + 1 < len(parts) else re.sub(r"([\\*_|])", r"\\\1", part)
                   for k, part in enumerate(parts))


def as_written(app, what, name, obj, options, lines):
    text, verbatim, hangs = [], False, False
    for line in lines:
        begins = not text or not text[-1]
        if not line:
            verbatim = hangs = False
        elif line.startswith(">>>") and not verbatim:
            verbatim = True
            text.append("")
        elif begins and line.startswith(" "):
            verbatim = True
            text += ["::", ""]
        elif not begins and (ARGUMENT.match(line) or hangs and not line.startswith(" ")):
            text.append("")
        hangs = not verbatim and not begins and line.startswith(" ")
        text.append(line if verbatim or not line else literal(line.strip()))
    lines[:] = text


def short_signature(app, what, name, obj, options, signature, returns):
    def short(words):
        for long, word in LONG.items():
            words = words and words.replace(long, word)
        return words

    compiled = type(obj).__name__ in ("nb_func", "nb_method")
    return re.sub(r"^\(self(, )?", "(", short(signature)) if compiled and signature else short(signature), short(returns)


def setup(app):
    python_routine = inspect.isroutine
    inspect.isroutine = lambda obj: type(obj).__name__ == "nb_func" or python_routine(obj)
    app.connect("autodoc-process-docstring", as_written)
    app.connect("autodoc-process-signature", short_signature)
    return {"parallel_read_safe": True}
