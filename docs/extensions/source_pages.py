"""Makes pages of the site that show files of the repository, for links to files that are no pages themselves."""

import posixpath
from pathlib import Path
from urllib.parse import unquote

from docutils import nodes
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_for_filename, TextLexer
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.transforms import SphinxTransform
from sphinx.util import logging
from sphinx.util.osutil import relative_uri

SOURCE = Path(__file__).resolve().parents[2]
PICTURES = {".svg", ".png"}
logger = logging.getLogger(__name__)


def page_of(path):
    """The name of the page that shows a file or folder of the repository."""
    return posixpath.join("source", path.relative_to(SOURCE).as_posix() + ("/index" if path.is_dir() else ""))


class LinksToSources(SphinxTransform):
    """Changes links to files of the repository before Sphinx takes them for downloads. A link may have a `line`."""

    default_priority = 1

    def apply(self):
        here = Path(self.env.doc2path(self.env.docname)).parent
        links = [(link, here / unquote(link["reftarget"])) for link in self.document.findall(addnodes.download_reference)]
        for link in self.document.findall(addnodes.pending_xref):
            target = here / unquote(link["reftarget"])
            if link.get("reftype") == "myst" and target.is_dir():
                links.append((link, target))
            elif link.get("refdomain") == "doc" and link["reftarget"].startswith("/"):  # Markdown outside the site
                links.append((link, target.with_suffix(".md")))
        for link, path in [(link, path.resolve()) for link, path in links]:
            if not path.exists() or not path.is_relative_to(SOURCE):
                logger.warning("no such file in the repository: %s", link["reftarget"], location=link)
                continue
            shown = nodes.reference("", "", *link.children, internal=True, refuri="")
            shown["source_page"], shown["anchor"] = page_of(path), f"#L-{link['line']}" if "line" in link else ""
            self.env.source_pages.setdefault(self.env.docname, set()).add(path)
            link.replace_self(shown)


def resolve(app, doctree, docname):
    for link in doctree.findall(nodes.reference):
        if "source_page" in link:
            link["refuri"] = relative_uri(app.builder.get_target_uri(docname), link["source_page"] + ".html") + link["anchor"]


def with_contents(paths):
    """The files that are shown; for a folder, all files in it too."""
    found = set()
    for path in paths:
        found |= {path, *(with_contents(sorted(path.iterdir())) if path.is_dir() else ())}
    return found


def shown(path):
    """The body of the page that shows a file or folder."""
    if path.is_dir():
        rows = "".join(f'<li><a href="{relative_uri(page_of(path) + ".html", page_of(part) + ".html")}">{part.name}</a></li>'
                       for part in sorted(path.iterdir())
                       if part.name != "__pycache__" and part.suffix not in PICTURES)
        return f"<ul>{rows}</ul>"
    text = path.read_text(encoding="utf-8")
    try:
        lexer = get_lexer_for_filename(path.name)
    except ClassNotFound:
        lexer = TextLexer()
    return highlight(text, lexer, HtmlFormatter(linenos="inline", lineanchors="L", anchorlinenos=True))


def pages(app):
    wanted = set().union(*app.env.source_pages.values())
    for path in sorted(with_contents(wanted)):
        if path.suffix not in PICTURES and "__pycache__" not in path.parts:
            name = path.relative_to(SOURCE).as_posix()
            yield page_of(path), {"title": name, "body": f"<h1>{name}</h1>{shown(path)}"}, "page.html"


def start(app, env, docnames):
    if not hasattr(env, "source_pages"):
        env.source_pages = {}


def forget(app, env, docname):
    getattr(env, "source_pages", {}).pop(docname, None)


def setup(app):
    app.add_transform(LinksToSources)
    app.connect("env-before-read-docs", start)
    app.connect("env-purge-doc", forget)
    app.connect("doctree-resolved", resolve)
    app.connect("html-collect-pages", pages)
    return {"parallel_read_safe": False}
