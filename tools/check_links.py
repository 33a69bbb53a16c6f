"""Every relative link in the Markdown files of the repository leads to a file that exists, and every `#anchor`
to a heading in it; or, of a site that `make docs` has built, every link of every page to a page and an element of it, and
nothing is loaded from elsewhere: check_links.py [SITE]. Links to the web are not followed."""

import re
import sys
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

SOURCE = Path(__file__).resolve().parents[1]
LINK = re.compile(r"\[[^\]]*\]\(\s*<?([^)\s>]+)>?[^)]*\)")
CODE = re.compile(r"^(```|~~~).*?^\1|`[^`\n]*`", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+\s+(.*?)\s*#*$", re.MULTILINE)


def anchors(text):
    """Anchors of the headings, by the rule of the common Markdown viewers."""
    found = set()
    for heading in HEADING.findall(re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)):
        anchor = re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()).replace(" ", "-")
        repeated = sum(1 for other in found if re.fullmatch(re.escape(anchor) + r"(-\d+)?", other))
        found.add(f"{anchor}-{repeated}" if repeated else anchor)
    return found


def broken_links(file):
    text = file.read_text(encoding="utf-8")
    for link in LINK.findall(CODE.sub("", text)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = file.parent / path if path else file
        if not target.exists():
            yield f"{file.relative_to(SOURCE)}: no such file: {link}"
        elif anchor and target.suffix == ".md" and anchor not in anchors(target.read_text(encoding="utf-8")):
            yield f"{file.relative_to(SOURCE)}: no such heading: {link}"


class Page(HTMLParser):
    """The links of a page, the files that it loads, and the anchors in it."""

    LOADS = {"script": "src", "img": "src", "iframe": "src", "source": "src", "link": "href"}

    def __init__(self, file):
        super().__init__()
        self.links, self.loads, self.anchors = [], [], set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors |= {found[key] for key in ("id", "name") if found.get(key)}
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        if found.get(self.LOADS.get(tag)):
            self.loads.append(found[self.LOADS[tag]])


@lru_cache(maxsize=None)
def page_of(file):
    return Page(file)


def broken_links_of_page(file, site):
    page, name = page_of(file), file.relative_to(site)
    yield from (f"{name}: loads from elsewhere: {load}" for load in page.loads if re.match(r"(https?:)?//", load))
    for link in page.links + page.loads:
        path, _, anchor = unquote(link).partition("#")
        if re.match(r"[a-z]+:|//", link) or path.startswith("?"):
            continue
        target = file.parent / path.partition("?")[0] if path else file
        if not target.is_file():
            yield f"{name}: no such file: {link}"
        elif anchor and target.suffix == ".html" and anchor not in page_of(target).anchors:
            yield f"{name}: no such element: {link}"


def broken_in_site(site):
    files = sorted(site.rglob("*.html"))
    yield from (fault for file in files for fault in broken_links_of_page(file, site))
    for sheet in sorted(site.rglob("*.css")):
        for load in re.findall(r"(?:url\(|@import )[\s'\"]*((?:https?:)?//[^)'\"]*)", sheet.read_text(encoding="utf-8")):
            yield f"{sheet.relative_to(site)}: loads from elsewhere: {load}"


def main():
    if len(sys.argv) > 1:
        site = Path(sys.argv[1]).resolve()
        broken = list(broken_in_site(site))
        print("\n".join(broken) or f"all links of {sum(1 for _ in site.rglob('*.html'))} pages lead somewhere")
        return 1 if broken else 0
    files = [file for file in sorted(SOURCE.rglob("*.md")) if file.relative_to(SOURCE).parts[0] != "build"]
    broken = [fault for file in files for fault in broken_links(file)]
    print("\n".join(broken) or f"all links of {len(files)} files lead somewhere")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
