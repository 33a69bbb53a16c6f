"""Docstrings are plain text with examples; what reStructuredText would read into them is escaped."""

import re


def as_written(app, what, name, obj, options, lines):
    text, example, indented = [], False, ""
    for line in lines:
        stripped = line.strip()
        if stripped.startswith(">>>"):
            example = True
            if text and text[-1]:
                text.append("")
        elif not stripped:
            example = False
        text.append(line if example else re.sub(r"([\\*_|`])", r"\\\1", line))
    lines[:] = text


def setup(app):
    app.connect("autodoc-process-docstring", as_written)
    return {"parallel_read_safe": True}
