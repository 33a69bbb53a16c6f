"""The functions of a state as a table, made from the rows of axode.table."""

from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective

import axode


class Functions(SphinxDirective):
    """A table of all functions of a state, or with the option `recorded` of those for which code can be generated."""

    option_spec = {"recorded": directives.flag}

    def run(self):
        recorded = "recorded" in self.options
        lines = ["| function | purpose | arguments |", "|---|---|---|"] if recorded else [
            "| function | purpose | unit of the result | arguments | loops |", "|---|---|---|---|---|"]
        for row in axode.table.ROWS.values():
            if recorded and row.recorded:
                lines.append(f"| `{row.name}` | {row.purpose} | {', '.join(name for name in row.takes if name != 'loads')} |")
            elif not recorded:
                loops = row.counts["loops"][0].replace("_", " ")
                lines.append(f"| `{row.name}` | {row.purpose} | {row.units} | {', '.join(row.takes)} | {loops} |")
        return self.parse_text_to_nodes("\n".join(lines).replace("^", r"\^").replace("_ijk", r"\_ijk"))


def setup(app):
    app.add_directive("functions", Functions)
    return {"parallel_read_safe": True}
