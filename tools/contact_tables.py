"""Computes how far motions with contact are from the law, beside MuJoCo, and refreshes the tables of the page.

    build/venv/bin/python tools/contact_tables.py                     # prints the tables, and writes nothing
    build/venv/bin/python tools/contact_tables.py docs/contact.md

Exits with 1 if a number of axode exceeds its bound. The cases are functions in tests/validation. Tables stand between
`<!-- name -->` and `<!-- end -->`. Without MuJoCo its columns are empty. It needs SciPy.
"""

import argparse
import importlib.util
import sys
from pathlib import Path

import numpy as np
import page
import validation  # noqa: F401 - it finds tests/validation

import contact_cases  # noqa: E402
import contact_events  # noqa: E402
import contact_laws  # noqa: E402

MUJOCO = importlib.util.find_spec("mujoco") is not None
#: Largest certificate of a step, and of energy made in a step without restitution as a part of the energy.
CERTIFICATE, ENERGY = 1e-9, 1e-12
#: Largest error of the time of an event of the exact mode, s.
TIME = 1e-12


def number(x):
    """2e-5."""
    return "0" if x == 0 else "never" if np.isinf(x) else f"{x:.0e}".replace("e-0", "e-").replace("e+00", "")


def with_unit(x, unit):
    return number(x) if np.isinf(x) else f"{number(x)} {unit}"


def table(header, rows, words=1):
    return page.table(header, rows, "-" * words + ":" * (len(header) - words))


def case_rows():
    """A row for each case, and sentences about those that exceed their bounds."""
    rows, failed = [], []
    for name, case in contact_cases.CASES.items():
        print(f"{name} ...", file=sys.stderr, flush=True)
        ours = case.ours()
        if not ours <= case.bound:
            failed.append(f"{name}: {number(ours)} exceeds the bound {number(case.bound)}")
        theirs = {setting: case.theirs(setting) for setting in case.settings} if MUJOCO else {}
        best = min(theirs, key=lambda setting: np.nan_to_num(theirs[setting], nan=np.inf), default="")
        default, nearest = (with_unit(theirs[key], case.unit) if MUJOCO else "" for key in ("default", best))
        rows.append([case.what, default, f"{nearest} ({best})" if MUJOCO else "", with_unit(ours, case.unit)])
    return rows, failed


def order_rows():
    found = {name: contact_laws.errors(name) for name in contact_laws.MOTIONS}
    found[contact_laws.IMPACTS] = contact_laws.errors_of_impacts()
    for name, errors in found.items():
        yield [name, *map(number, errors), f"{np.log2(errors[0] / errors[2]) / 2:.1f}"]


def energy_rows():
    for restitution in (0.0, 0.5, 0.9, 1.0):
        made = [contact_laws.energy_made(restitution, step) for step in (5e-3, 1e-3)]
        yield [f"{restitution:g}", *(number(x / energy) for x, energy in made)]


def certificate_rows():
    for name, found in contact_laws.certificates():
        yield [name, str(len(found)), number(found.max()), str(int((found > CERTIFICATE).sum()))]


def tables():
    """The text of each table by its name, and sentences about numbers that exceed their bounds."""
    rows, failed = case_rows()
    energies, certificates = list(energy_rows()), list(certificate_rows())
    failed += [f"energy at e = 0: {x} exceeds {ENERGY}" for x in energies[0][1:] if float(x) > ENERGY]
    failed += [f"certificate: {row[0]}: {row[2]} exceeds {CERTIFICATE}" for row in certificates
               if float(row[2]) > CERTIFICATE]
    events = [[name, str(count), f"{last:.6f} s", f"{number(error)} s"] for name, count, last, error in contact_events.rows()]
    failed += [f"time of an event: {row[0]}: {row[3]} exceeds {TIME} s" for row in events
               if float(row[3].removesuffix(" s")) > TIME]
    loops = [[f"{1e3 * step:g} ms", number(contact_laws.loops_open(step)[0])] for step in (5e-3, 1e-3)]
    return {
        "cases": table(["what", "MuJoCo, default", "MuJoCo, best", "axode"], rows),
        "order": table(["motion", *(f"{1e3 * step:g} ms" for step in contact_laws.STEPS), "order"], order_rows()),
        "energy": table(["restitution", "5 ms", "1 ms"], energies, 0),
        "events": table(["what", "events", "last one at", "times off by"], events),
        "loops": table(["steps of", "largest residual, m or rad"], loops, 0),
        "certificates": table(["motion", "steps", "largest certificate", f"steps above {number(CERTIFICATE)}"],
                              certificates),
    }, failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=Path, nargs="?", help="the page to refresh, docs/contact.md")
    arguments = parser.parse_args()
    found, failed = tables()
    for name, text in found.items():
        print(f"{name}\n{text}", flush=True)
        if arguments.page:
            page.Page(arguments.page).part(name, text)
    print("\n".join(failed) or "every number is within its bound")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
