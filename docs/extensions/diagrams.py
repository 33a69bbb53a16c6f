"""Draws the diagrams of Mermaid when the site is built, so that the site has them as pictures."""

import mermaidx
from docutils import nodes
from docutils.parsers.rst import Directive


class Mermaid(Directive):
    """A fenced block of the language `mermaid`."""

    has_content = True

    def run(self):
        drawn = mermaidx.render("\n".join(self.content)).svg()
        return [nodes.raw("", f'<div class="diagram">{drawn}</div>', format="html")]


def setup(app):
    app.add_directive("mermaid", Mermaid)
    return {"parallel_read_safe": True}
