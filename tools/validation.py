"""Computes published motions and motions in closed form, and refreshes the tables of the page of evidence.

    build/venv/bin/python tools/validation.py                        # compares, and writes nothing
    build/venv/bin/python tools/validation.py docs/validation.md
    build/venv/bin/python tools/validation.py --only A05 slider_crank

Exits with 1 if a number differs from its reference by more than its bound. The cases are functions in
tests/validation, beside the published numbers. Tables and lists of sources stand between `<!-- name -->` and
`<!-- end -->`. Times are those of the processor. It needs SciPy.
"""

import argparse
import sys
import textwrap
import time
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(SOURCE / "tests/validation"))

import closed_forms  # noqa: E402
import contact  # noqa: E402
import flight  # noqa: E402
import iftomm  # noqa: E402
import ivp  # noqa: E402
import spatial  # noqa: E402
from page import Page, table  # noqa: E402

SECTIONS = {"iftomm": iftomm.CASES, "test set": ivp.CASES, "spatial": spatial.CASES, "flight": flight.CASES,
            "closed forms": closed_forms.CASES, "contact": contact.CASES}
CASES = [name for cases in SECTIONS.values() for name in cases]
HEADER = ["case", "what is compared", "axode, last", "reference, last", "largest error", "bound", "scheme",
          "time, s"]


def compare(name, case):
    """The comparisons of a case with the seconds that each of them took."""
    print(f"{name} ...", file=sys.stderr, flush=True)
    start = time.process_time()
    for comparison in case():
        end = time.process_time()
        yield comparison, end - start
        start = end


def number(x):
    """1.2e-5."""
    return f"{x:.1e}".replace("e-0", "e-")


def row(name, comparison, seconds):
    ours, reference = np.ravel(comparison.ours)[-1], np.ravel(comparison.reference)[-1]
    return [name, comparison.quantity, f"{ours:.10g}", f"{reference:.10g}", number(comparison.error),
            number(comparison.bound), comparison.scheme.name, f"{seconds:.2f}"]


def block(name, found):
    """The table of a section, and a list of the sources of its references."""
    rows = [row(case, *measured) for case, measurements in found.items() for measured in measurements]
    sources = ""
    for case, measurements in found.items():
        for source in dict.fromkeys(comparison.source for comparison, _ in measurements):
            sources += textwrap.fill(f"* {case}: {source}", 110, subsequent_indent="  ",
                                     break_long_words=False, break_on_hyphens=False) + "\n"
    return f"{table(HEADER, rows, '--::::-:')}\n{sources}"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, nargs="?", help="the page to refresh, docs/validation.md")
    parser.add_argument("--only", nargs="+", choices=CASES, metavar="CASE",
                        help=f"cases to compute, and no page: {', '.join(CASES)}")
    arguments = parser.parse_args()
    if arguments.page and arguments.only:
        parser.error("a page has all cases: leave out --only, or the page")

    failed = []
    for section, cases in SECTIONS.items():
        chosen = {name: case for name, case in cases.items() if name in (arguments.only or CASES)}
        found = {name: list(compare(name, case)) for name, case in chosen.items()}
        if found:
            print(f"{section}\n{block(section, found)}", flush=True)
        if arguments.page:
            Page(arguments.page).part(section, block(section, found))
        failed += [f"{name}: {comparison.quantity}: {number(comparison.error)} exceeds the bound "
                   f"{number(comparison.bound)}"
                   for name, measurements in found.items() for comparison, _ in measurements
                   if not comparison.error <= comparison.bound]
    print("\n".join(failed) or "every number is within its bound")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
